"""What the screen maker can make, and the refusal of grooves whose apertures he cannot."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import PrismFilm, Process, groove_ranges
from mpfcad.units import nm, um

Pattern = Literal["slot", "dot"]
PATTERNS: tuple[Pattern, ...] = ("slot", "dot")
#: Coordinates are whole numbers of this many mm.
GRID = nm


@dataclass(frozen=True)
class MaskRules:
    """What the screen maker can make; lengths in mm.

    Attributes
    ----------
    pattern
        `slot` or `dot`
    period
        nominal distance of the apertures along the grooves
    min_aperture
        smallest width of an opening
    min_web
        smallest width of what stands between openings
    """

    pattern: Pattern
    period: float
    min_aperture: float
    min_web: float


def ratio_range(rules: MaskRules, pitch: float, period: float) -> tuple[float, float]:
    """Return the smallest and largest aperture ratio above 0 that the rules allow (lengths in mm).

    Between dots the web counts across and along; a slot has its web along only.
    """
    if rules.pattern == "slot":
        return rules.min_aperture / period, 1 - rules.min_web / period
    side = max(0.0, min(pitch, period) - rules.min_web)
    return rules.min_aperture**2 / (pitch * period), side**2 / (pitch * period)


def check_rules(
    where: str,
    ratio: NDArray[np.float64],
    along: NDArray[np.int64],
    film: PrismFilm,
    process: Process,
    rules: MaskRules,
    period: float,
) -> None:
    """Refuse apertures and webs that are too small; `period` [mm] is the stretched one.

    Raises
    ------
    InputError
        one line naming the grooves, their ratios, and the ratios and curvatures allowed.
    """
    pitch, empty = film.groove.pitch, film.groove.curvature_empty
    low, high = ratio_range(rules, pitch, period)
    asked = (
        f"{rules.pattern} period {period / um:.4g} µm, "
        f"min_aperture {rules.min_aperture / um:g} µm, min_web {rules.min_web / um:g} µm"
    )
    if low > high:
        raise InputError(
            f"{where}: {asked}: no aperture fits: smallest ratio {low:.4g}, largest {high:.4g}"
        )
    size = along * GRID
    largest = (min(pitch, period) if rules.pattern == "dot" else period) - rules.min_web
    bad = np.flatnonzero(
        (along > 0) & ((size < rules.min_aperture - GRID) | (size > largest + GRID))
    )
    if bad.size:
        top = process.curvature(low)
        bottom = process.curvature(min(high, process.aperture_ratio_max))
        raise InputError(
            f"{where}: {groove_ranges(bad)}: aperture_ratio {ratio[bad].min():.4g} … "
            f"{ratio[bad].max():.4g} (curvature_per_mm {film.curvature[bad].min():.4g} … "
            f"{film.curvature[bad].max():.4g}): allowed 0 or {low:.4g} … {high:.4g} ({asked}), "
            f"that is curvature_per_mm {bottom:.4g} … {top:.4g} or {empty:g} (no resin)"
        )
    if rules.pattern == "slot":
        _check_runs(where, along > 0, pitch, rules)


def _check_runs(where: str, is_open: NDArray[np.bool_], pitch: float, rules: MaskRules) -> None:
    """Refuse slots, and closed stretches between slots, that are too narrow across the grooves."""
    start = np.concatenate([[0], np.flatnonzero(np.diff(is_open)) + 1])
    end = np.concatenate([start[1:], [len(is_open)]])
    inside = (start > 0) & (end < len(is_open))
    width = (end - start) * pitch
    open_run = is_open[start]
    for name, what, limit, bad in (
        ("min_aperture", "slots", rules.min_aperture, open_run & (width < rules.min_aperture)),
        ("min_web", "webs", rules.min_web, ~open_run & inside & (width < rules.min_web)),
    ):
        if bad.any():
            grooves = np.concatenate(
                [np.arange(a, b) for a, b in zip(start[bad], end[bad], strict=True)]
            )
            raise InputError(
                f"{where}: {groove_ranges(grooves)}: {what} of {width[bad].min() / um:g} µm across "
                f"the grooves: allowed {name} {limit / um:g} µm or more"
            )
