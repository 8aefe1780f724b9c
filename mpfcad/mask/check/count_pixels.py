"""Black pixels of packed tiles counted, by column and by square, compiled."""

from typing import Any

import numba as nb

from mpfcad.store.kernel import kept


@kept
@nb.njit(nogil=True)
def count_tile(
    bits: Any,
    skip: Any,
    first_row: Any,
    rows: Any,
    columns: Any,
    up: Any,
    across: Any,
    column_area: Any,
    square_area: Any,
) -> None:
    """Add the black pixels of a tile to `column_area` and `square_area`.

    `bits` (rows, bytes) uint8 is the tile, whose columns from `skip` on and rows from `first_row`
    on are within the panel: `columns` and `rows` of them. `up` and `across` are the squares of
    those rows and columns; `column_area` is the panel's from the tile's first column on.
    """
    for y in range(rows):
        row = bits[first_row + y]
        square = square_area[up[y]]
        for byte in range(skip >> 3, (skip + columns + 7) >> 3):
            value = row[byte]
            if value == 0:
                continue
            for bit in range(8):
                if value & (0x80 >> bit):
                    x = byte * 8 + bit - skip
                    if 0 <= x < columns:
                        column_area[x] += 1
                        square[across[x]] += 1
