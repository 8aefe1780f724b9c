"""The artwork on the order sheet, drawn from the mask file: panel, fiducials, wedge, a cut-out."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.mask.check.check import READERS
from mpfcad.mask.check.found import Box, FoundMask
from mpfcad.mask.rule import GRID

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

#: Formats by how fast they are read.
FASTEST = ("oas", "gbr", "svg", "gds", "dxf")
#: The cut-out's side: so many periods, within these limits [mm]; places across that are tried.
PERIODS, LEAST, MOST = 2.5, 0.2, 3.0
PLACES = (0.5, 0.25, 0.75, 0.1, 0.9)
#: Points a mm of paper.
POINT = 72 / 25.4
_OPEN, _INK, _SOFT = (0.04, 0.37, 0.65), (0, 0, 0), (0.45, 0.45, 0.45)


@dataclass(frozen=True)
class Frame:
    """A rectangle of paper [mm]: lower left corner and size."""

    left: float
    bottom: float
    width: float
    height: float


def read_artwork(folder: Path, names: list[str]) -> tuple[str, FoundMask] | None:
    """Return the file that is read fastest, and what it holds; None: there are pixels only."""
    known = [n for s in FASTEST for n in names if n.endswith(f".{s}")]
    return (known[0], READERS[known[0].rpartition(".")[2]](folder / known[0])) if known else None


def fiducial_centres(found: FoundMask) -> list[tuple[float, float]]:
    """Return the centres of the fiducials [mm] from the panel's lower left corner, in order."""
    left, bottom = found.outline[:2]
    return sorted(
        ((box[0] + box[2]) / 2 * GRID - left * GRID, (box[1] + box[3]) / 2 * GRID - bottom * GRID)
        for box in found.fiducials
    )


def draw_artwork(canvas: "Canvas", found: FoundMask, frame: Frame, window: Box) -> None:
    """Draw panel, fiducials F1 …, wedge and where the cut-out lies, to one scale."""
    boxes = [found.outline, *found.fiducials, *(_span(array) for array in found.coupon)]
    left, bottom = (min(box[i] for box in boxes) * GRID for i in (0, 1))
    right, top = (max(box[i] for box in boxes) * GRID for i in (2, 3))
    scale = min((frame.width - 12) / (right - left), (frame.height - 6) / (top - bottom))
    x0 = frame.left + (frame.width - (right - left) * scale) / 2
    y0 = frame.bottom + (frame.height - (top - bottom) * scale) / 2

    def place(x: float, y: float) -> tuple[float, float]:
        return x0 + (x * GRID - left) * scale, y0 + (y * GRID - bottom) * scale

    _rectangle(canvas, place, found.outline, 0.8)
    for array in found.coupon:
        share = array.size[1] / (array.place.row_step[1] or array.size[1])
        _rectangle(canvas, place, _span(array), 0.2, fill=1 - 0.8 * share)
    canvas.setFont("Helvetica", 6)
    for number, (x, y) in enumerate(fiducial_centres(found), 1):
        px, py = place(x / GRID + found.outline[0], y / GRID + found.outline[1])
        for dx, dy in ((1.2, 0), (0, 1.2)):
            _line(canvas, (px - dx, py - dy), (px + dx, py + dy))
        outer = -4.6 if x < 0 else 1.6
        canvas.drawString((px + outer) * POINT, (py - 0.8) * POINT, f"F{number}")
    if found.coupon:
        spans = [_span(array) for array in found.coupon]
        px, py = place(max(span[2] for span in spans), spans[0][3])
        canvas.drawString((px + 1) * POINT, (py - 1.5) * POINT, "step wedge")
    px, py = place((window[0] + window[2]) / 2, (window[1] + window[3]) / 2)
    canvas.setStrokeColorRGB(*_OPEN)
    canvas.circle(px * POINT, py * POINT, 1.5 * POINT)
    canvas.setStrokeColorRGB(*_INK)
    canvas.drawString((px + 2.2) * POINT, (py - 0.8) * POINT, "cut-out")


