"""Where the instances of a 3MF file stand, by expat: lib3mf's objects cost 40 µs an instance."""

import zipfile
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

_MODEL_TYPE = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_IN_PLACE = "1 0 0 0 1 0 0 0 1 0 0 0"
#: Places held as text at a time: a million of them take a gigabyte.
_CHUNK = 20_000
#: The largest number of an object, by the core specification.
_LAST = 2**31 - 1


class Instances(NamedTuple):
    """The items that a 3MF builds.

    Attributes
    ----------
    number
        (k,) int64, the file's own number of the object of each
    transform
        (k, 4, 3) float64, of a row (x, y, z, 1); lengths in the file's unit
    """

    number: NDArray[np.int64]
    transform: NDArray[np.float64]


def read_instances(path: Path) -> Instances:
    """Return the items to build of a 3MF file that lib3mf has read.

    Raises
    ------
    InputError
        when an object stands in another part of the package, an item has no number of an object
        or not twelve finite numbers, or the XML is none.
    """
    number: list[int] = []
    text: list[str] = []
    table: list[NDArray[np.float64]] = []

    def flush() -> None:
        table.append(_transforms(text))
        text.clear()

    def item(name: str, given: dict[str, str]) -> None:
        if name != f"{_CORE} item":
            return
        if any(key.endswith(" path") for key in given):
            raise InputError(f"{path}: 3MF: an item in another part: expected all in one model")
        number.append(_object(given.get("objectid", "")))
        text.append(given.get("transform", _IN_PLACE))
        if len(text) == _CHUNK:
            flush()

    try:
        with zipfile.ZipFile(path) as archive:
            _parse(archive, _model_part(archive), item)
        flush()
    except (expat.ExpatError, KeyError, ValueError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: 3MF: {error}: expected a model with items") from None
    return Instances(np.array(number, np.int64), np.concatenate(table))


def _object(text: str) -> int:
    """Return an object's number, of ASCII digits alone: int takes 1_0 as well."""
    digits = text.strip()
    if digits.isascii() and digits.isdigit() and len(digits) <= 10 and 0 < int(digits) <= _LAST:
        return int(digits)
    raise ValueError(f"objectid {text[:40]!r}: not from 1 to {_LAST}")


def _transforms(text: list[str]) -> NDArray[np.float64]:
    """Return the transforms (k, 4, 3) of k items; twelve numbers each, not of all together."""
    rows = [one.split() for one in text]
    short = next((one for one in rows if len(one) != 12), None)
    if short is not None:
        raise ValueError(f"a transform of {len(short)} numbers, not 12")
    table = np.array(rows, np.float64).reshape(len(rows), 4, 3)
    if not np.isfinite(table).all():
        raise ValueError("a transform with a number that is not finite")
    return table


def _model_part(archive: zipfile.ZipFile) -> str:
    """Return the name of the package's model."""
    target: list[str] = []

    def relation(name: str, given: dict[str, str]) -> None:
        if given.get("Type") == _MODEL_TYPE:
            target.append(given["Target"].lstrip("/"))

    _parse(archive, "_rels/.rels", relation)
    return target[0] if target else "3D/3dmodel.model"


def _parse(archive: zipfile.ZipFile, part: str, start: object) -> None:
    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = start  # type: ignore[assignment]
    with archive.open(part) as file:
        parser.ParseFile(file)
