"""What an LED's intensity over direction comes from: a formula or a measured file."""

import csv
import io
import math
import re
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.eulumdat import read_eulumdat
from mpfcad.backlight.source.lattice import folder_text
from mpfcad.backlight.source.ray_file import read_ray_file
from mpfcad.backlight.source.ray_layout import SUFFIXES
from mpfcad.boundary import guarded, named_file
from mpfcad.errors import InputError

#: A lens that throws light aside: polar angle [deg], intensity over the peak at 65°.
_BATWING = (
    (0.0, 20.0, 40.0, 55.0, 65.0, 72.0, 78.0, 85.0, 90.0),
    (0.30, 0.36, 0.60, 0.85, 1.0, 0.95, 0.6, 0.15, 0.0),
)
_PEAK = 65.0
FORMULAS = ("cosine", "batwing")
FILES = (".csv", ".ies", ".ldt")
#: Keywords that a reader of IES files asks for; nothing depends on them.
_KEYWORDS = ("[TEST] -", "[MANUFAC] -", "[LUMCAT] -")
#: Azimuths of a measured table: every 5°.
_AZIMUTHS = 72
#: Least step between a file's polar angles [deg].
_LEAST_STEP = 0.01
#: Largest share of the flux that may go below the board, and be left out.
_MOST_BELOW = 0.02
#: Most by which our integral may differ from the flux that a file states.
_MOST_FLUX = 0.1


def polar_angles() -> NDArray[np.float64]:
    """Return the polar angles [rad] of intensity tables, those of the tracer."""
    from mpfcad.optics.cavity.emission import polar_angles as angles

    return angles()


def cosine(half_angle: float) -> NDArray[np.float64]:
    """Return I = cos^m θ, m = -ln 2 / ln cos θ½, (1, n) float64; `half_angle` θ½ [deg]."""
    exponent = -math.log(2.0) / math.log(math.cos(math.radians(half_angle)))
    return np.asarray(np.clip(np.cos(polar_angles()), 0.0, 1.0)[None] ** exponent)


def batwing(peak: float) -> NDArray[np.float64]:
    """Return the batwing stretched so that it peaks at `peak` [deg], (1, n) float64."""
    angle, intensity = np.array(_BATWING)
    inner = angle <= _PEAK
    angle = np.where(inner, angle * peak / _PEAK, 90 - (90 - angle) * (90 - peak) / (90 - _PEAK))
    return np.interp(polar_angles(), np.radians(angle), intensity)[None]


def read_emission(where: str, folder: Path, name: str) -> NDArray[np.float64]:
    """Return the intensity (m, n) float64 of a measured file, any unit, over azimuth and angle.

    Raises
    ------
    InputError
        when the file is none, holds what is not finite, or stops short of the half-space.
    """
    suffix = Path(name).suffix.lower()
    if suffix in (".csv", *SUFFIXES, *FILES):
        named_file(where, folder, name, f"one of {', '.join(FORMULAS)} or such a file")
    where = f"{where}: {name}"
    if suffix == ".csv":
        polar, azimuth, value = _read_csv(where, folder_text(where, folder, name))
    elif suffix in SUFFIXES:
        polar, azimuth, value = read_ray_file(where, folder / name)
    elif suffix == ".ies":
        polar, azimuth, value = _read_ies(where, folder / name)
    elif suffix == ".ldt":
        polar, azimuth, value = read_eulumdat(where, _text(folder / name))
    else:
        raise InputError(
            f"{where}: expected one of {', '.join(FORMULAS)} or a file {(*FILES, *SUFFIXES)}"
        )
    return _resampled(where, polar, azimuth, value)


def _read_csv(where: str, text: str) -> tuple[NDArray, NDArray, NDArray]:
    """Return (polar, azimuth [deg], (azimuth, polar) intensity) of `angle_deg,intensity`."""
    with guarded(where, "angle_deg,intensity and rows of numbers"):
        lines = io.StringIO(text, newline=None)
        rows = [row for row in csv.reader(lines) if any(cell.strip() for cell in row)]
    head = [cell.strip() for cell in rows[0]] if rows else []
    if head != ["angle_deg", "intensity"]:
        raise InputError(f"{where}: row 1: {','.join(head)}: expected angle_deg,intensity")
    try:
        table = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except ValueError as error:
        raise InputError(f"{where}: {error}: expected numbers") from None
    if table.ndim != 2 or table.shape[1] != 2 or len(table) < 2:
        raise InputError(
            f"{where}: {len(rows) - 1} rows: expected two columns and two rows or more"
        )
    return table[:, 0], np.zeros(1), table[None, :, 1]


