"""What stands around the panel: fiducials, text, and a coupon of step wedge and reference strip.

All of it is outside the outline; grid steps. The wedge's patches have slots of a known aperture
ratio, so that what a ratio gives can be measured on the print; on the reference strip nothing is
printed.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.layer import FIDUCIAL, TEXT
from mpfcad.mask.phototool import Polarity
from mpfcad.mask.rule import GRID, MaskRules
from mpfcad.units import mm, um

#: A layer and the (k, 2) int64 vertices of a polygon on it.
Polygon = tuple[int, NDArray[np.int64]]

WEDGE_PERCENT = (0, 5, 10, 25, 50, 75, 100)
_MM = round(mm / GRID)
FIDUCIAL_OFFSET, FIDUCIAL_SIZE, FIDUCIAL_LINE = 10 * _MM, 4 * _MM, _MM // 5
TEXT_OFFSET, TEXT_SIZE = 20 * _MM, 3 * _MM
#: The coupon stands above the panel: distance, side of a patch, gap, reference strip, corner line.
COUPON_OFFSET, PATCH, GAP, STRIP, LINE = 20 * _MM, 8 * _MM, 2 * _MM, 20 * _MM, _MM // 5


@dataclass(frozen=True)
class Label:
    """A line of text as a text element of the file."""

    text: str
    position: tuple[int, int]


def draw_fiducials(width: int, length: int) -> Iterator[Polygon]:
    """Yield crosses off the four corners of the panel."""
    a, b = FIDUCIAL_SIZE // 2, FIDUCIAL_LINE // 2
    cross = np.array(
        [(-b, -a), (b, -a), (b, -b), (a, -b), (a, b), (b, b),
         (b, a), (-b, a), (-b, b), (-a, b), (-a, -b), (-b, -b)]
    )  # fmt: skip
    for x in (-FIDUCIAL_OFFSET, width + FIDUCIAL_OFFSET):
        for y in (-FIDUCIAL_OFFSET, length + FIDUCIAL_OFFSET):
            yield FIDUCIAL, cross + np.array((x, y))


def draw_text(text: str, size: int, x: int, y: int) -> Iterator[Polygon]:
    """Yield the letters of a line as polygons, its lower left corner at x, y."""
    import gdstk

    scale = um / GRID
    for letter in gdstk.text(text, size / scale, (x / scale, y / scale)):
        yield TEXT, np.rint(letter.points * scale).astype(np.int64)


def draw_lines(lines: tuple[str, ...]) -> tuple[list[Polygon], list[Label]]:
    """Return lines of text below the panel as polygons, and as labels below those."""
    polygons: list[Polygon] = []
    labels = []
    for i, line in enumerate(lines):
        foot = -TEXT_OFFSET - i * TEXT_SIZE * 3 // 2
        polygons += draw_text(line, TEXT_SIZE, 0, foot)
        labels.append(Label(line, (0, foot - len(lines) * TEXT_SIZE * 3 // 2)))
    return polygons, labels


def wedge_period(rules: MaskRules) -> int:
    """Return the period of the wedge's slots: 5 % and 75 % of it have to be makeable."""
    return round(max(rules.period, 20 * rules.aperture_limit, 4 * rules.web_limit) / GRID)


def draw_coupon(
    rules: MaskRules, length: int, polarity: Polarity
) -> tuple[list[ApertureArray], list[Polygon]]:
    """Return what is drawn of wedge and reference strip, and the polygons of text and frame."""
    period = wedge_period(rules)
    rows = max(1, -(-PATCH // period))
    foot = length + COUPON_OFFSET
    arrays: list[ApertureArray] = []
    polygons: list[Polygon] = []
    height = rows * period
    for i, percent in enumerate(WEDGE_PERCENT):
        left = i * (PATCH + GAP)
        polygons += draw_text(f"{percent}%", GAP, left, foot + height + GAP)
        drawn = percent if polarity == "open" else 100 - percent
        arrays += _patch((left, foot), PATCH, period, rows, drawn)
    left = len(WEDGE_PERCENT) * (PATCH + GAP)
    polygons += draw_text("unprinted", GAP, left, foot + height + GAP)
    arrays += _patch((left, foot), STRIP, period, rows, 0 if polarity == "open" else 100)
    polygons += _frame(left, foot, STRIP, height)
    return arrays, polygons


def _patch(
    corner: tuple[int, int], width: int, period: int, rows: int, percent: int
) -> list[ApertureArray]:
    """Return the slots that cover so many percent of a patch."""
    if percent in (0, 100):
        whole = ApertureArray((width, rows * period), Placement(corner))
        return [whole] if percent else []
    place = Placement(corner, rows=rows, row_step=(0, period))
    return [ApertureArray((width, period * percent // 100), place)]


def _frame(left: int, foot: int, width: int, height: int) -> Iterator[Polygon]:
    """Yield the four corner angles around the reference strip, outside of it."""
    for x, out_x in ((left, -1), (left + width, 1)):
        for y, out_y in ((foot, -1), (foot + height, 1)):
            arm, line = GAP, LINE
            corner = [(0, 0), (-arm, 0), (-arm, line), (line, line), (line, -arm), (0, -arm)]
            yield TEXT, (np.array(corner) * (out_x, out_y) + (x, y)).astype(np.int64)
