"""Eight paths at once: explicit vector types for kernels.

`F8`, `I8` and `M8` are LLVM's <8 x double>, <8 x i64> and <8 x i1>. LLVM cuts them to what the
processor has (one AVX-512 register, two of AVX, four of SSE or NEON), and every operation is that
of IEEE 754 in each lane: the bits are the same on all of them, and those of the same formula on
plain numbers. `select`, `gather`, `any_of`, `root`, `floor` take plain numbers as well, so one
kernel source serves a single path and eight.
"""

import operator
from typing import ClassVar

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model
from numba.np.arrayobj import populate_array

LANES = 8
_I32 = ir.IntType(32)


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
    vector = builder.insert_element(vector, value, ir.Constant(_I32, 0))
    mask = ir.Constant(ir.VectorType(_I32, LANES), [0] * LANES)
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


def _mathematical(name: str):
    """Return a function of LLVM, correctly rounded, for a number or eight."""

    @intrinsic
    def function(typingctx, x):
        kind = F8 if x == F8 else types.float64

        def lower(context, builder, sig, args):
            suffix = "v8f64" if kind == F8 else "f64"
            return _call(builder, f"llvm.{name}.{suffix}", args[0].type, [args[0]])

        return kind(kind), lower

    return function


root = _mathematical("sqrt")
floor = _mathematical("floor")
magnitude = _mathematical("fabs")


@intrinsic
def select(typingctx, mask, a, b):
    """Return a where the mask holds, else b: lane by lane, or of plain numbers."""
    kind = next((t for t in (a, b) if isinstance(t, Lanes)), None)
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


@intrinsic
def gather(typingctx, array, index):
    """Return array[index], (n,) contiguous, for an index or eight of them."""
    kind = F8 if isinstance(array.dtype, types.Float) else I8
    result = kind if index == I8 else array.dtype

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        if index != I8:
            place = context.cast(builder, args[1], index, types.int64)
            return builder.load(builder.gep(data, [place]))
        vector = ir.Constant(kind.vector, ir.Undefined)
        for i in range(LANES):
            place = builder.extract_element(args[1], ir.Constant(_I32, i))
            value = builder.load(builder.gep(data, [place]))
            vector = builder.insert_element(vector, value, ir.Constant(_I32, i))
        return vector

    return result(array, index), lower


def _local(element):
    @intrinsic(prefer_literal=True)
    def function(typingctx, count):
        array = types.Array(element, 1, "C")

        def lower(context, builder, sig, args):
            kind = context.get_value_type(element)
            size = context.get_abi_sizeof(kind)
            number, step = (ir.Constant(ir.IntType(64), n) for n in (count.literal_value, size))
            data = cgutils.alloca_once(builder, kind, size=count.literal_value)
            made = context.make_array(array)(context, builder)
            populate_array(made, data, [number], [step], step, None)
            return made._getvalue()

        return array(count), lower

    return function


#: Arrays of a constant length on the kernel's own stack: they must not outlive it.
local_floats = _local(types.float64)
local_wholes = _local(types.int64)


@intrinsic
def gather_row(typingctx, array, index):
    """Return the four columns of array[index], (n, 4) float64 contiguous, as a tuple."""
    kind = F8 if index == I8 else types.float64
    quad = ir.VectorType(ir.DoubleType(), 4)

    def row(context, builder, data, place):
        place = builder.mul(place, ir.Constant(place.type, 4))
        loaded = builder.load(builder.bitcast(builder.gep(data, [place]), quad.as_pointer()))
        loaded.align = 8
        return loaded

    def shuffle(builder, a, b, order):
        return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_I32, len(order)), order))

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        if index != I8:
            place = context.cast(builder, args[1], index, types.int64)
            loaded = row(context, builder, data, place)
            columns = [builder.extract_element(loaded, ir.Constant(_I32, i)) for i in range(4)]
            return context.make_tuple(builder, sig.return_type, columns)
        rows = [
            row(context, builder, data, builder.extract_element(args[1], ir.Constant(_I32, i)))
            for i in range(LANES)
        ]
        # Transpose 8 rows of 4: rows i and i+4 side by side, then columns in pairs, then whole.
        pairs = [shuffle(builder, rows[i], rows[i + 4], list(range(8))) for i in range(4)]
        columns = []
        for c in range(4):
            halves = [
                shuffle(builder, pairs[i], pairs[i + 1], [c, 8 + c, 4 + c, 12 + c]) for i in (0, 2)
            ]
            columns.append(shuffle(builder, *halves, [0, 1, 4, 5, 2, 3, 6, 7]))
        return context.make_tuple(builder, sig.return_type, columns)

    return types.UniTuple(kind, 4)(array, index), lower


def _row_pointer(context, builder, array, value, row, kind: Lanes):
    """Return the address of a row of eight as that of a vector."""
    data = cgutils.create_struct_proxy(array)(context, builder, value=value).data
    place = builder.mul(row, ir.Constant(ir.IntType(64), LANES))
    return builder.bitcast(builder.gep(data, [place]), kind.vector.as_pointer())


@intrinsic
def load(typingctx, array, row):
    """Return a row of an (n, 8) contiguous array as lanes."""
    kind = F8 if isinstance(array.dtype, types.Float) else I8

    def lower(context, builder, sig, args):
        place = context.cast(builder, args[1], row, types.int64)
        pointer = _row_pointer(context, builder, array, args[0], place, kind)
        loaded = builder.load(pointer)
        loaded.align = 8
        return loaded

    return kind(array, row), lower


@intrinsic
def store(typingctx, array, row, value):
    """Put lanes into a row of an (n, 8) contiguous array."""

    def lower(context, builder, sig, args):
        place = context.cast(builder, args[1], row, types.int64)
        pointer = _row_pointer(context, builder, array, args[0], place, value)
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, row, value), lower
