"""Eight paths at once: lanes out of arrays and back, and small arrays on a kernel's own stack.

`gather`, `gather_row` and `gather_line` take a plain index as well as eight. A *line* is a row of
eight columns, a *half* the last four of them.
"""

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.types.containers import UniTuple
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import DTypeLike, NDArray

from mpfcad.optics.base.lanes import F8, FLOATS, I8, I32, LANES, WHOLES, WIDE, Lanes

_CACHE_LINE = 64


def aligned(shape: tuple[int, ...], dtype: DTypeLike) -> NDArray:
    """Return an array of zeros that begins with a cache line: rows of eight then lie in one each.

    Elsewhere each load of eight values would be two.
    """
    dtype = np.dtype(dtype)
    size = int(np.prod(shape)) * dtype.itemsize
    raw = np.zeros(size + _CACHE_LINE, np.uint8)
    start = -raw.ctypes.data % _CACHE_LINE
    return raw[start : start + size].view(dtype).reshape(shape)


def _kind(array, index):
    """Return the kind of an array's entries at an index: a number, or lanes."""
    if not isinstance(index, Lanes):
        return array.dtype
    return (FLOATS if isinstance(array.dtype, types.Float) else WHOLES)[index.count]


def _places(builder, index):
    """Return the whole numbers in lanes."""
    return [builder.extract_element(index, ir.Constant(I32, i)) for i in range(index.type.count)]


@intrinsic
def gather(typingctx, array, index):
    """Return array[index], (n,) contiguous, for an index or eight of them."""
    result = _kind(array, index)

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        if not isinstance(index, Lanes):
            place = context.cast(builder, args[1], index, types.int64)
            return builder.load(builder.gep(data, [place]))
        vector = ir.Constant(result.vector, ir.Undefined)
        for i, place in enumerate(_places(builder, args[1])):
            value = builder.load(builder.gep(data, [place]))
            vector = builder.insert_element(vector, value, ir.Constant(I32, i))
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


def _shuffle(builder, a, b, order):
    """Return a vector of the elements of a and b in an order."""
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(I32, len(order)), order))


def _transposed(builder, rows):
    """Return the columns of eight rows of eight: pairs, then quads, then halves change places."""
    for step, halves in (
        (1, ([0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15])),
        (2, ([0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15])),
        (4, ([0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15])),
    ):
        for i in range(LANES):
            if not i & step:
                pair = rows[i], rows[i + step]
                rows[i], rows[i + step] = (_shuffle(builder, *pair, half) for half in halves)
    return rows


def _row(builder, data, place, element, columns, width, first=0):
    """Return columns of row number `place` of an array of a width, as a vector."""
    kind = ir.VectorType(element, columns)
    place = builder.add(builder.mul(place, place.type(width)), place.type(first))
    loaded = builder.load(builder.bitcast(builder.gep(data, [place]), kind.as_pointer()))
    loaded.align = 8
    return loaded


def _eights(builder, turned, rows):
    """Return the columns of rows, of which eight at a time are turned into columns."""
    parts = [turned(builder, rows[i : i + LANES]) for i in range(0, len(rows), LANES)]
    if len(parts) == 1:
        return parts[0]
    both = list(range(2 * LANES))
    return [_shuffle(builder, a, b, both) for a, b in zip(*parts, strict=True)]


def _gathering(columns, width, first, turned):
    """Return an intrinsic that gathers columns of rows of a width, from a first one on."""

    @intrinsic
    def function(typingctx, array, index):
        kind = _kind(array, index)

        def lower(context, builder, sig, args):
            data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
            entry = context.get_value_type(array.dtype)
            if not isinstance(index, Lanes):
                place = context.cast(builder, args[1], index, types.int64)
                row = _row(builder, data, place, entry, columns, width, first)
                found = [builder.extract_element(row, ir.Constant(I32, i)) for i in range(columns)]
            else:
                rows = [
                    _row(builder, data, place, entry, columns, width, first)
                    for place in _places(builder, args[1])
                ]
                found = _eights(builder, turned, rows)
            return context.make_tuple(builder, sig.return_type, found)

        return UniTuple(kind, columns)(array, index), lower

    return function


def _columns(builder, rows):
    """Return the columns of eight rows of four."""
    # Rows i and i+4 side by side, then columns in pairs, then whole.
    pairs = [_shuffle(builder, rows[i], rows[i + 4], list(range(8))) for i in range(4)]
    columns = []
    for c in range(4):
        order = [c, 8 + c, 4 + c, 12 + c]
        halves = [_shuffle(builder, pairs[i], pairs[i + 1], order) for i in (0, 2)]
        columns.append(_shuffle(builder, halves[0], halves[1], [0, 1, 4, 5, 2, 3, 6, 7]))
    return columns


