"""The apertures of a panel: what every mask tells, and the masks with one array a groove.

The period is stretched by less than half of itself over the whole length so that a whole number of
periods fills the panel: period = length / round(length / nominal period). With ratio a and groove
pitch p an aperture is

* `slot`: p across, a · period along; equal neighbours make one slot across all the grooves;
* `dot`, `staggered`, `angled`: a square of side sqrt(a · p · period), every groove's moved along by
  nothing, by half a period every other one, or by p · tan(angle) more than its neighbour's;

so that apertures over groove area is a, but for rounding to the grid.
"""

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import PrismFilm, Process, check_printable
from mpfcad.mask.array import ApertureArray, Placement, TileArray
from mpfcad.mask.rule import GRID, MaskRules, check_rules

#: GDSII coordinates are 32-bit: no panel side may be longer [grid steps].
LARGEST_SIDE = 2_100_000_000


@dataclass(frozen=True, eq=False)
class Mask(ABC):
    """What every mask of a panel tells; it is never flattened.

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
    groove_count
        number of grooves n
    """

    name: str
    content_hash: str
    rules: MaskRules
    pitch: float
    length: float
    groove_count: int

    @property
    def width(self) -> float:
        """Extent across the grooves [mm]."""
        return self.groove_count * self.pitch

    @property
    @abstractmethod
    def period(self) -> float:
        """Distance of the apertures along the grooves as made [mm]."""

    @property
    @abstractmethod
    def arrays(self) -> Iterable[ApertureArray]:
        """Arrays of apertures, each within one groove; may be gone through again and again.

        A dithered panel makes them as one goes, so that they never stand in memory together.
        """

    @property
    def tile_arrays(self) -> Iterable[TileArray]:
        """Tiles of apertures, besides `arrays`."""
        return ()

    @property
    @abstractmethod
    def aperture_count(self) -> int:
        """Number of apertures in all."""

    @property
    @abstractmethod
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""

    @property
    @abstractmethod
    def wanted_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio that each groove's curvature needs, its mean along, (n,) float64."""

    @abstractmethod
    def ratio_map(self, cell: float) -> NDArray[np.float64]:
        """Return the mean ratio as drawn over squares of side `cell` [mm], (along, across).

        Squares are counted from the panel's lower left corner; the last of a side are cut.
        """

    @abstractmethod
    def wanted_map(self, cell: float) -> NDArray[np.float64]:
        """Return the mean of the wanted ratio over the same squares."""


@dataclass(frozen=True, eq=False)
class GrooveMask(Mask):
    """A mask with one array of equal rectangles a groove.

    Attributes
    ----------
    groove_ratio
        (n,) float64, the aperture ratio that each groove's curvature needs
    left, bottom
        (n,) int64 [grid steps], lower left corner of each groove's first aperture
    across, along
        (n,) int64 [grid steps], size of each groove's apertures; 0 where it has none
    count
        (n,) int64, number of apertures in each groove
    period_steps, period_count
        distance of the apertures along the groove [grid steps], and how many the length holds
    """

    groove_ratio: NDArray[np.float64]
    left: NDArray[np.int64]
    bottom: NDArray[np.int64]
    across: NDArray[np.int64]
    along: NDArray[np.int64]
    count: NDArray[np.int64]
    period_steps: int
    period_count: int

    @property
    def period(self) -> float:
        """Distance of the apertures along the grooves as made [mm]."""
        return self.period_steps * GRID

    @property
    def is_open(self) -> NDArray[np.bool_]:
        """Whether each groove has apertures, (n,) bool."""
        return self.across > 0

    @property
    def arrays(self) -> tuple[ApertureArray, ...]:
        """One array a groove that is not closed, left to right."""
        return tuple(
            ApertureArray(
                (int(self.across[i]), int(self.along[i])),
                Placement(
                    (int(self.left[i]), int(self.bottom[i])),
                    rows=int(self.count[i]),
                    row_step=(0, self.period_steps),
                ),
            )
            for i in np.flatnonzero(self.is_open)
        )

    @property
    def aperture_count(self) -> int:
        """Number of apertures in all."""
        return int(self.count[self.is_open].sum())

    @property
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""
        area = self.across * self.along * self.count * GRID**2
        return area / (self.pitch * self.length)

    @property
    def wanted_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio that each groove's curvature needs, (n,) float64."""
        return self.groove_ratio

    def ratio_map(self, cell: float) -> NDArray[np.float64]:
        """Return the mean ratio as drawn over squares of side `cell` [mm], (along, across)."""
        edge = square_edges(self.length, cell) / GRID
        reach = edge[:, None] - self.bottom
        whole = np.clip(np.floor(reach / self.period_steps), 0, self.count - 1)
        rest = np.clip(reach - whole * self.period_steps, 0, self.along)
        share = np.diff((whole * self.along + rest) * (self.across * GRID / self.pitch), axis=0)
        return mean_over_grooves(share / np.diff(edge)[:, None], self.pitch, cell)

    def wanted_map(self, cell: float) -> NDArray[np.float64]:
        """Return the mean of the wanted ratio over the same squares."""
        rows = len(square_edges(self.length, cell)) - 1
        return mean_over_grooves(np.tile(self.groove_ratio, (rows, 1)), self.pitch, cell)


