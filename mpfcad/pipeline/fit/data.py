"""What was measured, as figures of views with their errors."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.file.text import read_table
from mpfcad.fit import Datum, Figured
from mpfcad.fit.reading import (
    DIRECTIONS,
    FLUX,
    PITCH,
    Figure,
    contrast,
    cut_of,
    entry_of,
    fwhm_of,
    harmonics_of,
    luminance,
)
from mpfcad.job.fit import Fit, MeasurementTable, PredictTable
from mpfcad.measure.observed import (
    SAME_PITCH,
    Photo,
    check_pitch,
    observe_pitch,
    read_image,
    read_stripes,
)
from mpfcad.measure.observed.image import is_image

#: Cosines of a measured curve that are compared.
_COSINES = 4
_FEWEST_ANGLES = 3
#: A cut within a quarter turn in radians is no cut in degrees [°].
_RADIANS = np.pi / 2
#: Kind of view and figure of each scalar.
_SCALAR: dict[str, tuple[str, Figure]] = {
    "contrast": (PITCH, contrast),
    "luminance": (PITCH, luminance),
    "fwhm_across_deg": (DIRECTIONS, fwhm_of(0)),
    "fwhm_along_deg": (DIRECTIONS, fwhm_of(1)),
    "efficiency": (FLUX, entry_of(0)),
    "flux": (FLUX, entry_of(1)),
}


def figured_of(table: PredictTable | MeasurementTable) -> Figured:
    """Return the figure that a scalar measurement, a prediction or a candidate is of."""
    kind, figure = _SCALAR[table.of]
    over = None if table.over is None else (table.over, kind)
    return Figured(table.title, (table.case, kind), figure, over)


def read_data(fit: Fit, file: Path, pitch: float) -> tuple[list[Datum], list[str]]:
    """Return what a fit's file says was measured, and how its files were understood.

    `pitch`: of the backlight's lamps [mm], where a case has no other.

    Raises
    ------
    InputError
        naming the measurement, its file and what is wrong.
    """
    data: list[Datum] = []
    notes: list[str] = []
    for number, table in enumerate(fit.measurement, 1):
        where = f"{file}: measurement {number}"
        if table.of == "curve":
            data += _curve(where, table, file, _lamp_pitch(fit, table, pitch), notes)
        elif table.of in ("cut_across", "cut_along"):
            data.append(_cut(where, table, file))
        else:
            data.append(_scalar(table))
    return data, notes


def _scalar(table: MeasurementTable) -> Datum:
    stated = {0: table.value, 1: table.at_least, -1: table.at_most}
    side, value = next((s, v) for s, v in stated.items() if v is not None)
    assert table.sigma is not None  # the model holds it
    return Datum(figured_of(table), np.array([value]), np.array([[table.sigma**2]]), side)


def _lamp_pitch(fit: Fit, table: MeasurementTable, pitch: float) -> float:
    """Return the lamp pitch [mm] of a measurement's case: its own, or the backlight's."""
    own = fit.case[table.case].override.get("lamp_pitch_mm", pitch)
    own = own.get("value", pitch) if isinstance(own, dict) else own
    return float(own)


def _curve(
    where: str, table: MeasurementTable, file: Path, pitch: float, notes: list[str]
) -> list[Datum]:
    assert table.file is not None
    path = file.parent / table.file
    if not path.is_file():
        raise InputError(f"{where}: file: {path}: no such file: expected a curve or an image")
    image = None
    if is_image(path):
        if table.pixel_mm is None:
            raise InputError(f"{where}: {table.file}: an image: expected pixel_mm")
        frames = [None if name is None else file.parent / name for name in (table.dark, table.flat)]
        photo = Photo(
            table.pixel_mm, table.cd_m2_per_count, frames[0], frames[1],
            table.crop, float(np.radians(table.rotation_deg)),
        )  # fmt: skip
        image = read_image(path, photo)
    curve, said = read_stripes(path, image, table.unit)
    notes += filter(None, [said])
    own = table.pitch_mm or pitch
    if abs(own / pitch - 1) > SAME_PITCH:
        raise InputError(
            f"{where}: pitch_mm {own:g}: expected the backlight's lamp pitch, {pitch:g} mm, "
            f"within {SAME_PITCH:.0%}"
        )
    whose = "pitch_mm" if table.pitch_mm else "the backlight's lamp pitch in mm,"
    said = check_pitch(
        f"{where}: {table.file}", curve.position, curve.luminance, own, whose,
        "a curve of that backlight",
    )  # fmt: skip
    notes += [f"{table.file}: {said}"] if said else []
    seen = observe_pitch(curve, own, table.lamp_at_mm)
    notes.append(curve.reading)
    mean = float(seen.fit.coefficient[0])
    cosine, covariance = seen.cosines(_COSINES)
    covariance = covariance + np.eye(len(cosine)) * (table.sigma or 0.0) ** 2
    view = (table.case, PITCH)
    label = tuple(f"cos {2 * h}πu" for h in range(1, len(cosine) + 1))
    found = [
        Datum(Figured(table.title, view, harmonics_of(len(cosine))), cosine, covariance, 0, label)
    ]
    if table.scale_sigma is not None:
        error = mean**2 * table.scale_sigma**2 + seen.fit.covariance[0, 0]
        name = f"{table.title}, mean"
        found.append(Datum(Figured(name, view, luminance), np.array([mean]), np.array([[error]])))
    return found


def _cut(where: str, table: MeasurementTable, file: Path) -> Datum:
    assert table.file is not None
    path = file.parent / table.file
    if not path.is_file():
        raise InputError(f"{where}: file: {path}: no such file: expected angles and luminances")
    read = read_table(path)
    values = read.values
    if values.shape[1] not in (2, 3):
        raise InputError(
            f"{where}: {table.file}: {values.shape[1]} columns: expected angle_deg, luminance and, "
            "if it is known, its standard error"
        )
    angle, light = values[:, 0], values[:, 1]
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=1) | (values[:, 2:] <= 0).any(axis=1))
    if wrong.size:
        shown = ", ".join(f"{value:g}" for value in values[wrong[0]])
        raise InputError(
            f"{where}: {table.file}: row {read.lines[int(wrong[0])]}: {shown}: expected numbers, "
            "and a standard error above 0"
        )
    bad = np.flatnonzero((np.abs(angle) > 80) | (light <= 0))
    if bad.size or len(angle) < _FEWEST_ANGLES:
        row = read.lines[int(bad[0])] if bad.size else read.lines[-1]
        raise InputError(
            f"{where}: {table.file}: row {row}: expected {_FEWEST_ANGLES} or more angles within "
            "±80° and luminances above 0"
        )
    widest = float(np.abs(angle).max())
    if widest <= _RADIANS:
        raise InputError(
            f"{where}: {table.file}: angles within ±{widest:.3g}: expected degrees, not radians"
        )
    mean = float(light.mean())
    error = values[:, 2] / mean if values.shape[1] == 3 else np.zeros(len(light))
    error = np.sqrt(error**2 + ((table.sigma or 0.0) * light / mean) ** 2)
    if np.any(error <= 0):
        raise InputError(
            f"{where}: {table.file}: no errors: expected a third column, or sigma: the relative "
            "standard error of each luminance"
        )
    side = 0 if table.of == "cut_across" else 1
    figured = Figured(table.title, (table.case, DIRECTIONS), cut_of(side, np.radians(angle)))
    label = tuple(f"{a:g}°" for a in angle)
    return Datum(figured, light / mean, _diagonal(error), 0, label)


def _diagonal(error: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.diag(error**2), np.float64)
