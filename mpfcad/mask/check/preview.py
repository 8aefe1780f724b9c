"""A picture of a mask as its file holds it: the whole panel's ratio, and windows of apertures.

Black on white, the ratio in shades of blue with its scale; the same file gives the same bytes.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary.out import whole_file
from mpfcad.mask.aperture import Mask
from mpfcad.mask.check.check import READERS, SQUARE, MaskCheck
from mpfcad.mask.check.drc import sample_windows
from mpfcad.mask.check.found import Box, FoundMask
from mpfcad.mask.rule import GRID
from mpfcad.units import um

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

#: Pixels: the panel's longer side, a window's side, space between, and the scale's width.
PANEL, TILE, GAP, SCALE = 700, 300, 24, 16
INK, SOFT, OPEN = (29, 35, 42), (90, 101, 112), (11, 95, 165)
#: A wanted ratio that varies less along the grooves is the same there.
SAME = 1e-9
#: Averages along: over at most so many squares, at most so far from whole periods.
MOST_SQUARES, NEARLY = 16, 0.01
#: Shades from the smallest ratio to the largest.
LOW, HIGH = np.array((235, 241, 247.0)), np.array((8, 48, 107.0))


def write_preview(path: Path, file: Path, check: MaskCheck, mask: Mask) -> None:
    """Write the PNG at `path` of the mask in `file`, whose check is `check`.

    `mask` says what period the apertures repeat with; what is drawn is what the file holds.
    """
    from PIL import Image, ImageDraw

    ratio = panel_ratio(check, mask)
    panel = _panel(ratio, check.width / check.length)
    windows = _windows(file)
    side = (TILE + GAP + 18) * len(windows)
    height = max(panel.height + 60, side) + 2 * GAP
    picture = Image.new("RGB", (panel.width + SCALE + 120 + TILE + 2 * GAP, height), "white")
    pencil = ImageDraw.Draw(picture)
    picture.paste(panel, (GAP, GAP + 40))
    low, high = float(check.aperture_ratio.min()), float(check.aperture_ratio.max())
    title = f"{file.name}: aperture ratio of the grooves, {low:.4f} to {high:.4f}"
    pencil.text((GAP, GAP - 6), title, fill=INK)
    size = f"{check.width:.6g} mm across the grooves (to the right) x {check.length:.6g} mm along"
    pencil.text((GAP, GAP + 12), size, fill=SOFT)
    span = (float(ratio.min()), float(ratio.max()))
    _draw_scale(picture, pencil, GAP + panel.width + 14, GAP + 40, panel.height, span)
    left = GAP + panel.width + SCALE + 96
    for i, (name, window) in enumerate(windows):
        top = GAP + i * (TILE + GAP + 18)
        pencil.text((left, top - 6), name, fill=INK)
        picture.paste(window, (left, top + 12))
        pencil.rectangle((left - 1, top + 11, left + TILE, top + 12 + TILE), outline=SOFT)
    with whole_file(path) as part:
        picture.save(part, "PNG", optimize=False, compress_level=9)


def panel_ratio(check: MaskCheck, mask: Mask) -> NDArray[np.float64]:
    """Return the file's aperture ratio over the panel, (along, across) float64, without beats.

    Where every groove has one ratio, that of each groove (one row). Elsewhere that of 1 mm squares,
    averaged along over nearly whole periods of the apertures: a square alone holds one aperture
    more or less than the next.
    """
    if float(np.ptp(mask.wanted_map(SQUARE), axis=0).max()) < SAME:
        return check.aperture_ratio[None, :]
    squares = check.ratio_map
    count = min(whole_periods(mask.period), len(squares))
    total = np.concatenate([np.zeros((1, squares.shape[1])), np.cumsum(squares, axis=0)])
    return (total[count:] - total[:-count]) / count


def whole_periods(period: float) -> int:
    """Return the least number of squares whose length is nearly a whole number of periods [mm]."""
    count = np.arange(1, MOST_SQUARES + 1)
    turns = count * SQUARE / period
    miss = np.abs(turns - np.rint(turns)) / turns
    good = np.flatnonzero(miss < NEARLY)
    return int(count[good[0]] if len(good) else count[np.argmin(miss)])


def _panel(ratio: NDArray[np.float64], aspect: float) -> "Image.Image":
    """Return the ratio, along upwards, as one picture; its pixels average by area."""
    from PIL import Image

    factor = PANEL / max(aspect, 1.0)
    size = (max(1, round(factor * aspect)), max(1, round(factor)))
    image = Image.fromarray(ratio[::-1].astype(np.float32), mode="F")
    across = image.resize((size[0], image.height), Image.Resampling.BOX)
    whole = np.asarray(across.resize(size, Image.Resampling.BOX), float)
    return Image.fromarray(_shade(whole, float(ratio.min()), float(ratio.max())))


def _shade(ratio: NDArray[np.float64], low: float, high: float) -> NDArray[np.uint8]:
    # A uniform mask has one shade, whatever the last bit of its ratio.
    share = np.clip((ratio - low) / max(high - low, 1e-6), 0.0, 1.0)
    return np.rint(LOW + (HIGH - LOW) * share[..., None]).astype(np.uint8)


def _draw_scale(
    picture: "Image.Image",
    pencil: "ImageDraw.ImageDraw",
    left: int,
    top: int,
    height: int,
    span: tuple[float, float],
) -> None:
    """Draw the scale of ratios, the largest at the top."""
    from PIL import Image

    ramp = np.repeat(np.linspace(1, 0, height)[:, None], SCALE, axis=1)
    picture.paste(Image.fromarray(_shade(ramp, 0.0, 1.0)), (left, top))
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        y = top + round((1 - share) * (height - 1))
        pencil.line((left + SCALE, y, left + SCALE + 4, y), fill=SOFT)
        value = f"{span[0] + share * (span[1] - span[0]):.4f}"
        pencil.text((left + SCALE + 8, y - 6), value, fill=SOFT)


def _windows(file: Path) -> list[tuple[str, "Image.Image"]]:
    """Return windows at the panel's left edge and at its middle, along midway."""
    reader = READERS.get(file.suffix.removeprefix("."))
    if reader is None:  # pixels are not drawn again
        return []
    found = reader(file)
    windows = sample_windows(found.outline)
    chosen = (windows[1], windows[len(windows) // 2])
    return [_window(found, box) for box in dict.fromkeys(chosen)]


def _window(found: FoundMask, box: Box) -> tuple[str, "Image.Image"]:
    """Return a window's name and picture; what is open is blue."""
    from PIL import Image, ImageDraw

    side = max(box[2] - box[0], box[3] - box[1])
    picture = Image.new("RGB", (TILE * 2, TILE * 2), "white")
    pencil = ImageDraw.Draw(picture)
    scale = (TILE * 2) / side
    if found.drawn == "closed":
        pencil.rectangle((0, 0, (box[2] - box[0]) * scale, TILE * 2), fill=OPEN)
    fill = OPEN if found.drawn == "open" else (255, 255, 255)
    for shape in found.window(box).each():
        inner = shape.bbox()
        corner = ((inner.left - box[0]) * scale, (box[3] - inner.top) * scale)
        end = ((inner.right - box[0]) * scale - 1, (box[3] - inner.bottom) * scale - 1)
        pencil.rectangle((*corner, max(end[0], corner[0]), max(end[1], corner[1])), fill=fill)
    steps = GRID / um
    name = (
        f"{side * steps:.0f} um square at x {box[0] * GRID:.2f} mm, y {box[1] * GRID:.2f} mm; "
        "blue is open"
    )
    return name, picture.resize((TILE, TILE), Image.Resampling.BOX)
