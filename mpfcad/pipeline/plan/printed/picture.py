"""How large a TIFF of the artwork becomes: let through where memory and disk hold it."""

import math
import shutil
from dataclasses import dataclass
from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.mask.format.tiff import strip_bytes
from mpfcad.pipeline.plan.need import available_memory
from mpfcad.units import mm

INCH = 25.4 * mm
#: Memory besides a strip of tiles [GB]; share of the plain bits that deflate leaves, of one array a
#: groove and of dots one by one, at most. Measured: a panel's 273 gigapixels take 0.45 GB and
#: 223 MB, its 2.7 gigapixels 8 MB.
_BASE, _DEFLATED, _DEFLATED_DOTS = 0.4, 0.03, 0.25
#: Written and checked by one core [s a gigapixel]: 309 s for 273 of them.
_TIME = 1.5
#: A picture below so many pixels takes less than a minute: nothing is said of it.
_LONG = 3e10


@dataclass(frozen=True)
class Picture:
    """What a TIFF needs at most.

    Attributes
    ----------
    pixels
        of the artwork
    memory_gb, disk_gb
        while it is made
    minutes
        of one core, written and checked
    """

    pixels: float
    memory_gb: float
    disk_gb: float
    minutes: float

    @classmethod
    def of(cls, artwork: tuple[float, float], dpi: float, is_lattice: bool) -> "Picture":
        """Return what an artwork, across and along [mm], needs at `dpi` pixels per inch."""
        across, along = (side / INCH * dpi for side in artwork)
        deflated = _DEFLATED if is_lattice else _DEFLATED_DOTS
        pixels = across * along
        memory = _BASE + strip_bytes(math.ceil(across)) / 1e9
        return cls(pixels, memory, pixels / 8e9 * deflated, pixels / 1e9 * _TIME / 60)

    @property
    def words(self) -> str:
        """What of it is worth to be known beforehand; empty: it takes no minute."""
        if self.pixels < _LONG:
            return ""
        return (
            f" ({self.pixels / 1e9:.0f} gigapixels, about {self.minutes:.0f} minutes of one core)"
        )


def refuse_picture(
    artwork: tuple[float, float], dpi: float, is_lattice: bool, where: str, folder: Path
) -> None:
    """Refuse a TIFF of an artwork [mm] that memory, or the disk of `folder`, does not hold.

    Raises
    ------
    InputError
        naming the resolution and the largest that fits.
    """
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free = shutil.disk_usage(there).free / 1e9
    memory = available_memory()

    def fits(resolution: float) -> bool:
        picture = Picture.of(artwork, resolution, is_lattice)
        return picture.memory_gb <= memory and picture.disk_gb <= free

    if fits(dpi):
        return
    low, high = 0.0, dpi
    while high - low > 1:
        low, high = ((low + high) / 2, high) if fits((low + high) / 2) else (low, (low + high) / 2)
    needs = Picture.of(artwork, dpi, is_lattice)
    raise InputError(
        f"{where}: mask.tif_dpi: {dpi:g}: {needs.pixels / 1e9:.0f} gigapixels need up to "
        f"{needs.memory_gb:.2g} GB of memory and {needs.disk_gb:.2g} GB of disk; "
        f"{memory:.2g} and {free:.2g} GB are free: expected at most {math.floor(low)}, or no tif"
    )
