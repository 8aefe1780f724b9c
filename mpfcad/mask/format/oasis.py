"""A drawing as strict OASIS: records as in SEMI P39, in compressed blocks, with a CRC-32.

Arrays are repetitions of one rectangle, polygon or cell, so the size of a file grows with the
number of arrays, not of apertures. Everything is written as it comes: memory does not grow.
"""

import itertools
import zlib
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.format.drawing import TOP, Drawing
from mpfcad.mask.layer import APERTURE, COUPON, LAYERS, OUTLINE, TEXT

#: Grid steps in a µm.
STEPS_PER_UM = 1000
#: Uncompressed bytes after which a compressed block ends.
BLOCK = 1 << 20
#: Bytes of the END record.
END_SIZE = 256


def write_oasis(drawing: Drawing, path: Path) -> None:
    """Write `drawing` to `path`."""
    with path.open("wb") as file:
        _write(drawing, _Output(file))


def _write(drawing: Drawing, out: "_Output") -> None:
    tiles = drawing.tile_cells()
    number = {tile.name: i + 1 for i, tile in enumerate(tiles)}
    out.put(b"%SEMI-OASIS\r\n\x01" + _string("1.0") + b"\x00" + _uint(STEPS_PER_UM) + b"\x01")
    table = [out.size]
    out.put(b"".join(b"\x03" + _string(name) for name in (TOP, *number)))
    table.append(out.size)
    lines = list(dict.fromkeys(label.text for label in drawing.labels))
    out.put(b"".join(b"\x05" + _string(line) for line in lines))
    table.append(out.size)
    out.put(b"".join(_layer_name(layer, name) for layer, name in LAYERS.items()))
    for tile in tiles:
        with _Cell(out, number[tile.name]) as cell:
            cell.add_arrays(tile.arrays, APERTURE)
    with _Cell(out, 0) as cell:
        cell.add_box(OUTLINE, (drawing.width, drawing.length))
        cell.add_arrays(drawing.arrays, APERTURE)
        cell.add_arrays(drawing.coupon, COUPON)
        for layer, points in drawing.polygons:
            cell.add(ApertureArray(points, Placement((0, 0))), layer)
        for array in drawing.tiles:
            cell.place(number[array.tile.name], array.place)
        for label in drawing.labels:
            cell.write(lines.index(label.text), label.position)
    _end(out, table if lines else [table[0], 0, table[2]])


def _layer_name(layer: int, name: str) -> bytes:
    """Return the LAYERNAME record of layer/0: intervals of kind 3 are one number."""
    return b"\x0b" + _string(name) + b"\x03" + _uint(layer) + b"\x03" + _uint(0)


def _end(out: "_Output", table: list[int]) -> None:
    """Write the END record: strict offsets of the name tables, padding to 256 bytes, CRC-32."""
    cell, text, layer = (b"\x01" + _uint(offset) for offset in table)
    none = b"\x01\x00"
    head = b"\x02" + cell + text + none + none + layer + none
    pad = END_SIZE - len(head) - 1 - 4
    length = _uint(pad - 2) if pad - 2 >= 128 else _uint(pad - 1)
    out.put(head + length + bytes(pad - len(length)) + b"\x01")
    out.put(out.checksum.to_bytes(4, "little"))


