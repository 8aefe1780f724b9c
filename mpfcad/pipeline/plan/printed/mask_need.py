"""What a mask will need: apertures, bytes, memory and time; said, or refused before it is built."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from mpfcad.errors import InputError
from mpfcad.film import PanelFilm, Process
from mpfcad.mask import Mask, MaskRules
from mpfcad.mask.format.write import FORMATS
from mpfcad.mask.rule import dot_side
from mpfcad.pipeline.plan.need import available_memory
from mpfcad.units import um

#: Longest that a mask may take, built, written and checked [h of one core].
LONGEST = 4.0
#: Memory without apertures [GB]; bytes and seconds of an aperture that stands in a list, in OASIS
#: and in formats that klayout or text lists one by one; of an aperture of a lattice, and of a cell
#: that may be closed [s]. Measured on 3.7 million dots and 35.9 million slots in OASIS (35 and 48
#: bytes, 1.2 and 1.3 µs) and on 0.1 … 1.1 million in GDSII (0.1 … 0.6 kB, 9 … 48 µs).
_BASE = 0.5
_LISTED = {"oas": (64.0, 2e-6)}
_OTHERS = (800.0, 60e-6)
_LATTICE_TIME, _CELL_TIME = 1e-8, 1e-7
#: Bytes of a place that OASIS lists, at most: two steps on a grid of 1 nm.
_OASIS_PLACE = 10.0
#: Periods that are tried, as multiples of the one asked for.
_LONGER = np.geomspace(1, 1000, 200)


@dataclass(frozen=True)
class MaskNeed:
    """What the files of a mask need at most.

    Attributes
    ----------
    apertures
        in all
    disk_mb
        of the files, without a TIFF
    memory_gb
        of the process
    minutes
        of one core: built, written and checked
    """

    apertures: float
    disk_mb: float
    memory_gb: float
    minutes: float

    @property
    def words(self) -> str:
        """What it needs, as a line of text."""
        return (
            f"the files take up to {self.disk_mb:.3g} MB, {self.memory_gb:.2g} GB of memory and "
            f"{self.minutes:.2g} minutes of one core"
        )


def need_of(
    apertures: float, cells: float, formats: Sequence[str], *, is_lattice: bool, grooves: int
) -> MaskNeed:
    """Return what so many apertures in so many cells need at most."""
    disk, memory, seconds = 0.0, 0.0, cells * (_LATTICE_TIME if is_lattice else _CELL_TIME)
    places = grooves if is_lattice else apertures
    for name in formats:
        if name == "tif":  # `Picture` knows
            continue
        size, time = _LISTED.get(name, _OTHERS)
        place = _OASIS_PLACE if name == "oas" else FORMATS[name].place_size
        disk += places * place
        memory = max(memory, places * size)
        seconds += places * time
    return MaskNeed(apertures, disk / 1e6, _BASE + memory / 1e9, seconds / 60)


def mask_need(mask: Mask, formats: Sequence[str]) -> MaskNeed:
    """Return what the files of a mask need at most."""
    count, cells = mask.aperture_count, mask.groove_count * mask.length / mask.period
    is_lattice = mask.is_lattice
    return need_of(count, cells, formats, is_lattice=is_lattice, grooves=mask.groove_count)


def film_need(
    film: PanelFilm, process: Process, rules: MaskRules, formats: Sequence[str], where: str
) -> MaskNeed:
    """Return what the mask of a film needs at most, before it is built."""
    cells = film.groove_count * max(1.0, film.length / rules.period)
    count = cells
    if rules.is_stochastic:
        pitch = film.groove.pitch
        side = dot_side(rules, pitch, rules.period, where)
        side /= 2**0.5 if rules.pattern == "blue-noise" else 1
        ratio = np.maximum.reduce([process.aperture_ratio_of_curvature(c) for c in film.extremes()])
        count = min(cells, float(ratio.sum()) * pitch * film.length / side**2)
    is_lattice = not (film.varies_along or rules.is_stochastic)
    return need_of(count, cells, formats, is_lattice=is_lattice, grooves=film.groove_count)


def refuse_mask_need(
    film: PanelFilm, process: Process, rules: MaskRules, formats: Sequence[str], where: str
) -> None:
    """Refuse a mask that needs more memory than there is, or more than `LONGEST` hours.

    Raises
    ------
    InputError
        naming the period, and the shortest that fits.
    """
    there = available_memory()

    def fits(need: MaskNeed) -> bool:
        return need.memory_gb <= there and need.minutes <= LONGEST * 60

    def with_period(period: float) -> MaskNeed:
        return film_need(film, process, replace(rules, period=period), formats, where)

    need = with_period(rules.period)
    if fits(need):
        return
    able = next((p for p in rules.period * _LONGER if fits(with_period(p))), None)
    longer = "a smaller panel" if able is None else f"at least {able / um:.4g}, or a smaller panel"
    raise InputError(
        f"{where}: mask.period_um: {rules.period / um:g}: up to {need.apertures / 1e6:.4g} million "
        f"apertures need {need.memory_gb:.3g} GB of memory and {need.minutes / 60:.2g} h: expected "
        f"at most {there:.3g} GB and {LONGEST:g} h: {longer}"
    )


def refuse_files(need: MaskNeed, where: str, folder: Path) -> None:
    """Refuse files of a mask that memory, or the disk of `folder`, does not hold.

    Raises
    ------
    InputError
        naming what they take and what there is.
    """
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free, memory = shutil.disk_usage(there).free / 1e6, available_memory()
    if need.disk_mb > free or need.memory_gb > memory:
        raise InputError(
            f"{where}: mask.formats: {need.words}: expected at most {free:.3g} MB and "
            f"{memory:.2g} GB, what is free: fewer formats, or oas alone"
        )
