"""OASIS read with gdstk, its repetitions kept; windows and strictness are klayout's."""

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mpfcad.errors import ExportError
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.check.found import FoundMask, read_polarity
from mpfcad.mask.check.read_layout import layout_window, open_layout, read_outline, refuse_many
from mpfcad.mask.format.flat import FEW, repeated
from mpfcad.mask.layer import APERTURE, COUPON, FIDUCIAL, TEXT
from mpfcad.mask.rule import GRID
from mpfcad.units import um

if TYPE_CHECKING:
    import gdstk

STEPS = um / GRID


def read_oasis(path: Path) -> FoundMask:
    """Return what an OASIS file holds.

    Raises
    ------
    ExportError
        when its checksum is wrong, or it holds anything else than a mask does.
    """
    import gdstk

    data = path.read_bytes()
    if zlib.crc32(data[:-4]) != int.from_bytes(data[-4:], "little"):
        raise ExportError(f"{path}: not a readable mask: its checksum does not fit its content")
    layout = open_layout(path)
    outline = read_outline(path, layout)
    top = gdstk.read_oas(str(path), unit=1e-6).top_level()[0]
    text = tuple(label.text for label in top.labels if label.layer == TEXT)
    return FoundMask(
        outline=outline,
        unit=layout.dbu,
        text=text,
        fiducials=tuple(_corners(p.points) for p in top.polygons if p.layer == FIDUCIAL),
        coupon=tuple(_arrays(path, top, COUPON)),
        drawn=read_polarity(path, text),
        arrays=lambda: _arrays(path, top, APERTURE),
        window=lambda box: layout_window(layout, box),
    )


def _corners(points: np.ndarray) -> tuple[int, int, int, int]:
    steps = np.rint(points * STEPS).astype(np.int64)
    (left, bottom), (right, top) = steps.min(axis=0), steps.max(axis=0)
    return int(left), int(bottom), int(right), int(top)


def _arrays(path: Path, cell: "gdstk.Cell", layer: int) -> Iterator[ApertureArray]:
    """Yield what stands on a layer of a cell, and in the cells that it refers to."""
    for polygon in cell.polygons:
        if polygon.layer != layer:
            continue
        points = polygon.points
        low, high = points.min(axis=0), points.max(axis=0)
        if len(points) != 4 or not np.isin(points, (low, high)).all():
            raise ExportError(f"{path}: cell {cell.name}: an aperture that is no rectangle")
        left, bottom = (round(float(v) * STEPS) for v in low)
        width, length = (round(float(v) * STEPS) for v in high - low)
        yield ApertureArray((width, length), _placement(polygon.repetition, left, bottom))
    for reference in cell.references:
        if reference.rotation or reference.x_reflection or reference.magnification != 1:
            raise ExportError(f"{path}: cell {reference.cell.name}: turned or scaled")
        x, y = (round(v * STEPS) for v in reference.origin)
        inner = list(_arrays(path, reference.cell, layer))
        if inner:
            outer = _placement(reference.repetition, x, y)
            if outer.count > FEW:
                refuse_many(path, cell.name, outer.count)
            for array in inner:
                yield from repeated(array, outer)


def _placement(repetition: "gdstk.Repetition", x: int, y: int) -> Placement:
    """Return the places of a repetition that begins at x, y."""
    if repetition.size == 0:
        return Placement((x, y))
    if repetition.columns and repetition.spacing is not None:
        dx, dy = (round(v * STEPS) for v in repetition.spacing)
        return Placement((x, y), repetition.columns, repetition.rows, (dx, 0), (0, dy))
    offset = np.rint(np.asarray(repetition.get_offsets()) * STEPS).astype(np.int64)
    return Placement((x, y), offset=offset)
