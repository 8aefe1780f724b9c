"""Eight paths at once: lanes out of arrays and back, and small arrays on a kernel's own stack.

`gather` and `gather_row` take a plain index as well as eight.
"""

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from mpfcad.optics.lanes import F8, I8, I32, LANES, Lanes


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
        return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(I32, len(order)), order))

    def lower(context, builder, sig, args):
        data = cgutils.create_struct_proxy(array)(context, builder, value=args[0]).data
        if index != I8:
            place = context.cast(builder, args[1], index, types.int64)
            loaded = row(context, builder, data, place)
            columns = [builder.extract_element(loaded, ir.Constant(I32, i)) for i in range(4)]
            return context.make_tuple(builder, sig.return_type, columns)
        rows = [
            row(context, builder, data, builder.extract_element(args[1], ir.Constant(I32, i)))
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
