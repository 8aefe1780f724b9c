"""Ray files read, as rays and as intensity over direction: TM-25, Zemax .DAT, LightTools .ray."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.ray_layout import (
    DAT,
    DAT_KINDS,
    RAY,
    RAY_END,
    RAY_MAGIC,
    TM25,
    TM25_MAGIC,
)
from mpfcad.errors import InputError

#: Columns of each of TM-25's flags: place, direction, W, wavelength, lm, Stokes, XYZ, spectrum.
_TM25_COLUMNS = (3, 3, 1, 1, 1, 3, 2, 1)
#: What may lie before TM-25's rays besides what the header tells of, for vendors differ [B].
_SLACK = 4096
#: Bins over 0 … 90°, and round where there are so many rays.
_POLAR, _AZIMUTHS, _MANY = 36, 24, 100_000


def read_ray_file(where: str, path: Path) -> tuple[NDArray, NDArray, NDArray]:
    """Return (polar, azimuth [deg], (azimuth, polar) intensity) of a ray file.

    Only the directions are used: where on the LED a ray starts is left to the emitting top.

    Raises
    ------
    InputError
        when count and size disagree, or what it holds are no rays.
    """
    ray = read_rays(where, path)
    return _intensity(where, ray[:, 3:6], ray[:, 6])


def read_rays(where: str, path: Path) -> NDArray[np.float64]:
    """Return a file's rays, (n, 7): place in the file's unit, direction, flux (lm, else W).

    Raises
    ------
    InputError
        when count and size disagree, or it is no ray file of a known form.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{where}: {error.strerror}: expected a ray file there") from None
    if data[:4] == TM25_MAGIC:
        return _tm25(where, data)
    if data[:4] == RAY_MAGIC:
        return _light_tools(where, data)
    if len(data) >= DAT.itemsize and int(_head(data, DAT)["kind"]) in DAT_KINDS:
        head = _head(data, DAT)
        return _table(where, data, DAT.itemsize, 8 if head["form"] == 2 else 7, int(head["rays"]))
    raise InputError(f"{where}: expected a TM-25, Zemax .DAT or LightTools .ray file")


def _head(data: bytes, layout: np.dtype) -> np.void:
    return np.frombuffer(data.ljust(layout.itemsize, b"\0"), layout, 1)[0]


def _light_tools(where: str, data: bytes) -> NDArray[np.float64]:
    """Return the rays of LightTools' form, up to its end mark where it has one."""
    head = _head(data, RAY)
    if head["version"][0] > 2 or head["far"] or head["colour"] not in (0, 2):
        raise InputError(
            f"{where}: LightTools .ray of version {head['version'][0]}, far field {head['far']}, "
            f"colour {head['colour']}: expected version 2, places, and flux alone or wavelengths"
        )
    columns = 8 if head["colour"] else 7
    return _table(where, data.removesuffix(RAY_END), RAY.itemsize, columns, None)


def _table(
    where: str, data: bytes, start: int, columns: int, rays: int | None
) -> NDArray[np.float64]:
    """Return the rays (n, columns) that follow a header of `start` bytes; None: all that fit."""
    size = len(data) - start
    wanted = size // (4 * columns) if rays is None else rays
    if wanted <= 0 or size != wanted * 4 * columns:
        raise InputError(
            f"{where}: {len(data)} bytes with {wanted} rays of {columns} numbers: expected "
            f"{start + 4 * columns * max(wanted, 1)} bytes: count and size disagree"
        )
    return np.frombuffer(data, "<f4", wanted * columns, start).reshape(-1, columns).astype(float)


def _tm25(where: str, data: bytes) -> NDArray[np.float64]:
    """Return the rays of TM-25, flux in column 6: lm where there is, else W."""
    if len(data) < TM25.itemsize:
        raise InputError(f"{where}: {len(data)} bytes: expected at least {TM25.itemsize} of TM-25")
    head = _head(data, TM25)
    rays, extra, flags = int(head["rays"]), int(head["extra"]), head["has"] != 0
    if not flags[:2].all() or not (flags[2] or flags[4]):
        raise InputError(f"{where}: expected rays with place, direction and a flux")
    counts = np.array(_TM25_COLUMNS) * flags
    columns = int(counts.sum()) + extra
    spectra, text = int(head["spectra"]), int(head["text"])
    before = TM25.itemsize + text
    if min(spectra, extra, text) < 0 or before + 4 * spectra > len(data):
        raise InputError(
            f"{where}: {len(data)} bytes with {spectra} spectra, {extra} more columns and {text} "
            "bytes of text: expected numbers of 0 or more that fit the file"
        )
    for _ in range(spectra):
        number = int.from_bytes(data[before - text : before - text + 4], "little", signed=True)
        before += 4 + 8 * number
        if number < 0 or before > len(data):
            raise InputError(
                f"{where}: a spectrum of {number} values: expected one within the file"
            )
    start = len(data) - 4 * rays * columns
    if rays <= 0 or start < TM25.itemsize or start > before + 2048 * extra + _SLACK:
        raise InputError(
            f"{where}: {len(data)} bytes with {rays} rays of {columns} numbers: count and size "
            f"disagree: expected about {before + 4 * rays * columns} bytes"
        )
    ray = np.frombuffer(data, "<f4", rays * columns, start).reshape(-1, columns).astype(float)
    column = int(counts[: 4 if flags[4] else 2].sum())
    return np.concatenate([ray[:, :6], ray[:, column : column + 1]], axis=1)


def _intensity(
    where: str, direction: NDArray[np.float64], flux: NDArray[np.float64]
) -> tuple[NDArray, NDArray, NDArray]:
    if not np.isfinite(direction).all() or not np.isfinite(flux).all():
        raise InputError(f"{where}: a ray is not finite: expected numbers")
    if np.abs(np.linalg.norm(direction, axis=1) - 1).max() > 1e-3 or (flux < 0).any():
        raise InputError(f"{where}: expected directions of length 1 and fluxes of 0 or more")
    up = direction[:, 2] > 0
    below = float(flux[~up].sum() / max(flux.sum(), 1e-300))
    if below > 0.02 or not flux.any():
        raise InputError(f"{where}: {below:.1%} of the flux goes below z = 0: expected at most 2 %")
    polar = np.degrees(np.arccos(np.clip(direction[up, 2], 0, 1)))
    turn = np.degrees(np.arctan2(direction[up, 1], direction[up, 0])) % 360
    azimuths = _AZIMUTHS if len(flux) >= _MANY else 1
    edge = np.linspace(0, 90, _POLAR + 1)
    found, *_ = np.histogram2d(turn, polar, (azimuths, edge), ((0, 360), (0, 90)), weights=flux[up])
    solid = -np.diff(np.cos(np.radians(edge))) * 2 * np.pi / azimuths
    value = found / solid
    middle = (edge[1:] + edge[:-1]) / 2
    value = np.concatenate([np.full((azimuths, 1), value[:, 0].mean()), value, value[:, -1:]], 1)
    return np.r_[0.0, middle, 90.0], (np.arange(azimuths) + 0.5) * 360 / azimuths, value
