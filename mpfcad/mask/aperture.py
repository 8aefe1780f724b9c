"""From a film to apertures: per groove one array of equal rectangles, on a 1 nm grid.

The period is stretched by less than half of itself over the whole length so that a whole number of
periods fills the panel: period = length / round(length / nominal period). With ratio a and groove
pitch p an aperture is

* `slot`: p across, a · period along; equal neighbours make one slot across all the grooves;
* `dot`: a square of side sqrt(a · p · period);

so that apertures over groove area is a, but for rounding to the grid.
"""

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import PrismFilm, Process, check_printable
from mpfcad.mask.rule import GRID, MaskRules, Pattern, check_rules

#: GDSII coordinates are 32-bit: no panel side may be longer [grid steps].
LARGEST_SIDE = 2_100_000_000


@dataclass(frozen=True, eq=False)
class Mask:
    """The apertures of a panel, symbolic: one array of rectangles a groove.

    Attributes
    ----------
    name
        the job's name
    content_hash
        first 12 hexadecimal digits of SHA-256 over the curvatures (little-endian float64)
    rules
        what was asked for
    pitch, length
        of the grooves [mm]
    wanted_ratio
        (n,) float64, the aperture ratio that each groove's curvature needs
    left, bottom
        (n,) int64 [grid steps], lower left corner of each groove's first aperture
    across, along
        (n,) int64 [grid steps], size of each groove's apertures; 0 where it has none
    period_steps, period_count
        distance of the apertures along the groove [grid steps], and how many there are
    """

    name: str
    content_hash: str
    rules: MaskRules
    pitch: float
    length: float
    wanted_ratio: NDArray[np.float64]
    left: NDArray[np.int64]
    bottom: NDArray[np.int64]
    across: NDArray[np.int64]
    along: NDArray[np.int64]
    period_steps: int
    period_count: int

    @property
    def groove_count(self) -> int:
        """Number of grooves n."""
        return len(self.wanted_ratio)

    @property
    def period(self) -> float:
        """Distance of the apertures along the grooves as made [mm]."""
        return self.period_steps * GRID

    @property
    def is_open(self) -> NDArray[np.bool_]:
        """Whether each groove has apertures, (n,) bool."""
        return self.across > 0

    @property
    def aperture_count(self) -> int:
        """Number of apertures in all."""
        return int(np.count_nonzero(self.is_open)) * self.period_count

    @property
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""
        area = self.across * self.along * self.period_count * GRID**2
        return area / (self.pitch * self.length)


def build_mask(film: PrismFilm, process: Process, rules: MaskRules, name: str) -> Mask:
    """Return the mask that prints a film.

    Parameters
    ----------
    film
        the panel
    process
        gives each groove's aperture ratio
    rules
        pattern, period and what the screen maker can make
    name
        the job's name, printable ASCII

    Raises
    ------
    InputError
        one line naming the grooves (counted from 0), the values and what is allowed.
    """
    where = f"{name}: mask"
    if film.profile != "filled":
        raise InputError(f"{where}: profile '{film.profile}': allowed 'filled', resin only adds")
    if not (name.isascii() and name.isprintable()):
        raise InputError(f"{name!r}: mask: name: allowed printable ASCII")
    check_printable(process, film.curvature, where)
    edge = np.rint(film.tip_position / GRID).astype(np.int64)
    length = round(film.length / GRID)
    if max(length, int(edge[-1])) > LARGEST_SIDE:
        side = max(film.length, film.width)
        raise InputError(f"{where}: panel side {side:g} mm: allowed up to {LARGEST_SIDE * GRID:g}")
    period_count = max(1, round(film.length / rules.period))
    period = length // period_count
    wanted = process.aperture_ratio_of_curvature(film.curvature)
    across, along = _aperture_size(wanted, film, rules.pattern, length / period_count)
    check_rules(where, wanted, along, film, process, rules, length / period_count * GRID)
    return Mask(
        name=name,
        content_hash=hashlib.sha256(film.curvature.astype("<f8").tobytes()).hexdigest()[:12],
        rules=rules,
        pitch=film.groove.pitch,
        length=film.length,
        wanted_ratio=wanted,
        left=edge[:-1] + (np.diff(edge) - across) // 2,
        bottom=(length - period * period_count) // 2 + (period - along) // 2,
        across=across,
        along=along,
        period_steps=period,
        period_count=period_count,
    )


def _aperture_size(
    ratio: NDArray[np.float64], film: PrismFilm, pattern: Pattern, period: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return width across and length along of each groove's apertures [grid steps], 0 for none.

    `period` is in grid steps, not yet rounded to the grid.
    """
    pitch = film.groove.pitch / GRID
    if pattern == "dot":
        along = np.rint(np.sqrt(ratio * pitch * period)).astype(np.int64)
        return along, along
    along = np.rint(ratio * period).astype(np.int64)
    groove_width = np.diff(np.rint(film.tip_position / GRID).astype(np.int64))
    return np.where(along > 0, groove_width, 0), along
