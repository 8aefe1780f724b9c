"""Eight paths at once: explicit vector types for kernels.

`F8`, `I8` and `M8` are LLVM's <8 x double>, <8 x i64> and <8 x i1>. LLVM cuts them to what the
processor has (one AVX-512 register, two of AVX, four of SSE or NEON), and every operation is that
of IEEE 754 in each lane: the bits are the same on all of them, and those of the same formula on
plain numbers. `select`, `any_of`, `root`, `floor` take plain numbers as well, so one kernel source
serves a single path and eight.
"""

import operator
from typing import Any, ClassVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

LANES = 8
I32 = ir.IntType(32)


class Lanes(types.Type):
    """The numba type of eight values in one vector."""

    def __init__(self, name: str, element: ir.Type) -> None:
        self.vector = ir.VectorType(element, LANES)
        super().__init__(name)


F8 = Lanes("F8", ir.DoubleType())
I8 = Lanes("I8", ir.IntType(64))
M8 = Lanes("M8", ir.IntType(1))


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, fe_type.vector)


def _splat(builder, value, kind: Lanes):
    """Return the vector of one value in all lanes."""
    vector = ir.Constant(kind.vector, ir.Undefined)
    vector = builder.insert_element(vector, value, ir.Constant(I32, 0))
    mask = ir.Constant(ir.VectorType(I32, LANES), [0] * LANES)
    return builder.shuffle_vector(vector, ir.Constant(kind.vector, ir.Undefined), mask)


_SCALAR = {F8: types.float64, I8: types.int64, M8: types.boolean}


def _as_lanes(context, builder, value, given, kind: Lanes):
    """Return a value of a given numba type as lanes of a kind."""
    if given == kind:
        return value
    value = context.cast(builder, value, given, _SCALAR[kind])
    return _splat(builder, value, kind)


def _register(function, kind: Lanes, result: Lanes, emit) -> None:
    """Make an operator work on lanes, or on lanes and a number."""
    scalar = _SCALAR[kind]
    pairs = ((kind, kind), (kind, scalar), (scalar, kind))

    class Template(ConcreteTemplate):
        cases: ClassVar = [signature(result, *pair) for pair in pairs]

    infer_global(function)(Template)

    def lower(context, builder, sig, args):
        a, b = (
            _as_lanes(context, builder, v, t, kind) for v, t in zip(args, sig.args, strict=True)
        )
        return emit(builder, a, b)

    for pair in pairs:
        lower_builtin(function, *pair)(lower)


def _register_unary(function, kind: Lanes, emit) -> None:
    class Template(ConcreteTemplate):
        cases: ClassVar = [signature(kind, kind)]

    infer_global(function)(Template)
    lower_builtin(function, kind)(lambda context, builder, sig, args: emit(builder, args[0]))


_B = ir.IRBuilder
for _op, _emit in {
    operator.add: _B.fadd, operator.sub: _B.fsub, operator.mul: _B.fmul, operator.truediv: _B.fdiv,
}.items():  # fmt: skip
    _register(_op, F8, F8, _emit)
for _op, _emit in {
    operator.add: _B.add, operator.sub: _B.sub, operator.mul: _B.mul, operator.and_: _B.and_,
    operator.xor: _B.xor, operator.or_: _B.or_, operator.rshift: _B.lshr, operator.lshift: _B.shl,
}.items():  # fmt: skip
    _register(_op, I8, I8, _emit)
for _op, _emit in {operator.and_: _B.and_, operator.or_: _B.or_, operator.xor: _B.xor}.items():
    _register(_op, M8, M8, _emit)
for _op, _sign in {
    operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">=", operator.eq: "==",
}.items():  # fmt: skip
    _register(_op, F8, M8, lambda b, x, y, sign=_sign: b.fcmp_ordered(sign, x, y))
    _register(_op, I8, M8, lambda b, x, y, sign=_sign: b.icmp_signed(sign, x, y))
_register(operator.ne, I8, M8, lambda b, x, y: b.icmp_signed("!=", x, y))
_register_unary(operator.neg, F8, lambda b, x: b.fneg(x))
_register_unary(operator.invert, M8, lambda b, x: b.not_(x))