def square_edges(side: float, cell: float) -> NDArray[np.float64]:
    """Return 0, cell, 2 cell, … and `side` [mm]: the last square is cut at the panel's edge."""
    return np.append(np.arange(0.0, side - 1e-6 * cell, cell), side)


def mean_over_grooves(value: NDArray[np.float64], pitch: float, cell: float) -> NDArray[np.float64]:
    """Return (rows, n) values of grooves as means over squares of side `cell` [mm], by area."""
    edge = square_edges(value.shape[1] * pitch, cell)
    total = np.concatenate([np.zeros((len(value), 1)), np.cumsum(value, axis=1)], axis=1)
    place = np.clip(edge / pitch, 0, value.shape[1])
    low = np.minimum(place.astype(int), value.shape[1] - 1)
    at = total[:, low] + (place - low) * (total[:, low + 1] - total[:, low])
    return np.diff(at, axis=1) / np.diff(place)


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
    shift = _shift(rules, film.groove_count, film.groove.pitch / GRID, period)
    # A lattice that is moved by less than a period has room for one aperture less.
    count = period_count - (shift > 0)
    if period_count == 1 and shift.any():
        raise InputError(f"{where}: {rules.describe(film.length)}: allowed two periods or more")
    across, along = _aperture_size(wanted, edge, film, rules, length / count)
    check_rules(where, wanted, along, film, process, rules, length / period_count * GRID)
    return GrooveMask(
        name=name,
        content_hash=hashlib.sha256(film.curvature.astype("<f8").tobytes()).hexdigest()[:12],
        rules=rules,
        pitch=film.groove.pitch,
        length=film.length,
        groove_count=film.groove_count,
        groove_ratio=wanted,
        left=edge[:-1] + (np.diff(edge) - across) // 2,
        bottom=(length - period * period_count) // 2 + (period - along) // 2 + shift,
        across=across,
        along=along,
        count=np.where(across > 0, count, 0),
        period_steps=period,
        period_count=period_count,
    )


def _shift(rules: MaskRules, groove_count: int, pitch: float, period: int) -> NDArray[np.int64]:
    """Return how far each groove's apertures are moved along, (n,) int64; grid steps.

    Every other groove of a staggered lattice moves by half a period, a groove of an angled one by
    pitch · tan(angle) more than its neighbour, less whole periods.
    """
    groove = np.arange(groove_count)
    if rules.pattern == "staggered":
        return groove % 2 * (period // 2)
    if rules.pattern == "angled":
        return np.rint(groove * (pitch * np.tan(rules.angle))).astype(np.int64) % period
    return np.zeros(groove_count, dtype=np.int64)


def _aperture_size(
    ratio: NDArray[np.float64],
    edge: NDArray[np.int64],
    film: PrismFilm,
    rules: MaskRules,
    period: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return width across and length along of each groove's apertures [grid steps], 0 for none.

    `edge` are the tips; `period` (n,) is length over count in grid steps, not rounded to the grid.
    """
    pitch = film.groove.pitch / GRID
    if rules.pattern != "slot":
        along = np.rint(np.sqrt(ratio * pitch * period)).astype(np.int64)
        return along, along
    along = np.rint(ratio * period).astype(np.int64)
    return np.where(along > 0, np.diff(edge), 0), along
