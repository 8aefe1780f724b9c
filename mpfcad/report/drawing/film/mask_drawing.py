"""Windows of the mask, drawn from the mask file with klayout."""

from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.film import PrismFilm
from mpfcad.report.drawing import svg
from mpfcad.units import um

if TYPE_CHECKING:
    import klayout.db as kdb

#: Grooves and periods in a window, and its width in the drawing.
GROOVES, PERIODS = 6, 3.25
WIDTH = 720.0
OPEN = 'fill="#0b5fa5" fill-opacity="0.8" stroke="none"'
EDGE = 'stroke="#bbb" stroke-width="0.7"'


def draw_mask(path: Path, panel: PrismFilm, windows: dict[str, int], period: float) -> str:
    """Return the SVG of some windows of a mask file, midway along the panel.

    Parameters
    ----------
    path
        mask.oas or mask.gds
    panel
        the film over the panel
    windows
        title of each window -> its first groove
    period
        of the apertures along the grooves [mm]
    """
    import klayout.db as kdb

    layout = kdb.Layout()
    layout.read(str(path))
    length = max(PERIODS * period, 2.5 * GROOVES * panel.groove.pitch)
    length = min(length, panel.length / 2) / um
    # Along the grooves runs to the right, so that a window is wider than high.
    scale = WIDTH / length
    top = 0.0
    parts: list[str] = []
    for title, first in windows.items():
        count = min(GROOVES, panel.groove_count - first)
        caption = f"{path.name}, {title}: grooves {first} to {first + count - 1} (top to bottom)"
        parts.append(svg.text(20, top + 15, caption, 'font-size="12"'))
        parts += _draw_window(layout, panel, first, count, length, scale, top + 24)
        top += 24 + count * panel.groove.pitch / um * scale + 10
    parts.append(svg.text(20, top + 10, f"{length:.0f} µm along the grooves", 'font-size="12"'))
    return svg.picture(WIDTH + 40, top + 18, "Windows of the mask; blue is open", parts)


def _draw_window(
    layout: "kdb.Layout",
    panel: PrismFilm,
    first: int,
    count: int,
    length: float,
    scale: float,
    top: float,
) -> list[str]:
    """Return the drawing of `count` grooves, `length` µm long, at height `top` of the picture."""
    left, bottom = first * panel.groove.pitch / um, panel.length / 2 / um
    width = count * panel.groove.pitch / um
    parts = [svg.rectangle(20, top, WIDTH, width * scale, 'fill="#f4f4f4" stroke="#888"')]
    for x1, y1, x2, y2 in _apertures(layout, left, bottom, left + width, bottom + length):
        size = ((y2 - y1) * scale, (x2 - x1) * scale)
        corner = (20 + (y1 - bottom) * scale, top + (x1 - left) * scale)
        parts.append(svg.rectangle(*corner, *size, OPEN))
    for i in range(1, count):
        y = top + i * width / count * scale
        parts.append(svg.line(20, y, 20 + WIDTH, y, EDGE))
    return parts


def _apertures(
    layout: "kdb.Layout", left: float, bottom: float, right: float, top: float
) -> list[tuple[float, float, float, float]]:
    """Return the apertures [µm] in a window, cut at its edge, in a fixed order."""
    import klayout.db as kdb

    from mpfcad.mask.layer import APERTURE

    layer = layout.find_layer(APERTURE, 0)
    if layer is None:  # a film without resin has no aperture
        return []
    window = kdb.DBox(left, bottom, right, top)
    shapes = layout.top_cell().begin_shapes_rec_touching(layer, window)
    found = []
    while not shapes.at_end():
        box = (shapes.dtrans() * shapes.shape().dbbox()) & window
        if not box.empty() and box.width() > 0 and box.height() > 0:
            found.append((box.left, box.bottom, box.right, box.top))
        shapes.next()
    return sorted(found)
