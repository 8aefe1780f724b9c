"""A measured surface in every groove: its resin made higher or lower until it is that of the mask.

A measured groove is (k, 3) float64, as `average_groove` gives it: x from the centre, height above
the bare groove's valley [mm], and curvature [1/mm] of the piece to the right (0: straight). The
walls are straight on each side of the centre, which is a corner: so resin on a curved piece has the
piece's own curvature.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.quadratic import bow_area
from mpfcad.film.section import LINE, PARABOLA, Section, join_pieces

#: Resin over that of the measured groove for which its shape still tells that of another.
MEASURED_SHARE = 0.5, 2.0


@dataclass(frozen=True, eq=False)
class MeasuredResin:
    """The resin of a measured surface over the groove's walls.

    Attributes
    ----------
    height
        (k,) float64 [mm], at the corners; 0 at the tips and where the surface is below the walls
    bend
        (k-1,) float64 [1/mm], curvature of the resin between corners; 0 where there is none
    area
        of the cross-section [mm²]
    """

    height: NDArray[np.float64]
    bend: NDArray[np.float64]
    area: float


def measured_resin(film: PrismFilm, measured: NDArray[np.float64]) -> MeasuredResin:
    """Return the resin of a measured surface: what lies over the walls of the film's grooves."""
    x = measured[:, 0]
    height = np.maximum(measured[:, 1] - film.groove.wall_slope * np.abs(x), 0.0)
    height[[0, -1]] = 0.0
    covered = np.maximum(height[:-1], height[1:]) > 0
    bend = np.where(covered, measured[:-1, 2], 0.0)
    return MeasuredResin(height, bend, float(np.trapezoid(height, x)) - bow_area(x, bend))


def measured_bare_area(film: PrismFilm, measured: NDArray[np.float64]) -> float:
    """Return the area [mm²] between a bare groove's valley and the surface without its resin."""
    x, resin = measured[:, 0], measured_resin(film, measured)
    chords = float(np.trapezoid(measured[:, 1] - resin.height, x))
    return chords - bow_area(x, measured[:-1, 2] - resin.bend)


def measured_section(film: PrismFilm, measured: NDArray[np.float64]) -> Section:
    """Return the measured surface in every groove; its ends are the tips.

    Raises
    ------
    InputError
        when a `filled` film's groove holds less than half or more than twice the measured resin.
    """
    count, local = film.groove_count, measured[:-1, 0]
    height = np.tile(measured[:-1, 1], (count, 1))
    bend = np.tile(measured[:-1, 2], (count, 1))
    if film.profile == "filled":
        resin = measured_resin(film, measured)
        more = (_resin_share(film, resin.area) - 1)[:, None]
        height += more * resin.height[:-1]
        bend += more * resin.bend
    x = (film.groove_position[:, None] + local).ravel()
    x = np.append(np.maximum(x, 0.0), film.width)
    z = film.base + np.append(height.ravel(), measured[-1, 1])
    return _joined(film.length, x, z, bend.ravel())


def _joined(
    length: float, x: NDArray[np.float64], z: NDArray[np.float64], bend: NDArray[np.float64]
) -> Section:
    """Return the section of pieces between corners (m+1,), each with its curvature (m,)."""
    ends = [np.stack([line[:-1], line[1:]], 1) for line in (x, z)]
    kind = np.where(bend == 0, LINE, PARABOLA)
    steep = np.diff(z) / np.diff(x)
    safe = np.where(bend == 0, 1.0, bend)
    centre_x = (x[:-1] + x[1:]) / 2 - steep / safe
    centre_z = z[:-1] - safe / 2 * (x[:-1] - centre_x) ** 2
    return join_pieces(length, ends[0], kind, np.stack([centre_x, centre_z], 1), bend, ends[1])


def _resin_share(film: PrismFilm, measured_area: float) -> NDArray[np.float64]:
    """Return each groove's resin over that of the measured surface, (n,)."""
    area = film.fill_fraction * film.groove.area
    low, high = (float(bound) * measured_area for bound in MEASURED_SHARE)
    bad = np.flatnonzero(~((area >= low) & (area <= high)))
    if bad.size:
        held = measured_area / film.groove.area
        worst = int(bad[np.argmax(np.abs(area[bad] - measured_area))])
        raise InputError(
            f"film: measured surface: holds {held:.4g} of a full groove, the mask gives groove "
            f"{worst} {film.fill_fraction[worst]:.4g}: expected a trace of a groove with "
            f"{MEASURED_SHARE[0]:g} to {MEASURED_SHARE[1]:g} times that resin"
        )
    share: NDArray[np.float64] = area / measured_area
    return share
