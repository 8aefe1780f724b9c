"""Eight paths at once: lanes out of arrays and back, and small arrays on a kernel's own stack.

`gather`, `gather_row` and `gather_line` take a plain index as well as eight.
"""

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.types.containers import UniTuple
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array
from numpy.typing import DTypeLike, NDArray

from mpfcad.optics.base.lanes import F8, I8, I32, LANES

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
            place = builder.extract_element(args[1], ir.Constant(I32, i))
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


def _row(builder, data, place, element, columns):
    """Return row number `place` of an array of so many columns, as a vector."""
    kind = ir.VectorType(element, columns)
    place = builder.mul(place, ir.Constant(place.type, columns))
    loaded = builder.load(builder.bitcast(builder.gep(data, [place]), kind.as_pointer()))
    loaded.align = 8
    return loaded


@intrinsic
def gather_line(typingctx, array, index):
    """Return the eight columns of array[index], (n, 8) contiguous, as a tuple.

    For an index or eight of them.
    """
    wide = F8 if isinstance(array.dtype, types.Float) else I8
    kind = wide if index == I8 else array.dtype
    result = UniTuple(kind, 8)

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        element = wide.vector.element
        if index != I8:
            place = context.cast(builder, args[1], index, types.int64)
            loaded = _row(builder, data, place, element, 8)
            columns = [builder.extract_element(loaded, ir.Constant(I32, i)) for i in range(8)]
        else:
            places = [builder.extract_element(args[1], ir.Constant(I32, i)) for i in range(LANES)]
            columns = _transposed(builder, [_row(builder, data, p, element, 8) for p in places])
        return context.make_tuple(builder, result, columns)

    return result(array, index), lower


@intrinsic
def gather_row(typingctx, array, index):
    """Return the four columns of array[index], (n, 4) float64 contiguous, as a tuple."""
    kind = F8 if index == I8 else types.float64

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        if index != I8:
            place = context.cast(builder, args[1], index, types.int64)
            loaded = _row(builder, data, place, ir.DoubleType(), 4)
            columns = [builder.extract_element(loaded, ir.Constant(I32, i)) for i in range(4)]
            return context.make_tuple(builder, sig.return_type, columns)
        places = [builder.extract_element(args[1], ir.Constant(I32, i)) for i in range(LANES)]
        rows = [_row(builder, data, place, ir.DoubleType(), 4) for place in places]
        # Transpose 8 rows of 4: rows i and i+4 side by side, then columns in pairs, then whole.
        pairs = [_shuffle(builder, rows[i], rows[i + 4], list(range(8))) for i in range(4)]
        columns = []
        for c in range(4):
            halves = [
                _shuffle(builder, pairs[i], pairs[i + 1], [c, 8 + c, 4 + c, 12 + c]) for i in (0, 2)
            ]
            columns.append(_shuffle(builder, halves[0], halves[1], [0, 1, 4, 5, 2, 3, 6, 7]))
        return context.make_tuple(builder, sig.return_type, columns)

    return UniTuple(kind, 4)(array, index), lower


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


@intrinsic
def load_lines(typingctx, array):
    """Return the columns of an (8, 8) contiguous array as a tuple of lanes."""
    kind = F8 if isinstance(array.dtype, types.Float) else I8
    result = UniTuple(kind, LANES)

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        places = [ir.Constant(ir.IntType(64), i) for i in range(LANES)]
        rows = [_row(builder, data, place, kind.vector.element, LANES) for place in places]
        return context.make_tuple(builder, result, _transposed(builder, rows))

    return result(array), lower


@intrinsic
def store_lines(typingctx, array, a, b, c, d, e, f, g, h):
    """Put lanes into the columns of an (8, 8) contiguous array."""

    def lower(context, builder, sig, args):
        for i, row in enumerate(_transposed(builder, list(args[1:]))):
            place = ir.Constant(ir.IntType(64), i)
            pointer = _row_pointer(context, builder, array, args[0], place, a.vector)
            builder.store(row, pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, a, b, c, d, e, f, g, h), lower