def find_window(found: FoundMask, period: float) -> Box:
    """Return a square midway along the panel in which there are apertures; `period` [mm]."""
    left, bottom, right, top = found.outline
    side = min(max(PERIODS * period, LEAST), MOST) / GRID
    side = int(min(side, right - left, top - bottom))
    boxes = []
    for share in PLACES:
        x = left + round((right - left - side) * share)
        y = bottom + round((top - bottom - side) / 2)
        boxes.append((x, y, x + side, y + side))
    return next((box for box in boxes if found.window(box).count()), boxes[0])


def draw_window(canvas: "Canvas", found: FoundMask, frame: Frame, window: Box) -> None:
    """Draw the cut-out, magnified: what is open blue, with a scale bar and its place."""
    side = min(frame.width, frame.height - 12)
    left, bottom = frame.left, frame.bottom + frame.height - side
    scale = side / (window[2] - window[0])
    open_first = found.drawn == "open"
    canvas.saveState()
    path = canvas.beginPath()
    path.rect(left * POINT, bottom * POINT, side * POINT, side * POINT)
    canvas.clipPath(path, stroke=0, fill=0)
    canvas.setFillColorRGB(*((1, 1, 1) if open_first else _OPEN))
    canvas.rect(left * POINT, bottom * POINT, side * POINT, side * POINT, stroke=0, fill=1)
    canvas.setFillColorRGB(*(_OPEN if open_first else (1, 1, 1)))
    for shape in found.window(window).each():
        box = shape.bbox()
        canvas.rect(
            (left + (box.left - window[0]) * scale) * POINT,
            (bottom + (box.bottom - window[1]) * scale) * POINT,
            box.width() * scale * POINT, box.height() * scale * POINT, stroke=0, fill=1,
        )  # fmt: skip
    canvas.restoreState()
    canvas.setLineWidth(0.4)
    canvas.rect(left * POINT, bottom * POINT, side * POINT, side * POINT)
    bar = _round_length((window[2] - window[0]) * GRID / 3)
    length = bar / GRID * scale
    _line(canvas, (left, bottom - 2.5), (left + length, bottom - 2.5), 1.2)
    canvas.setFont("Helvetica", 7)
    canvas.drawString((left + length + 2) * POINT, (bottom - 3.4) * POINT, f"{1000 * bar:g} µm")
    x, y = (window[i] * GRID - found.outline[i] * GRID for i in (0, 1))
    text = f"cut-out at x {x:.3f}, y {y:.3f} mm, {1 / GRID * scale:.0f} : 1; blue is open"
    canvas.drawString(left * POINT, (bottom - 8) * POINT, text)


def _round_length(most: float) -> float:
    """Return the largest of 1, 2, 5 times a power of ten that is at most `most` [mm]."""
    sizes = [digit * 10.0**power for power in range(-4, 1) for digit in (1, 2, 5)]
    return max(size for size in sizes if size <= most)


def _span(array: Any) -> Box:
    """Return the box of an array of rectangles, all its rows and columns."""
    (x, y), (left, bottom, right, top) = array.place.origin, array.box
    last_x = (array.place.columns - 1) * array.place.column_step[0]
    last_y = (array.place.rows - 1) * array.place.row_step[1]
    return x + left, y + bottom, x + right + last_x, y + top + last_y


def _rectangle(
    canvas: "Canvas", place: Any, box: Box, line: float, fill: float | None = None
) -> None:
    (x, y), (right, top) = place(*box[:2]), place(*box[2:])
    canvas.setLineWidth(line)
    if fill is not None:
        canvas.setFillGray(fill)
    canvas.rect(
        x * POINT, y * POINT, (right - x) * POINT, (top - y) * POINT, fill=0 if fill is None else 1
    )
    canvas.setFillGray(0)


def _line(
    canvas: "Canvas", start: tuple[float, float], end: tuple[float, float], width: float = 0.5
) -> None:
    canvas.setLineWidth(width)
    canvas.line(*(value * POINT for value in (*start, *end)))