class _Output:
    """Counts and sums up what goes to the file."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.size, self.checksum = file, 0, 0

    def put(self, data: bytes) -> None:
        self.file.write(data)
        self.size += len(data)
        self.checksum = zlib.crc32(data, self.checksum)


class _Cell:
    """The records of one cell, in compressed blocks; positions relative to the last one."""

    def __init__(self, out: _Output, number: int) -> None:
        self.out = out
        self.parts: list[bytes] = []
        self.pending = 0
        self.last: dict[str, Any] = {"shape": (0, 0), "place": (0, 0), "text": (0, 0)}
        out.put(b"\x0d" + _uint(number))
        self._emit(b"\x10")  # XYRELATIVE

    def __enter__(self) -> "_Cell":
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            self._flush()

    def add_arrays(self, arrays: Iterable[ApertureArray], layer: int) -> None:
        for array in arrays:
            self.add(array, layer)

    def add_box(self, layer: int, size: tuple[int, int]) -> None:
        self.add(ApertureArray(size, Placement((0, 0))), layer)

    def add(self, array: ApertureArray, layer: int) -> None:
        """Add a RECTANGLE or POLYGON record with its repetition."""
        info, tail = 0, b""
        if self.last.get("layer") != layer:
            info, tail = 3, _uint(layer) + _uint(0)
            self.last["layer"] = layer
        if array.is_rectangle:
            start, record = (0, 0), b"\x14"
            for bit, key, size in zip((64, 32), "wh", array.shape, strict=True):
                if self.last.get(key) != size:
                    info, tail = info | bit, tail + _uint(size)
                    self.last[key] = size
        else:
            corners: Any = array.shape
            points = [(int(x), int(y)) for x, y in corners]
            start, record = points[0], b"\x15"
            steps = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(points)]
            tail += b"\x04" + _uint(len(steps)) + b"".join(map(_step, steps))
            info |= 32
        where = (array.place.origin[0] + start[0], array.place.origin[1] + start[1])
        self._record(record, info, tail, "shape", where, array.place)

    def place(self, number: int, place: Placement) -> None:
        """Add a PLACEMENT record."""
        if place.count:
            self._record(b"\x11", 0xC0, _uint(number), "place", place.origin, place)

    def write(self, number: int, position: tuple[int, int]) -> None:
        """Add a TEXT record."""
        tail = _uint(number) + _uint(TEXT) + _uint(0)
        self._record(b"\x13", 0x63, tail, "text", position, None)

    def _record(
        self,
        record: bytes,
        info: int,
        tail: bytes,
        kind: str,
        where: tuple[int, int],
        place: Placement | None,
    ) -> None:
        """Emit a record: x, y and repetition stand at its end, and have the same bits in all."""
        bits = (32, 16, 8) if record == b"\x11" else (16, 8, 4)
        first, repetition = _repetition(place)
        where = (where[0] + first[0], where[1] + first[1])
        last = self.last[kind]
        for bit, now, before in zip(bits, where, last, strict=False):
            if now != before:
                info, tail = info | bit, tail + _sint(now - before)
        self.last[kind] = where
        if repetition:
            info |= bits[2]
            again = self.last.get("repetition") == repetition
            tail += b"\x00" if again else repetition
            self.last["repetition"] = repetition if len(repetition) < 256 else b""
        self._emit(record + bytes([info]) + tail)

    def _emit(self, data: bytes) -> None:
        self.parts.append(data)
        self.pending += len(data)
        if self.pending >= BLOCK:
            self._flush()

    def _flush(self) -> None:
        """Write a CBLOCK: kind 0 is raw deflate."""
        data = b"".join(self.parts)
        if not data:
            return
        squeeze = zlib.compressobj(6, zlib.DEFLATED, -15)
        packed = squeeze.compress(data) + squeeze.flush()
        self.out.put(b"\x22\x00" + _uint(len(data)) + _uint(len(packed)) + packed)
        self.parts, self.pending = [], 0


def _repetition(place: Placement | None) -> tuple[tuple[int, int], bytes]:
    """Return the first place from the origin, and the repetition; empty for a single place."""
    if place is None or (place.offset is None and place.count <= 1):
        return (0, 0), b""
    if place.offset is not None:
        return _listed(place.offset)
    (ax, ay), (bx, by), n, m = place.column_step, place.row_step, place.columns, place.rows
    if n > 1 and m > 1:
        if ay == bx == 0 and ax > 0 and by > 0:
            return (0, 0), b"\x01" + _uint(n - 2) + _uint(m - 2) + _uint(ax) + _uint(by)
        return (0, 0), b"\x08" + _uint(n - 2) + _uint(m - 2) + _step((ax, ay)) + _step((bx, by))
    count, (x, y) = (n, (ax, ay)) if n > 1 else (m, (bx, by))
    if y == 0 and x > 0:
        return (0, 0), b"\x02" + _uint(count - 2) + _uint(x)
    if x == 0 and y > 0:
        return (0, 0), b"\x03" + _uint(count - 2) + _uint(y)
    return (0, 0), b"\x09" + _uint(count - 2) + _step((x, y))


def _listed(offset: NDArray[np.int64]) -> tuple[tuple[int, int], bytes]:
    """Return listed places as steps from one to the next, on the coarsest grid that they share."""
    offset = offset[np.lexsort((offset[:, 0], offset[:, 1]))]
    first = (int(offset[0, 0]), int(offset[0, 1]))
    step = np.diff(offset, axis=0)
    if not len(step):
        return first, b""
    grid = max(1, int(np.gcd.reduce(np.abs(step), axis=None)))
    dx, dy = step[:, 0] // grid, step[:, 1] // grid
    head = _uint(len(step) - 1) + _uint(grid)
    if not dy.any():
        return first, b"\x05" + head + _varints(dx)
    if not dx.any():
        return first, b"\x07" + head + _varints(dy)
    # Each step as (x, y): 1 + sign and size of x, then size and sign of y.
    pair = np.empty((len(step), 2), np.int64)
    pair[:, 0] = (np.abs(dx) << 2) | ((dx < 0) << 1) | 1
    pair[:, 1] = (np.abs(dy) << 1) | (dy < 0)
    return first, b"\x0b" + head + _varints(pair.ravel())


@lru_cache(maxsize=1 << 16)
def _uint(value: int) -> bytes:
    """Return an unsigned integer, seven bits a byte."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    out.append(value)
    return bytes(out)


def _sint(value: int) -> bytes:
    """Return a signed integer: its sign is bit 0."""
    return _uint(abs(value) << 1 | (value < 0))


def _step(step: tuple[int, int]) -> bytes:
    """Return a step in any direction."""
    return _uint(abs(step[0]) << 2 | (step[0] < 0) << 1 | 1) + _sint(step[1])


def _string(text: str) -> bytes:
    return _uint(len(text)) + text.encode("ascii")


def _varints(values: NDArray[np.int64]) -> bytes:
    """Return unsigned integers, seven bits a byte, all at once."""
    if values.max(initial=0) < 128:
        return values.astype(np.uint8).tobytes()
    length = np.maximum(1, -(-np.frexp(values.astype(float))[1] // 7))
    longest = int(length.max())
    place = np.arange(longest)
    digit = (values[:, None] >> (7 * place)) & 127
    digit |= np.where(place < length[:, None] - 1, 128, 0)
    return digit.astype(np.uint8)[place < length[:, None]].tobytes()
