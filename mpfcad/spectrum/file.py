"""A spectrum as a stack file states it: measured, an LED's by peak and width, or a black body's."""

import csv
import io
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.boundary import TEXT_LIMIT, check_file, guarded
from mpfcad.errors import InputError
from mpfcad.spectrum.cie import FIRST_NM, LAST_NM
from mpfcad.spectrum.shape import Spectrum, gaussian, interpolated, planckian

_HEAD = ["wavelength_nm", "power"]
_WAYS = "file, table_nm, peak_nm with fwhm_nm, or planckian_k"
_KEYS = {
    frozenset({"file"}), frozenset({"table_nm"}), frozenset({"peak_nm", "fwhm_nm"}),
    frozenset({"planckian_k"}),
}  # fmt: skip
_RANGES = {
    "peak_nm": (FIRST_NM, LAST_NM), "fwhm_nm": (1.0, 400.0), "planckian_k": (500.0, 100_000.0),
}  # fmt: skip


def read_spectrum(where: str, folder: Path | None, entry: object) -> Spectrum:
    """Return the spectrum of a table with a file, rows, peak and width, or a temperature.

    A file is CSV of `wavelength_nm,power`, beside `folder` (None: no file may be named).

    Raises
    ------
    InputError
        naming file and row, or key, the value, and what was expected.
    """
    if not isinstance(entry, Mapping) or frozenset(entry) - {"tag", "source"} not in _KEYS:
        raise InputError(f"{where}: {entry!r}: expected a table with {_WAYS}")
    tag, source = str(entry.get("tag", "given")), str(entry.get("source", "given by the user"))
    if tag not in ("given", "sourced", "assumed"):
        raise InputError(f"{where}.tag: {tag}: expected given, sourced or assumed")
    if "file" in entry:
        if folder is None:
            raise InputError(f"{where}.file: {entry['file']}: expected in a stack file, beside it")
        rows = read_rows(folder / str(entry["file"]))
        return tabled(str(folder / str(entry["file"])), rows, str(entry["file"]), tag, source)
    if "table_nm" in entry:
        with guarded(f"{where}.table_nm", "rows of [wavelength, power]"):
            rows = [(i, *map(float, row)) for i, row in enumerate(entry["table_nm"], 1)]
        return tabled(f"{where}.table_nm", rows, "a table", tag, source)
    number = {key: _number(where, key, entry[key]) for key in _RANGES if key in entry}
    if "planckian_k" in number:
        title = f"black body of {number['planckian_k']:g} K"
        power = planckian(number["planckian_k"])
    else:
        peak, fwhm = number["peak_nm"], number["fwhm_nm"]
        title, power = f"Gaussian at {peak:g} nm, {fwhm:g} nm wide", gaussian(peak, fwhm)
    return Spectrum(tuple(map(float, power)), FIRST_NM, LAST_NM, title, tag, source)


def read_rows(path: Path) -> list[tuple[Any, ...]]:
    """Return (line, wavelength [nm], power) of each row of a CSV file.

    Raises
    ------
    InputError
        naming file and row.
    """
    check_file(path, TEXT_LIMIT, "a spectrum as CSV")
    with guarded(path, "CSV of wavelength_nm,power"):
        reader = csv.reader(io.StringIO(path.read_text("utf-8-sig")))
        lines = [(reader.line_num, fields) for fields in reader if any(map(str.strip, fields))]
    head = [cell.strip() for cell in lines[0][1]] if lines else []
    if head != _HEAD:
        raise InputError(f"{path}: row 1: {','.join(head)}: expected {','.join(_HEAD)}")
    rows: list[tuple[Any, ...]] = []
    for line, fields in lines[1:]:
        try:
            wavelength, power = map(float, fields)
        except ValueError:
            text = ",".join(fields)
            raise InputError(f"{path}: row {line}: {text}: expected two numbers") from None
        rows.append((line, wavelength, power))
    return rows


def tabled(where: str, rows: list[Any], title: str, tag: str, source: str) -> Spectrum:
    """Return the spectrum of rows (line, wavelength [nm], power).

    Raises
    ------
    InputError
        naming the row: no finite number, wavelengths that do not rise, power below 0.
    """
    if len(rows) < 2 or any(len(row) != 3 for row in rows):
        raise InputError(f"{where}: {len(rows)} rows: expected two numbers in two rows or more")
    before = 0.0
    for line, wavelength, power in rows:
        if not (math.isfinite(wavelength) and wavelength > before):
            raise InputError(f"{where}: row {line}: {wavelength:g} nm: expected above {before:g}")
        if not (math.isfinite(power) and power >= 0):
            raise InputError(f"{where}: row {line}: power {power:g}: expected 0 or more")
        before = wavelength
    table = np.array([row[1:] for row in rows])
    values = interpolated(table[:, 0], table[:, 1])
    if not values.any():
        raise InputError(f"{where}: no power in {FIRST_NM} … {LAST_NM} nm: expected some")
    return Spectrum(
        tuple(map(float, values)), float(table[0, 0]), float(table[-1, 0]), title, tag, source
    )


def _number(where: str, key: str, value: object) -> float:
    low, high = _RANGES[key]
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise InputError(f"{where}.{key}: {value!r}: expected a number in {low:g} … {high:g}")
    return float(value)