def _read_ies(where: str, path: Path) -> tuple[NDArray, NDArray, NDArray]:
    """Return (polar, azimuth [deg], (azimuth, polar) intensity) of an IES file."""
    try:
        from photompy import IESFile  # type: ignore[import-untyped]
    except ImportError:
        raise InputError(
            f"{where}: needs photompy: expected after pip install 'mpfcad[instruments]'"
        ) from None

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            table = IESFile.read(_under_one_header(_text(path))).photometry
            _refuse_angles(table.thetas)
            full = table.expanded()
        polar, azimuth = np.asarray(full.thetas, float), np.asarray(full.phis, float)
        value = np.asarray(full.values, float)
    except Exception as error:
        text = " ".join(str(error).split()) if isinstance(error, ValueError) else "not understood"
        raise InputError(f"{where}: {text}: expected a complete IES file") from None
    if value.shape != (len(azimuth), len(polar)):
        raise InputError(
            f"{where}: table {value.shape}: expected {len(azimuth)} planes of {len(polar)} angles"
        )
    return polar, azimuth, value


def _text(path: Path) -> str:
    raw = path.read_bytes()
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", "replace")


def _under_one_header(text: str) -> bytes:
    """Return an IES file's text from its tilt on, under a header of 1995.

    What stands above the tilt names the luminaire, in forms that differ by the year of LM-63 (1986
    none, 1991 `IESNA91`) and by maker; the numbers are the same in all.
    """
    found = re.search(r"^[ \t]*TILT[ \t]*=[ \t]*", text, re.IGNORECASE | re.MULTILINE)
    if not found:
        return text.encode()
    word, *below = text[found.end() :].split("\n", 1)
    lines = ["IESNA:LM-63-1995", *_KEYWORDS, f"TILT={word.strip().upper()}", *below]
    return "\n".join(lines).encode()


def _refuse_angles(polar: NDArray) -> None:
    """Refuse angles that photompy would go on from without end: the last step, repeated to 180°.

    Raises
    ------
    ValueError
        naming two angles.
    """
    step = np.diff(np.asarray(polar, float))
    bad = np.flatnonzero(~(step >= _LEAST_STEP))
    if bad.size:
        a, b = polar[bad[0]], polar[bad[0] + 1]
        raise ValueError(f"angles {a:g}, {b:g}°: expected steps of {_LEAST_STEP:g}° or more")


def _resampled(where: str, polar: NDArray, azimuth: NDArray, value: NDArray) -> NDArray[np.float64]:
    """Return the table at the tracer's angles, checked."""
    for name, array in (("angle", polar), ("azimuth", azimuth), ("intensity", value)):
        if not np.isfinite(array).all():
            raise InputError(f"{where}: {name}: {array[~np.isfinite(array)][0]}: expected numbers")
    if (value < 0).any() or not value.any():
        raise InputError(f"{where}: intensity: {value.min():g}: expected 0 or more, and some light")
    if (np.diff(polar) <= 0).any() or polar[0] != 0 or polar[-1] < 90:
        raise InputError(
            f"{where}: angles {polar[0]:g} … {polar[-1]:g}°: the table is cut off: expected angles "
            "that rise from 0 to 90° or more"
        )
    below = _share_below(polar, value)
    if below > _MOST_BELOW:
        raise InputError(
            f"{where}: {below:.1%} of the flux goes below the board: expected at most "
            f"{_MOST_BELOW:.0%}"
        )
    angle = np.degrees(polar_angles())
    planes = np.array([np.interp(angle, polar, row) for row in value])
    if len(planes) == 1:
        return planes
    target = np.arange(_AZIMUTHS) * 360 / _AZIMUTHS
    columns = [np.interp(target, azimuth, column, period=360) for column in planes.T]
    return np.stack(columns, axis=1)


def _share_below(polar: NDArray, value: NDArray) -> float:
    """Return the share of the flux at polar angles beyond 90°."""
    mean = value.mean(axis=0)
    fine = np.radians(np.linspace(0, 180, 3601))
    flux = np.interp(fine, np.radians(polar), mean, right=0.0) * np.sin(fine)
    return float(flux[fine > np.pi / 2].sum() / flux.sum())
