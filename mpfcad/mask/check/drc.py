"""Width and space checked with klayout on sampled windows; markers of what is too narrow."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.mask.check.found import Box, FoundMask
from mpfcad.mask.rule import GRID, MaskRules
from mpfcad.mask.whole import whole_file
from mpfcad.units import mm, um

if TYPE_CHECKING:
    import klayout.db as kdb

#: Side of a window, and where windows are: shares of the panel's width and length.
WINDOW = mm / GRID
SHARES = (0.02, 0.5, 0.98)
#: Rounding of an edge on either side of a feature [grid steps].
ROUNDING = 2


@dataclass(frozen=True)
class Violation:
    """Something too narrow: the rule, and the corners of its two edges [grid steps]."""

    rule: str
    edges: tuple[int, int, int, int, int, int, int, int]


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
    import klayout.db as kdb

    limits = [("min_aperture", rules.aperture_limit), ("min_web", rules.web_limit)]
    names, limit = zip(*limits, strict=True)
    if found.drawn == "closed":
        names = names[::-1]
        limit = limit[::-1]
    steps = [max(0, round(value / GRID) - ROUNDING) for value in limit]
    violations, area = [], []
    for box in windows:
        region = found.window(box).merged()
        clipped = (region & kdb.Region(kdb.Box(*box))).area()
        size = (box[2] - box[0]) * (box[3] - box[1])
        area.append(float(clipped if found.drawn == "open" else size - clipped))
        narrow: tuple[tuple[str, Callable[[], kdb.EdgePairs]], ...] = (
            (names[0], lambda r=region: r.width_check(steps[0])),
            (names[1], lambda r=region: r.space_check(steps[1])),
        )
        for rule, check in narrow:
            violations += [Violation(rule, edges) for edges in _edges(check())]
    return WindowCheck(windows, tuple(dict.fromkeys(violations)), tuple(area))


def _edges(pairs: "kdb.EdgePairs") -> Iterator[tuple[int, ...]]:
    """Yield the corners of edge pairs in a fixed order."""
    found = []
    for pair in pairs.each():
        a, b = pair.first, pair.second
        found.append((a.x1, a.y1, a.x2, a.y2, b.x1, b.y1, b.x2, b.y2))
    yield from sorted(found)


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
        "min_aperture": "aperture narrower than min_aperture_um",
        "min_web": "web narrower than min_web_um",
        "window": "a window that was looked at",
    }
    category = {}
    for name, description in rules.items():
        category[name] = report.create_category(name)
        category[name].description = description
    scale = GRID / um
    for box in check.windows:
        _add(report, cell, category["window"], kdb.DBox(*(np.array(box) * scale)))
    for violation in check.violations:
        a = np.array(violation.edges) * scale
        pair = kdb.DEdgePair(kdb.DEdge(*a[:4]), kdb.DEdge(*a[4:]))
        _add(report, cell, category[violation.rule], pair)
    with whole_file(path) as part:
        report.save(str(part))


def _add(report: Any, cell: Any, category: Any, value: object) -> None:
    import klayout.rdb as rdb

    item = report.create_item(cell.rdb_id(), category.rdb_id())
    item.add_value(rdb.RdbItemValue(value))
