"""Apertures and webs that are too narrow, found with klayout on sampled windows; markers of them.

A place is wide enough where a square of the smallest size fits into what is open (or closed) and
covers it: `region` less its opening by that square is what is too narrow. Slots are drawn groove by
groove: where the ratio changes, their edges step, so what stands on an aperture that is wide enough
and is thinner than an eighth of the limit (or `STEP`) is such a step and no neck. Between two
different apertures klayout measures the distance itself, corners too. A window is looked at with a
margin, so that its cut makes no marker.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.boundary.out import whole_file
from mpfcad.mask.check.found import Box, FoundMask
from mpfcad.mask.rule import GRID, MaskRules
from mpfcad.units import mm, um

if TYPE_CHECKING:
    import klayout.db as kdb

#: Side of a window, and where windows are: shares of the panel's width and length.
WINDOW = mm / GRID
SHARES = (0.02, 0.5, 0.98)
#: Rounding of an edge on either side of a feature [grid steps].
ROUNDING = 2
#: What is thinner is an edge's step between neighbouring grooves [grid steps; share of the limit].
STEP, STEP_SHARE = round(2 * um / GRID), 8


@dataclass(frozen=True)
class Violation:
    """Something too narrow: the rule, and left, bottom, right, top of it [grid steps]."""

    rule: str
    box: Box


@dataclass(frozen=True, eq=False)
class WindowCheck:
    """What was found in the sampled windows.

    Attributes
    ----------
    windows
        the windows [grid steps]
    violations
        what is too narrow in them
    area
        of the apertures in each window [grid steps²]
    """

    windows: tuple[Box, ...]
    violations: tuple[Violation, ...]
    area: tuple[float, ...]


def sample_windows(outline: Box, extremes: tuple[int, ...] = ()) -> tuple[Box, ...]:
    """Return windows at the edges and the middle of the panel, and about the x of `extremes`."""
    left, bottom, right, top = outline
    size = (min(WINDOW, right - left), min(WINDOW, top - bottom))

    def around(x: float, y: float) -> Box:
        x = min(max(x - size[0] / 2, left), right - size[0])
        y = min(max(y - size[1] / 2, bottom), top - size[1])
        return int(x), int(y), int(x + size[0]), int(y + size[1])

    width, length = right - left, top - bottom
    places = [(left + a * width, bottom + b * length) for a in SHARES for b in SHARES]
    places += [(x, bottom + length / 2) for x in extremes]
    return tuple(dict.fromkeys(around(x, y) for x, y in places))


def check_windows(found: FoundMask, rules: MaskRules, windows: tuple[Box, ...]) -> WindowCheck:
    """Check apertures and webs in some windows of a file."""
    limits = [max(0, round(value / GRID) - 2 * ROUNDING)
              for value in (rules.aperture_limit, rules.web_limit)]  # fmt: skip
    violations: list[Violation] = []
    area = []
    for box in windows:
        opened, drawn_area = _open_region(found, box, 2 * max(limits) + STEP)
        area.append(drawn_area)
        violations += find_narrow(opened, box, limits[0], limits[1])
    return WindowCheck(windows, tuple(dict.fromkeys(violations)), tuple(area))


def _open_region(found: FoundMask, box: Box, margin: int) -> tuple["kdb.Region", float]:
    """Return what is open in a box and a margin around it, and its area in the box."""
    import klayout.db as kdb

    wide = kdb.Box(*box).enlarged(margin, margin)
    drawn = found.window((wide.left, wide.bottom, wide.right, wide.top)).merged()
    inner = kdb.Region(kdb.Box(*box))
    if found.drawn == "open":
        return drawn, float((drawn & inner).area())
    panel = kdb.Region(kdb.Box(*found.outline)) & kdb.Region(wide)
    opened = panel - drawn
    return opened, float((opened & inner).area())


def find_narrow(
    opened: "kdb.Region", box: Box, aperture_limit: int, web_limit: int
) -> list[Violation]:
    """Return what is too narrow of open regions, and between them, in a box [grid steps]."""
    import klayout.db as kdb

    wide = kdb.Region(opened.bbox() + kdb.Box(*box).enlarged(web_limit, web_limit))
    found = []
    narrow = {
        "min_aperture": _too_thin(opened, aperture_limit),
        "min_web": _too_thin(wide.sized(2 * web_limit) - opened, web_limit),
    }
    metrics = kdb.Metrics.Euclidian
    close: Any = opened.isolated_check(web_limit, metrics=metrics) if web_limit else []
    inside = kdb.Box(*box)
    for rule, region in narrow.items():
        found += [Violation(rule, _corners(p.bbox())) for p in region.each()
                  if p.bbox().touches(inside)]  # fmt: skip
    if web_limit:
        found += [Violation("min_web", _corners(pair.bbox())) for pair in close.each()
                  if pair.bbox().touches(inside)]  # fmt: skip
    return sorted(set(found), key=lambda violation: (violation.rule, violation.box))


def _too_thin(region: "kdb.Region", limit: int) -> "kdb.Region":
    """Return what no square of side `limit` covers within a region, less what is a mere step."""
    import klayout.db as kdb

    half = limit // 2
    if half < 1:
        return kdb.Region()
    square = 2  # corners stay corners
    wide = region.sized(-half, square).sized(half, square)
    alone = region.not_interacting(wide)  # all of it is too narrow, however thin
    left = region - wide
    step = max(STEP, limit // STEP_SHARE) // 2
    return (left.sized(-step, square).sized(step, square) + alone).merged()


def _corners(box: "kdb.Box") -> Box:
    return box.left, box.bottom, box.right, box.top


def write_markers(path: Path, source: str, check: WindowCheck) -> None:
    """Write the violations as a KLayout marker database (.lyrdb), also when there is none."""
    import klayout.db as kdb
    import klayout.rdb as rdb

    report = rdb.ReportDatabase("mpfcad")
    report.description = "Screen mask: apertures and webs in sampled windows"
    report.original_file = source
    report.generator = "mpfcad"
    cell = report.create_cell("MASK")
    rules = {
        "min_aperture": "aperture narrower than min_aperture_um, or than a cell of the mesh",
        "min_web": "web narrower than min_web_um, or than a cell of the mesh",
        "window": "a window that was looked at",
    }
    category = {}
    for name, description in rules.items():
        category[name] = report.create_category(name)
        category[name].description = description
    scale = GRID / um
    marked = [("window", box) for box in check.windows]
    marked += [(violation.rule, violation.box) for violation in check.violations]
    for name, box in marked:
        item = report.create_item(cell.rdb_id(), category[name].rdb_id())
        item.add_value(rdb.RdbItemValue(kdb.DBox(*(np.array(box) * scale))))
    with whole_file(path) as part:
        report.save(str(part))
