"""Eight paths at once, or sixteen: explicit vector types for kernels.

`F8`, `I8` and `M8` are LLVM's <8 x double>, <8 x i64> and <8 x i1>; `FLOATS`, `WHOLES` and `MASKS`
have those of sixteen as well. LLVM cuts them to what the processor has (one AVX-512 register, two
of AVX, four of SSE or NEON, for eight), and every operation is that of IEEE 754 in each lane: the
bits are the same on all of them, and those of the same formula on plain numbers. `select`,
`any_of`, `root`, `floor` take plain numbers as well, so one kernel source serves a single path,
eight and sixteen.
"""

import operator
from typing import Any, ClassVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

LANES = 8
#: Two vectors of eight: the processor works on one while the other waits for a division.
WIDE = 16
I32 = ir.IntType(32)


class Lanes(types.Type):
    """The numba type of eight or sixteen values in a vector."""

    def __init__(self, letter: str, element: ir.Type, count: int) -> None:
        self.count = count
        self.vector = ir.VectorType(element, count)
        super().__init__(f"{letter}{count}")


def _kinds(letter: str, element: ir.Type) -> dict[int, Lanes]:
    return {count: Lanes(letter, element, count) for count in (LANES, WIDE)}


#: Kinds of lanes by their count.
FLOATS = _kinds("F", ir.DoubleType())
WHOLES = _kinds("I", ir.IntType(64))
MASKS = _kinds("M", ir.IntType(1))
F8, I8, M8 = FLOATS[LANES], WHOLES[LANES], MASKS[LANES]


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, fe_type.vector)


def _splat(builder, value, kind: Lanes):
    """Return the vector of one value in all lanes."""
    vector = ir.Constant(kind.vector, ir.Undefined)
    vector = builder.insert_element(vector, value, ir.Constant(I32, 0))
    mask = ir.Constant(ir.VectorType(I32, kind.count), [0] * kind.count)
    return builder.shuffle_vector(vector, ir.Constant(kind.vector, ir.Undefined), mask)


_SCALAR = {
    kind: scalar
    for kinds, scalar in (
        (FLOATS, types.float64), (WHOLES, types.int64), (MASKS, types.boolean),
    )
    for kind in kinds.values()
}  # fmt: skip


def _as_lanes(context, builder, value, given, kind: Lanes):
    """Return a value of a given numba type as lanes of a kind."""
    if given == kind:
        return value
    value = context.cast(builder, value, given, _SCALAR[kind])
    return _splat(builder, value, kind)


def _register(function, kinds: dict[int, Lanes], results: dict[int, Lanes], emit) -> None:
    """Make an operator work on lanes, or on lanes and a number."""
    for count, kind in kinds.items():
        _register_pairs(function, kind, results[count], emit)


def _register_pairs(function, kind: Lanes, result: Lanes, emit) -> None:
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


def _register_unary(function, kinds: dict[int, Lanes], emit) -> None:
    class Template(ConcreteTemplate):
        cases: ClassVar = [signature(kind, kind) for kind in kinds.values()]

    infer_global(function)(Template)
    for kind in kinds.values():
        lower_builtin(function, kind)(lambda context, builder, sig, args: emit(builder, args[0]))


_B = ir.IRBuilder
for _op, _emit in {
    operator.add: _B.fadd, operator.sub: _B.fsub, operator.mul: _B.fmul, operator.truediv: _B.fdiv,
}.items():  # fmt: skip
    _register(_op, FLOATS, FLOATS, _emit)
for _op, _emit in {
    operator.add: _B.add, operator.sub: _B.sub, operator.mul: _B.mul, operator.and_: _B.and_,
    operator.xor: _B.xor, operator.or_: _B.or_, operator.rshift: _B.lshr, operator.lshift: _B.shl,
}.items():  # fmt: skip
    _register(_op, WHOLES, WHOLES, _emit)
for _op, _emit in {operator.and_: _B.and_, operator.or_: _B.or_, operator.xor: _B.xor}.items():
    _register(_op, MASKS, MASKS, _emit)
for _op, _sign in {
    operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">=", operator.eq: "==",
}.items():  # fmt: skip
    _register(_op, FLOATS, MASKS, lambda b, x, y, sign=_sign: b.fcmp_ordered(sign, x, y))
    _register(_op, WHOLES, MASKS, lambda b, x, y, sign=_sign: b.icmp_signed(sign, x, y))
