"""What stands around the panel: fiducials, text, and a coupon of step wedge and reference strip.

All of it is outside the outline; grid steps. The wedge's patches have slots of a known aperture
ratio, log-spaced over the mask's own ratios and beyond both ends, so that what a ratio gives can be
measured on the print (`mpfcad calibrate`); on the reference strip nothing is printed.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.aperture import Mask
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.layer import FIDUCIAL, TEXT
from mpfcad.mask.phototool import Polarity
from mpfcad.mask.rule import GRID, MaskRules
from mpfcad.units import mm, um

#: A layer and the (k, 2) int64 vertices of a polygon on it.
Polygon = tuple[int, NDArray[np.int64]]

#: The wedge of a mask without resin; how far the wedge goes beyond the mask's own ratios.
USUAL_RATIOS, BEYOND = (0.0, 0.05, 0.1, 0.25, 0.5, 0.75, 1.0), 1.6
#: Lines of text that are drawn as letters; all of them are text elements.
DRAWN_LINES = 3
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
        if i < DRAWN_LINES:
            polygons += draw_text(line, TEXT_SIZE, 0, foot)
        labels.append(Label(line, (0, foot - len(lines) * TEXT_SIZE * 3 // 2)))
    return polygons, labels


def wedge_ratios(mask: Mask) -> tuple[float, ...]:
    """Return the aperture ratios of the wedge: none, six over the mask's own and beyond, all.

    The six are evenly spaced in their logarithm, from the smallest ratio over `BEYOND` to the
    largest times that (at most 0.9), to three digits.
    """
    smallest, largest = mask.ratio_ends
    if not largest:
        return USUAL_RATIOS
    low = max(smallest / BEYOND, 0.001)
    high = max(min(largest * BEYOND, 0.9), 2 * low)
    steps = np.geomspace(low, high, 6)
    return (0.0, *(float(f"{ratio:.3g}") for ratio in steps), 1.0)


def wedge_period(rules: MaskRules, ratios: tuple[float, ...]) -> int:
    """Return the period of the wedge's slots: each of its ratios has to be makeable."""
    part = [ratio for ratio in ratios if 0 < ratio < 1]
    least = (rules.aperture_limit / min(part), rules.web_limit / (1 - max(part)))
    return round(max(rules.period, *least) / GRID)


def draw_coupon(
    rules: MaskRules, length: int, polarity: Polarity, ratios: tuple[float, ...]
) -> tuple[list[ApertureArray], list[Polygon]]:
    """Return what is drawn of wedge and reference strip, and the polygons of text and frame."""
    period = wedge_period(rules, ratios)
    rows = max(1, -(-PATCH // period))
    foot = length + COUPON_OFFSET
    arrays: list[ApertureArray] = []
    polygons: list[Polygon] = []
    height = rows * period
    for i, ratio in enumerate(ratios):
        left = i * (PATCH + GAP)
        polygons += draw_text(f"{100 * ratio:.3g}%", GAP, left, foot + height + GAP)
        drawn = ratio if polarity == "open" else 1 - ratio
        arrays += _patch((left, foot), PATCH, period, rows, drawn)
    left = len(ratios) * (PATCH + GAP)
    polygons += draw_text("unprinted", GAP, left, foot + height + GAP)
    arrays += _patch((left, foot), STRIP, period, rows, 0 if polarity == "open" else 1)
    polygons += _frame(left, foot, STRIP, height)
    return arrays, polygons


def _patch(
    corner: tuple[int, int], width: int, period: int, rows: int, ratio: float
) -> list[ApertureArray]:
    """Return the slots that cover such a share of a patch."""
    if ratio in (0, 1):
        whole = ApertureArray((width, rows * period), Placement(corner))
        return [whole] if ratio else []
    place = Placement(corner, rows=rows, row_step=(0, period))
    return [ApertureArray((width, round(period * ratio)), place)]


def _frame(left: int, foot: int, width: int, height: int) -> Iterator[Polygon]:
    """Yield the four corner angles around the reference strip, outside of it."""
    for x, out_x in ((left, -1), (left + width, 1)):
        for y, out_y in ((foot, -1), (foot + height, 1)):
            arm, line = GAP, LINE
            corner = [(0, 0), (-arm, 0), (-arm, line), (line, line), (line, -arm), (0, -arm)]
            yield TEXT, (np.array(corner) * (out_x, out_y) + (x, y)).astype(np.int64)