#: The columns of array[index], contiguous, as a tuple, for an index or lanes of them: the eight of
#: (n, 8), the four of (n, 4), the first and the last four of (n, 8).
gather_line = _gathering(8, 8, 0, _transposed)
gather_row = _gathering(4, 4, 0, _columns)
gather_first_half, gather_half = _gathering(4, 8, 0, _columns), _gathering(4, 8, 4, _columns)


def _quads(builder, columns):
    """Return the eight rows of four columns."""
    a, b, c, d = columns
    even, odd = [0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]
    pairs = [(_shuffle(builder, a, b, p), _shuffle(builder, c, d, p)) for p in (even, odd)]
    rows = []
    for lane in range(LANES):
        low = lane - lane % 2
        order = [low, low + 1, LANES + low, LANES + low + 1]
        rows.append(_shuffle(builder, *pairs[lane % 2], order))
    return rows


def _scatter(context, builder, array, args, columns, first, turned):
    """Store columns of lanes into rows of eight, from a first column on."""
    data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
    places, lanes = _places(builder, args[1]), args[2:]
    for begin in range(0, len(places), LANES):
        part = list(range(begin, begin + LANES))
        eight = [v if len(places) == LANES else _shuffle(builder, v, v, part) for v in lanes]
        for row, place in zip(turned(builder, eight), places[begin:], strict=False):
            at = builder.add(builder.mul(place, place.type(8)), place.type(first))
            pointer = builder.bitcast(builder.gep(data, [at]), row.type.as_pointer())
            builder.store(row, pointer, align=8)
    return context.get_dummy_value()


@intrinsic
def scatter_line(typingctx, array, index, a, b, c, d, e, f, g, h):
    """Put lanes into the columns of array[index], (n, 8) contiguous; of equal rows the last."""

    def lower(context, builder, sig, args):
        return _scatter(context, builder, array, args, 8, 0, _transposed)

    return types.void(array, index, a, b, c, d, e, f, g, h), lower


@intrinsic
def scatter_half(typingctx, array, index, a, b, c, d):
    """Put lanes into the last four columns of array[index], (n, 8) contiguous."""

    def lower(context, builder, sig, args):
        return _scatter(context, builder, array, args, 4, 4, _quads)

    return types.void(array, index, a, b, c, d), lower


@intrinsic
def put(typingctx, array, index, value):
    """Put lanes of whole numbers into array[index], (n,) contiguous; of equal places the last."""

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        for place, one in zip(*(_places(builder, v) for v in args[1:]), strict=True):
            builder.store(one, builder.gep(data, [place]))
        return context.get_dummy_value()

    return types.void(array, index, value), lower


@intrinsic
def expand(typingctx, array, first, mask, other):
    """Return lanes in which the mask's get the next entries of (n,) int64, from one on."""

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        place = builder.gep(data, [context.cast(builder, args[1], first, types.int64)])
        given = [place, *args[2:]]
        kind = ir.FunctionType(other.vector, [v.type for v in given])
        name = f"llvm.masked.expandload.v{other.count}i64"
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), given)

    return other(array, first, mask, other), lower


def _load_from(count):
    @intrinsic
    def function(typingctx, array, first):
        kind = (FLOATS if isinstance(array.dtype, types.Float) else WHOLES)[count]

        def lower(context, builder, sig, args):
            data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
            place = context.cast(builder, args[1], first, types.int64)
            pointer = builder.bitcast(builder.gep(data, [place]), kind.vector.as_pointer())
            loaded = builder.load(pointer)
            loaded.align = 8
            return loaded

        return kind(array, first), lower

    return function


#: Eight entries of a contiguous array, or sixteen, from one on.
load_from, load_wide = _load_from(LANES), _load_from(WIDE)


def _row_pointer(context, builder, array, value, row, vector: ir.VectorType):
    """Return the address of a row of eight as that of a vector."""
    data = cgutils.create_struct_proxy(array)(context, builder, value=value).data
    place = builder.mul(row, ir.Constant(ir.IntType(64), LANES))
    return builder.bitcast(builder.gep(data, [place]), vector.as_pointer())


@intrinsic
def load(typingctx, array, row):
    """Return a row of an (n, 8) contiguous array as lanes; single precision becomes double."""
    kind = F8 if isinstance(array.dtype, types.Float) else I8
    single = array.dtype == types.float32

    def lower(context, builder, sig, args):
        place = context.cast(builder, args[1], row, types.int64)
        vector = ir.VectorType(ir.FloatType(), LANES) if single else kind.vector
        pointer = _row_pointer(context, builder, array, args[0], place, vector)
        loaded = builder.load(pointer)
        loaded.align = 4 if single else 8
        return builder.fpext(loaded, kind.vector) if single else loaded

    return kind(array, row), lower


@intrinsic
def store(typingctx, array, row, value):
    """Put lanes into a row of an (n, 8) contiguous array."""

    def lower(context, builder, sig, args):
        place = context.cast(builder, args[1], row, types.int64)
        pointer = _row_pointer(context, builder, array, args[0], place, value.vector)
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, row, value), lower
