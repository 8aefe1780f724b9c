"""Reads BSDF tables from any of their formats, checks them, and writes them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from mpfcad.boundary import TEXT_LIMIT, check_file, guarded
from mpfcad.boundary.out import check_out
from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.format.astm import is_astm, read_astm
from mpfcad.optics.bsdf.format.csv import bsdf_csv, read_bsdf_csv
from mpfcad.optics.bsdf.format.klems import incident_structure, klems_xml, read_klems
from mpfcad.optics.bsdf.format.lighttools import is_lighttools, read_lighttools
from mpfcad.optics.bsdf.format.source import read_xml
from mpfcad.optics.bsdf.format.tree import read_tree
from mpfcad.optics.bsdf.format.zemax import read_zemax
from mpfcad.optics.bsdf.format.zemax_text import zemax_texts
from mpfcad.optics.bsdf.missing import NOTHING, WHOLE, Matrices, Taken, fill_in
from mpfcad.optics.bsdf.table import BsdfTable

FORMATS = ("klems", "csv", "zemax")
#: Characters by which a file is known to be of a kind.
_BEGINNING = 8
_SUFFIXES = (".xml", ".csv", ".astm", ".bsdf")
#: (basis, isotropic, matrices (i, o) [1/sr] by (way, side), notes) of a file.
_Read = tuple[AngleBasis, bool, Matrices, tuple[str, ...]]


def read_bsdf(
    path: Path | Sequence[Path],
    *,
    taken: Taken = NOTHING,
    needed: frozenset[tuple[int, int]] = WHOLE,
    normalise: bool = False,
    rotation: str | None = None,
) -> BsdfTable:
    """Return the checked table of one file, or of several `.bsdf` files of one element.

    What the files do not hold is what `taken` says of it, each with a note. `normalise` accepts
    sums a few percent above 1, `rotation` says what Zemax sample rotations mean.

    Raises
    ------
    InputError
        naming file, incidence, value and what was expected.
    """
    paths = [Path(path)] if isinstance(path, str | Path) else [Path(p) for p in path]
    with guarded(", ".join(map(str, paths)), "a BSDF table"):
        return _read_table(paths, taken, needed, normalise, rotation)


def _read_table(
    paths: list[Path],
    taken: Taken,
    needed: frozenset[tuple[int, int]],
    normalise: bool,
    rotation: str | None,
) -> BsdfTable:
    basis, isotropic, found, note = _read(paths, rotation)
    table = fill_in(str(paths[0]), basis, isotropic, found, taken, needed)
    table = replace(table, note=(*note, *table.note)).checked(normalise=normalise)
    return table.claimed_reciprocal() if taken.reciprocal else table


def _read(paths: list[Path], rotation: str | None) -> _Read:
    """Return what the files hold."""
    for p in paths:
        if p.suffix.lower() not in _SUFFIXES:
            raise InputError(f"{p}: {p.suffix or 'no suffix'}: expected {', '.join(_SUFFIXES)}")
        check_file(p, TEXT_LIMIT, "a BSDF table")
    suffix = {p.suffix.lower() for p in paths}
    if suffix == {".bsdf"} and not is_lighttools(paths[0]):
        return read_zemax(paths, rotation)
    if len(paths) != 1:
        raise InputError(f"{paths[1]}: several files: expected for Zemax .bsdf only")
    if suffix == {".bsdf"}:
        return read_lighttools(paths[0])
    if suffix == {".xml"}:
        return _read_xml(paths[0])
    return read_astm(paths[0]) if is_astm(paths[0]) else read_bsdf_csv(paths[0])


def _read_xml(path: Path) -> _Read:
    root, note = read_xml(path)
    if incident_structure(root).startswith("tensortree"):
        return (*read_tree(path, root), note)
    return (*_anisotropic(*read_klems(path, root)), note)


def _anisotropic(basis: AngleBasis, found: Matrices) -> tuple[AngleBasis, bool, Matrices]:
    return basis, False, found


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
    """Write files beside their places first, then rename them: all whole, or none.

    Raises
    ------
    InputError
        when one cannot be written, or would replace a file that begins otherwise.
    """
    for name, text in texts.items():
        check_out("--out", folder / name, (text[:_BEGINNING].encode(),))
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
