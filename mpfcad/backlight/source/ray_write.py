"""Ray files written, ray by ray as they come: TM-25, Zemax .DAT and LightTools .ray.

A ray is (x, y, z [mm], kx, ky, kz, flux), float32. Headers hold no date, so that the same rays are
the same bytes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from io import SEEK_CUR
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.ray_layout import (
    DAT,
    DAT_KINDS,
    FORMS,
    RAY,
    RAY_END,
    RAY_MAGIC,
    TM25,
    TM25_MAGIC,
    TM25_TEXT,
)
from mpfcad.errors import InputError

#: Columns of a ray; that of its flux.
COLUMNS, FLUX = 7, 6
_CHUNK = 1 << 16
_UNKNOWN = "unknown"


@dataclass(frozen=True)
class About:
    """What a ray file says of itself.

    Attributes
    ----------
    source
        the light source in words
    creator
        the program and its version
    note
        anything else
    """

    source: str
    creator: str
    note: str


#: Takes the next rays, (n, 7) float32.
Keep = Callable[[NDArray[np.float32]], None]


def check_ray_suffix(where: str, path: Path) -> str:
    """Return the ending of a ray file's name in small letters.

    Raises
    ------
    InputError
        when it is none of `FORMS`.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMS:
        known = ", ".join(f"{ending} ({form})" for ending, form in FORMS.items())
        raise InputError(f"{where}: {path}: unknown ray file: expected an ending of {known}")
    return suffix


def write_ray_file(
    path: Path, suffix: str, about: About, collect: Callable[[Keep], float]
) -> float:
    """Write the rays that `collect` hands on, in the form of `suffix`; return their flux [lm].

    The fluxes that come are relative; `collect` returns how many lm their unit is, once it has
    handed on the last. Memory does not grow with the rays.
    """
    head, end = _HEADS[suffix]
    count = 0
    with path.open("wb+") as file:
        file.write(bytes(head(about, 0, 0.0).nbytes))
        start = file.tell()

        def keep(ray: NDArray[np.float32]) -> None:
            nonlocal count
            count += len(ray)
            file.write(np.ascontiguousarray(ray, "<f4").tobytes())

        unit = collect(keep)
        flux = _scale(file, start, unit)
        file.write(end)
        file.seek(0)
        file.write(head(about, count, flux).tobytes())
    return flux


def _scale(file: BinaryIO, start: int, unit: float) -> float:
    """Multiply the fluxes of the rays behind `start` by `unit`; return their sum."""
    file.seek(start)
    total = 0.0
    while data := file.read(4 * COLUMNS * _CHUNK):
        ray = np.frombuffer(data, "<f4").reshape(-1, COLUMNS).copy()
        ray[:, FLUX] *= np.float64(unit)
        total += float(ray[:, FLUX].sum(dtype=np.float64))
        file.seek(-len(data), SEEK_CUR)
        file.write(ray.tobytes())
        file.seek(0, SEEK_CUR)
    return total


def _tm25(about: About, count: int, flux: float) -> NDArray:
    head = np.zeros(1, TM25)
    row = head[0]
    row["magic"], row["version"], row["rays"] = TM25_MAGIC, 2013, count
    # Of no single wavelength, and of a flux in lm alone: the others are not numbers.
    row["lm"], row["watt"], row["wave"] = flux, np.nan, np.nan
    row["has"] = (1, 1, 0, 0, 1, 0, 0, 0)
    said = (
        about.source, _UNKNOWN, about.creator, about.creator, about.creator, "none", _UNKNOWN,
        about.note, "none",
    )  # fmt: skip
    for i, text in enumerate(said):
        letters = np.frombuffer(text[: TM25_TEXT - 1].encode("utf-32-le"), "<u4")
        row["texts"][i, : len(letters)] = letters
    return head


def _dat(about: About, count: int, flux: float) -> NDArray:
    head = np.zeros(1, DAT)
    row = head[0]
    text = f"{about.creator}: {about.source}".encode("ascii", "replace")[:99]
    row["kind"], row["rays"], row["text"] = DAT_KINDS[0], count, text
    row["flux"] = (flux, flux, 0.0)
    row["unit"], row["pose"][6:], row["type"] = 4, 1.0, 1
    return head


def _ray(about: About, count: int, flux: float) -> NDArray:
    head = np.zeros(1, RAY)
    row = head[0]
    row["magic"], row["version"], row["data"], row["unit"] = RAY_MAGIC, (2, 0), 1, 1
    row["flux"] = flux
    return head


_HEADS: dict[str, tuple[Callable[[About, int, float], NDArray], bytes]] = {
    ".tm25ray": (_tm25, b""),
    ".tm25": (_tm25, b""),
    ".dat": (_dat, b""),
    ".ray": (_ray, RAY_END),
}
#: How a file of each ending begins.
BEGINNINGS = {
    ".tm25ray": (TM25_MAGIC,),
    ".tm25": (TM25_MAGIC,),
    ".dat": tuple(kind.to_bytes(4, "little") for kind in DAT_KINDS),
    ".ray": (RAY_MAGIC,),
}
