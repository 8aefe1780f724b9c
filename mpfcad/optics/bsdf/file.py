"""Reads BSDF tables from any of their formats, checks them, and writes them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.csv import bsdf_csv, read_bsdf_csv
from mpfcad.optics.bsdf.klems import klems_xml, read_klems
from mpfcad.optics.bsdf.table import ABOVE, BELOW, SIDES, TRANSMIT, WAYS, BsdfTable
from mpfcad.optics.bsdf.zemax import read_zemax
from mpfcad.optics.bsdf.zemax_text import zemax_texts

FORMATS = ("klems", "csv", "zemax")
_SUFFIXES = (".xml", ".csv", ".bsdf")


def read_bsdf(path: Path | Sequence[Path], *, reciprocal: bool = False) -> BsdfTable:
    """Return the checked table of one file, or of several `.bsdf` files of one element.

    What the files do not hold is filled in, each with a note: from a side not measured the same as
    from the other (transmission of an anisotropic table by reciprocity), a way that is nowhere 0.
    `reciprocal` claims that the element is: it is checked, and the table made exactly so.

    Raises
    ------
    InputError
        naming file, incidence, value and allowed range.
    """
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(p) for p in path]
    suffix = {p.suffix.lower() for p in paths}
    for p in paths:
        if p.suffix.lower() not in _SUFFIXES:
            raise InputError(f"{p}: {p.suffix or 'no suffix'}: must be of {', '.join(_SUFFIXES)}")
        if not p.is_file():
            raise InputError(f"{p}: no such file")
    if suffix == {".bsdf"}:
        basis, isotropic, found, note = read_zemax(paths)
    elif len(paths) != 1:
        raise InputError(f"{paths[1]}: several files: allowed for .bsdf only")
    elif suffix == {".csv"}:
        basis, isotropic, found, note = read_bsdf_csv(paths[0])
    else:
        basis, found = read_klems(paths[0])
        isotropic, note = False, ()
    table = _filled_in(str(paths[0]), basis, isotropic, found, note).checked()
    return table.claimed_reciprocal() if reciprocal else table


def _filled_in(
    name: str,
    basis: AngleBasis,
    isotropic: bool,
    found: dict[tuple[int, int], NDArray[np.float64]],
    note: tuple[str, ...],
) -> BsdfTable:
    incidences = len(basis.azimuths) if isotropic else basis.count
    value = np.zeros((2, 2, incidences, basis.count))
    for (way, side), matrix in found.items():
        value[way, side] = matrix
    notes = list(note)
    for side, other in ((BELOW, ABOVE), (ABOVE, BELOW)):
        for way, word in enumerate(WAYS):
            if (way, side) in found or (way, other) not in found:
                continue
            if way == TRANSMIT and not isotropic:
                back = BsdfTable(name, basis, isotropic, value).reversed_value()
                value[way, side] = back[way, side]
                notes.append(f"{word} from {SIDES[side]}: by reciprocity from the other side")
            else:
                value[way, side] = value[way, other]
                notes.append(f"{word} from {SIDES[side]}: taken as from {SIDES[other]}")
    for way, word in enumerate(WAYS):
        if not any(key[0] == way for key in found):
            notes.append(f"{word}: not in the file, taken as 0")
    return BsdfTable(name, basis, isotropic, value, tuple(notes))


def bsdf_texts(table: BsdfTable, stem: str, form: str) -> dict[str, str]:
    """Return the files of a table in a format of `FORMATS`, text by file name."""
    match form:
        case "klems":
            return {f"{stem}.xml": klems_xml(table)}
        case "csv":
            return {f"{stem}.csv": bsdf_csv(table)}
        case _:
            return zemax_texts(table, stem)


def write_texts(folder: Path, texts: dict[str, str]) -> list[Path]:
    """Write files beside their places first, then rename them: all whole, or none."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        parts = [(folder / f".{name}.part", folder / name) for name in texts]
        try:
            for (part, _), text in zip(parts, texts.values(), strict=True):
                part.write_bytes(text.encode())
            for part, path in parts:
                part.replace(path)
        finally:
            for part, _ in parts:
                part.unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror or error}") from None
    return [path for _, path in parts]
