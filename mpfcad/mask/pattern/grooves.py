"""Masks with one array of equal rectangles a groove: slots, and dots on a lattice.

The period is stretched by less than half of itself over the whole length so that a whole number of
periods fills the panel: period = length / round(length / nominal period). With ratio a and groove
pitch p an aperture is

* `slot`: p across, a · period along; equal neighbours make one slot across all the grooves;
* `dot`, `staggered`, `angled`: a square of side sqrt(a · p · period), every groove's moved along by
  nothing, by half a period every other one, or by p · tan(angle) more than its neighbour's;

so that apertures over groove area is a, but for rounding to the grid.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import PanelFilm, Process
from mpfcad.mask.aperture import Mask, ends_of
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.rule import GRID, MaskRules, check_rules
from mpfcad.units import um


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
    def arrays(self) -> Iterator[ApertureArray]:
        """One array a groove that is not closed, left to right."""
        step = (0, self.period_steps)
        columns = (self.across, self.along, self.left, self.bottom, self.count)
        table = np.stack(columns, axis=1)[self.is_open].tolist()
        for across, along, left, bottom, count in table:
            place = Placement((left, bottom), rows=count, row_step=step)
            yield ApertureArray((across, along), place)

    @property
    def aperture_count(self) -> int:
        """Number of apertures in all."""
        return int(self.count[self.is_open].sum())

    @property
    def aperture_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio of each groove as drawn, (n,) float64, 0…1."""
        area = self.across.astype(float) * self.along * self.count * GRID**2
        return np.asarray(area / (self.pitch * self.length), np.float64)

    @property
    def smallest_features(self) -> tuple[float | None, float | None]:
        """Smallest aperture and web as drawn [mm]; None where there is none."""
        is_open = self.is_open
        if not is_open.any():
            return None, None
        along = self.along[is_open]
        webs = [self.period_steps - int(along.max())]
        if self.rules.pattern != "slot":
            webs.append(round(self.pitch / GRID) - int(self.across[is_open].max()))
        return float(along.min()) * GRID, float(min(webs)) * GRID

    @property
    def is_lattice(self) -> bool:
        """Whether the apertures of a groove are one array: they are."""
        return True

    @property
    def closed_arrays(self) -> Iterator[ApertureArray]:
        """Rectangles that cover what is closed in each groove, without overlap."""
        return _closed_arrays(self)

    def wanted_places(self, cell: float) -> tuple[NDArray[np.float64], float]:
        """Return the wanted ratio of each groove, and the pitch [mm]."""
        return self.wanted_ratio, self.pitch

    @cached_property
    def ratio_ends(self) -> tuple[float, float]:
        """Smallest wanted ratio above 0, and the largest, of the grooves."""
        return ends_of(self.groove_ratio)

    @property
    def wanted_ratio(self) -> NDArray[np.float64]:
        """Aperture ratio that each groove's curvature needs, (n,) float64."""
        return self.groove_ratio

    def open_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the ratio as drawn, integrated along from 0 to each position [mm]."""
        part = slice(first, first + count)
        along, number = self.along[part, None], self.count[part, None]
        reach = position / GRID - self.bottom[part, None]
        whole = np.clip(np.floor(reach / self.period_steps), 0, np.maximum(number - 1, 0))
        rest = np.clip(reach - whole * self.period_steps, 0, along)
        return (whole * along + rest) * (self.across[part, None] * GRID / self.pitch) * GRID

    def wanted_length(
        self, first: int, count: int, position: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the wanted ratio, integrated like `open_length`."""
        return self.groove_ratio[first : first + count, None] * position


def _closed_arrays(mask: GrooveMask) -> Iterator[ApertureArray]:
    """Yield rectangles that cover what is closed in each groove, without overlap."""
    edge = np.rint(np.arange(mask.groove_count + 1) * mask.pitch / GRID).astype(np.int64)
    length, step = round(mask.length / GRID), mask.period_steps
    for i in range(mask.groove_count):
        left, right = int(edge[i]), int(edge[i + 1])
        if not mask.is_open[i]:
            yield ApertureArray((right - left, length), Placement((left, 0)))
            continue
        x, y = int(mask.left[i]), int(mask.bottom[i])
        width, height, count = int(mask.across[i]), int(mask.along[i]), int(mask.count[i])
        top = y + (count - 1) * step + height
        for low, high, rows in ((0, y, 1), (y + height, y + step, count - 1), (top, length, 1)):
            if high > low and rows:
                place = Placement((left, low), rows=rows, row_step=(0, step))
                yield ApertureArray((right - left, high - low), place)
        for low, high in ((left, x), (x + width, right)):
            if high > low:
                place = Placement((low, y), rows=count, row_step=(0, step))
                yield ApertureArray((high - low, height), place)


def build_groove_mask(
    film: PanelFilm,
    process: Process,
    rules: MaskRules,
    name: str,
    content_hash: str,
    where: str,
) -> GrooveMask:
    """Return the mask of a film with one curvature a groove, as one lattice a groove.

    Raises
    ------
    InputError
        one line naming the grooves whose apertures or webs would be too small.
    """
    edge = np.rint(film.tip_position / GRID).astype(np.int64)
    length = round(film.length / GRID)
    period_count = max(1, round(film.length / rules.period))
    period = length // period_count
    wanted = process.aperture_ratio_of_curvature(film.extremes()[0])
    shift = _shift(rules, film.groove_count, film.groove.pitch / GRID, period)
    # A lattice that is moved by less than a period has room for one aperture less.
    count = period_count - (shift > 0)
    if period_count == 1 and shift.any():
        raise InputError(
            f"{where}: mask.period_um: {rules.period / um:g}: one period on a panel of "
            f"{film.length:g} mm: expected two or more with pattern {rules.pattern!r}"
        )
    across, along = _aperture_size(wanted, edge, film, rules, length / count)
    check_rules(where, wanted, along, film, process, rules, length / period_count * GRID)
    return GrooveMask(
        name=name,
        content_hash=content_hash,
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
    film: PanelFilm,
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