def _call(builder, name: str, result, arguments):
    """Call an LLVM intrinsic."""
    kind = ir.FunctionType(result, [a.type for a in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)


def _of_llvm(name: str, lanes: Lanes, scalar: types.Type):
    """Return a function of LLVM, exact or correctly rounded, for a number or eight."""
    letter = "f" if lanes == F8 else "i"

    @intrinsic
    def function(typingctx, x):
        kind = lanes if x == lanes else scalar

        def lower(context, builder, sig, args):
            many = "v8" if kind == lanes else ""
            return _call(builder, f"llvm.{name}.{many}{letter}64", args[0].type, [args[0]])

        return kind(kind), lower

    return function


root = _of_llvm("sqrt", F8, types.float64)
floor = _of_llvm("floor", F8, types.float64)
magnitude = _of_llvm("fabs", F8, types.float64)
#: The 64 bits of a whole number in reverse order.
reversed_bits = _of_llvm("bitreverse", I8, types.uint64)


@intrinsic
def select(typingctx, mask, a, b):
    """Return a where the mask holds, else b: lane by lane, or of plain numbers."""
    kind: Any = next((t for t in (a, b) if isinstance(t, Lanes)), None)
    if mask == M8 and kind is None:
        kind = {types.Float: F8, types.Boolean: M8}.get(type(typingctx.unify_types(a, b)), I8)
    if kind is None:
        kind = typingctx.unify_types(a, b)
        kind = kind if isinstance(kind, types.Float | types.Boolean) else types.int64

    def lower(context, builder, sig, args):
        m, x, y = args
        if isinstance(kind, Lanes):
            x = _as_lanes(context, builder, x, a, kind)
            y = _as_lanes(context, builder, y, b, kind)
        else:
            x, y = context.cast(builder, x, a, kind), context.cast(builder, y, b, kind)
        return builder.select(m, x, y)

    return kind(mask, a, b), lower


@intrinsic
def spread(typingctx, x):
    """Return a number in all lanes."""
    kind = F8 if isinstance(x, types.Float) else I8

    def lower(context, builder, sig, args):
        return _as_lanes(context, builder, args[0], x, kind)

    return kind(x), lower


@intrinsic
def copy_sign(typingctx, size, sign):
    """Return |size| with the sign of the other."""
    kind = F8 if F8 in (size, sign) else types.float64
    name = f"llvm.copysign.{'v8f64' if kind == F8 else 'f64'}"

    def lower(context, builder, sig, args):
        if kind == F8:
            pair = zip(args, sig.args, strict=True)
            args = [_as_lanes(context, builder, v, t, F8) for v, t in pair]
        return _call(builder, name, args[0].type, args)

    return kind(size, sign), lower


@intrinsic
def bits(typingctx, mask):
    """Return the mask as a whole number, lane i in bit i."""

    def lower(context, builder, sig, args):
        if mask != M8:
            return builder.zext(context.cast(builder, args[0], mask, types.boolean), ir.IntType(64))
        return builder.zext(builder.bitcast(args[0], ir.IntType(LANES)), ir.IntType(64))

    return types.int64(mask), lower


@intrinsic
def count_of(typingctx, mask):
    """Return in how many lanes the mask holds."""

    def lower(context, builder, sig, args):
        packed = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.zext(builder.ctpop(packed), ir.IntType(64))

    return types.int64(mask), lower


@intrinsic
def lowest_bit(typingctx, x):
    """Return the number of the lowest bit that is set in a whole number other than 0."""

    def lower(context, builder, sig, args):
        return builder.cttz(args[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(types.int64), lower


@intrinsic
def any_of(typingctx, mask):
    """Return whether the mask holds in any lane."""

    def lower(context, builder, sig, args):
        if mask != M8:
            return args[0]
        packed = builder.bitcast(args[0], ir.IntType(LANES))
        return builder.icmp_unsigned("!=", packed, packed.type(0))

    return types.boolean(mask), lower


def _convert(emit, source: Lanes, result: Lanes):
    @intrinsic
    def function(typingctx, x):
        kind = result if x == source else _SCALAR[result]

        def lower(context, builder, sig, args):
            if x == source:
                return emit(builder, args[0], result.vector)
            return context.cast(builder, args[0], x, kind)

        return kind(x), lower

    return function


#: Toward zero; the value must fit.
whole = _convert(_B.fptosi, F8, I8)
real = _convert(_B.sitofp, I8, F8)
