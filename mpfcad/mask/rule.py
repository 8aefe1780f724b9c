"""What the screen maker can make, and the refusal of grooves whose apertures he cannot."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import PanelFilm, Process, groove_ranges
from mpfcad.mask.fabric import Mesh, coarsest_mesh, shipped_catalogue
from mpfcad.units import deg, nm, um

Pattern = Literal["slot", "dot", "staggered", "angled", "blue-noise", "error-diffused"]
PATTERNS: tuple[Pattern, ...] = (
    "slot",
    "dot",
    "staggered",
    "angled",
    "blue-noise",
    "error-diffused",
)
#: Patterns that leave cells closed instead of making their aperture smaller.
STOCHASTIC: tuple[Pattern, ...] = ("blue-noise", "error-diffused")
#: Coordinates are whole numbers of this many mm.
GRID = nm


@dataclass(frozen=True)
class MaskRules:
    """What the screen maker can make; lengths in mm.

    Attributes
    ----------
    pattern
        one of `PATTERNS`
    period
        nominal distance of the apertures, or of a stochastic pattern's cells, along the grooves
    min_aperture
        smallest width of an opening
    min_web
        smallest width of what stands between openings
    angle
        of the rows of dots of an `angled` lattice against the across direction [rad]
    dot
        side of a stochastic pattern's dots; None: the largest that leaves `min_web`
    levelling_length
        over which the resin levels along a groove (full width at half maximum)
    mesh
        the screen's mesh, whose own smallest feature counts too; None: no mesh rule
    """

    pattern: Pattern
    period: float
    min_aperture: float
    min_web: float
    angle: float = 22.5 * deg
    dot: float | None = None
    levelling_length: float = 1.0
    mesh: Mesh | None = None

    @property
    def is_stochastic(self) -> bool:
        """Whether cells stay closed instead of apertures getting smaller."""
        return self.pattern in STOCHASTIC

    @property
    def aperture_limit(self) -> float:
        """Smallest aperture [mm], of screen maker and mesh."""
        return max(self.min_aperture, self.mesh.min_feature if self.mesh else 0.0)

    @property
    def web_limit(self) -> float:
        """Smallest web [mm], of screen maker and mesh."""
        return max(self.min_web, self.mesh.min_feature if self.mesh else 0.0)

    def describe(self, period: float) -> str:
        """Return the rules as text for a message; `period` [mm] is the stretched one."""
        by_mesh = f" (mesh {self.mesh.name})" if self.mesh else ""
        return (
            f"{self.pattern} period {period / um:.4g} µm, "
            f"min_aperture {self.aperture_limit / um:.4g} µm, "
            f"min_web {self.web_limit / um:.4g} µm{by_mesh}"
        )


def dot_side(rules: MaskRules, pitch: float, period: float, where: str = "job") -> float:
    """Return the (largest) side of a stochastic pattern's dots [mm].

    Blue-noise dots are up to √2 smaller than that: one dot of a tile just becoming two.

    Raises
    ------
    InputError
        when no dot of that side fits a cell of `pitch` × `period` [mm].
    """
    largest = min(pitch, period) - rules.web_limit
    side = largest if rules.dot is None else rules.dot
    smallest = rules.aperture_limit * (2**0.5 if rules.pattern == "blue-noise" else 1)
    if not smallest <= side * (1 + 1e-9) <= largest * (1 + 2e-9):
        raise InputError(
            f"{where}: mask.dot_um: {side / um:.4g}: expected {smallest / um:.4g} … "
            f"{largest / um:.4g} µm ({rules.describe(period)})"
        )
    return side


def ratio_range(
    rules: MaskRules, pitch: float, period: float, where: str = "job"
) -> tuple[float, float]:
    """Return the smallest and largest aperture ratio above 0 that the rules allow (lengths in mm).

    Between dots the web counts across and along; a slot has its web along only. A stochastic
    pattern reaches any ratio down to 0.
    """
    if rules.pattern == "slot":
        return rules.aperture_limit / period, 1 - rules.web_limit / period
    if rules.is_stochastic:
        return 0.0, dot_side(rules, pitch, period, where) ** 2 / (pitch * period)
    side = max(0.0, min(pitch, period) - rules.web_limit)
    return rules.aperture_limit**2 / (pitch * period), side**2 / (pitch * period)


def check_rules(
    where: str,
    ratio: NDArray[np.float64],
    along: NDArray[np.int64],
    film: PanelFilm,
    process: Process,
    rules: MaskRules,
    period: float,
) -> None:
    """Refuse apertures and webs that are too small; `period` [mm] is the stretched one.

    Raises
    ------
    InputError
        one line naming the grooves, their ratios, and the ratios, curvatures and mesh expected.
    """
    pitch, empty = film.groove.pitch, film.groove.curvature_empty
    low, high = ratio_range(rules, pitch, period, where)
    asked = rules.describe(period)
    if low > high:
        needed = (rules.aperture_limit + rules.web_limit) / um
        room, other = "mask.period_um", ""
        if rules.pattern != "slot":
            room, other = f"{room} and a pitch", ", or mask.pattern = 'slot'"
        raise InputError(
            f"{where}: mask.period_um: {period / um:.4g}: no aperture fits ({asked}): expected "
            f"{room} of {needed:.4g} or more{other}"
        )
    size = along * GRID
    largest = (period if rules.pattern == "slot" else min(pitch, period)) - rules.web_limit
    wet = film.groove.takes_resin(film.extremes()[0])
    bad = np.flatnonzero(wet & ((size < rules.aperture_limit - GRID) | (size > largest + GRID)))
    if bad.size:
        curvature = film.extremes()[0][bad]
        top = process.curvature(low)
        bottom = process.curvature(min(high, process.aperture_ratio_max))
        raise InputError(
            f"{where}: map: {groove_ranges(bad)}: curvature_per_mm {curvature.min():.4g} … "
            f"{curvature.max():.4g} (aperture_ratio {ratio[bad].min():.4g} … "
            f"{ratio[bad].max():.4g}): expected {bottom:.4g} … {top:.4g} or {empty:g} "
            f"(no resin; ratio {low:.4g} … {high:.4g}: {asked})"
            f"{suggest_mesh(rules, size[wet].astype(np.float64), period)}"
        )
    if rules.pattern == "slot":
        _check_runs(where, along > 0, pitch, rules)


def suggest_mesh(rules: MaskRules, size: NDArray[np.float64], period: float) -> str:
    """Return the end of a refusal: the mesh that would do for apertures of `size` [mm], if any."""
    if rules.mesh is None:
        return ""
    feature = float(min(size.min(), period - size.max()))
    material = rules.mesh.material
    mesh = (
        coarsest_mesh(feature, material)
        if feature >= min(rules.min_aperture, rules.min_web)
        else None
    )
    if mesh is not None:
        return f"; mesh {mesh.name} would do"
    same = [mesh for mesh in shipped_catalogue() if mesh.material == material]
    finest = min(same, key=lambda mesh: mesh.min_feature)
    needed = max(finest.min_feature, rules.min_aperture, rules.min_web)
    longer = ""
    if rules.pattern == "slot":
        longer = f" (period {period * needed / max(feature, GRID) / um:.4g} µm)"
    return (
        f"; no mesh at this period: {finest.name} needs {needed / um:.4g} µm{longer}; see "
        "mpfcad mask --propose"
    )


def _check_runs(where: str, is_open: NDArray[np.bool_], pitch: float, rules: MaskRules) -> None:
    """Refuse slots, and closed stretches between slots, that are too narrow across the grooves."""
    start = np.concatenate([[0], np.flatnonzero(np.diff(is_open)) + 1])
    end = np.concatenate([start[1:], [len(is_open)]])
    inside = (start > 0) & (end < len(is_open))
    width = (end - start) * pitch
    open_run = is_open[start]
    for name, what, limit, bad in (
        ("min_aperture", "slots", rules.aperture_limit, open_run & (width < rules.aperture_limit)),
        ("min_web", "webs", rules.web_limit, ~open_run & inside & (width < rules.web_limit)),
    ):
        if bad.any():
            grooves = np.concatenate(
                [np.arange(a, b) for a, b in zip(start[bad], end[bad], strict=True)]
            )
            raise InputError(
                f"{where}: map: {groove_ranges(grooves)}: {what} of {width[bad].min() / um:g} µm "
                f"across the grooves: expected mask.{name}_um, {limit / um:g}, or more"
            )