_register(operator.ne, WHOLES, MASKS, lambda b, x, y: b.icmp_signed("!=", x, y))
_register_unary(operator.neg, FLOATS, lambda b, x: b.fneg(x))
_register_unary(operator.invert, MASKS, lambda b, x: b.not_(x))


def _call(builder, name: str, result, arguments):
    """Call an LLVM intrinsic."""
    kind = ir.FunctionType(result, [a.type for a in arguments])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), arguments)


def _of_llvm(name: str, letter: str, scalar: types.Type):
    """Return a function of LLVM, exact or correctly rounded, for a number or lanes."""

    @intrinsic
    def function(typingctx, x):
        kind = x if isinstance(x, Lanes) else scalar

        def lower(context, builder, sig, args):
            many = f"v{kind.count}" if isinstance(kind, Lanes) else ""
            return _call(builder, f"llvm.{name}.{many}{letter}64", args[0].type, [args[0]])

        return kind(kind), lower

    return function


root = _of_llvm("sqrt", "f", types.float64)
floor = _of_llvm("floor", "f", types.float64)
magnitude = _of_llvm("fabs", "f", types.float64)
#: The 64 bits of a whole number in reverse order.
reversed_bits = _of_llvm("bitreverse", "i", types.uint64)


@intrinsic
def select(typingctx, mask, a, b):
    """Return a where the mask holds, else b: lane by lane, or of plain numbers."""
    kind: Any = next((t for t in (a, b) if isinstance(t, Lanes)), None)
    if isinstance(mask, Lanes) and kind is None:
        kinds = {types.Float: FLOATS, types.Boolean: MASKS}
        kind = kinds.get(type(typingctx.unify_types(a, b)), WHOLES)[mask.count]
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


def _spread(count: int):
    @intrinsic
    def function(typingctx, x):
        kind = (FLOATS if isinstance(x, types.Float) else WHOLES)[count]

        def lower(context, builder, sig, args):
            return _as_lanes(context, builder, args[0], x, kind)

        return kind(x), lower

    return function


#: A number in all of eight lanes, or of sixteen.
spread, spread_wide = _spread(LANES), _spread(WIDE)


@intrinsic
def copy_sign(typingctx, size, sign):
    """Return |size| with the sign of the other."""
    lanes = next((t for t in (size, sign) if isinstance(t, Lanes)), None)
    kind: Any = lanes or types.float64
    name = f"llvm.copysign.{f'v{lanes.count}' if lanes else ''}f64"

    def lower(context, builder, sig, args):
        if lanes:
            pair = zip(args, sig.args, strict=True)
            args = [_as_lanes(context, builder, v, t, lanes) for v, t in pair]
        return _call(builder, name, args[0].type, args)

    return kind(size, sign), lower


def _packed(builder, value, mask: Lanes):
    """Return a mask as a whole number of as many bits."""
    return builder.bitcast(value, ir.IntType(mask.count))


@intrinsic
def bits(typingctx, mask):
    """Return the mask as a whole number, lane i in bit i."""

    def lower(context, builder, sig, args):
        if not isinstance(mask, Lanes):
            return builder.zext(context.cast(builder, args[0], mask, types.boolean), ir.IntType(64))
        return builder.zext(_packed(builder, args[0], mask), ir.IntType(64))

    return types.int64(mask), lower


@intrinsic
def count_of(typingctx, mask):
    """Return in how many lanes the mask holds."""

    def lower(context, builder, sig, args):
        return builder.zext(builder.ctpop(_packed(builder, args[0], mask)), ir.IntType(64))

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
        if not isinstance(mask, Lanes):
            return args[0]
        packed = _packed(builder, args[0], mask)
        return builder.icmp_unsigned("!=", packed, packed.type(0))

    return types.boolean(mask), lower


def _convert(emit, sources: dict[int, Lanes], results: dict[int, Lanes]):
    @intrinsic
    def function(typingctx, x):
        lanes = results[x.count] if x in sources.values() else None
        kind: Any = lanes or _SCALAR[results[LANES]]

        def lower(context, builder, sig, args):
            if lanes:
                return emit(builder, args[0], lanes.vector)
            return context.cast(builder, args[0], x, kind)

        return kind(x), lower

    return function


#: Toward zero; the value must fit.
whole = _convert(_B.fptosi, FLOATS, WHOLES)
real = _convert(_B.sitofp, WHOLES, FLOATS)
