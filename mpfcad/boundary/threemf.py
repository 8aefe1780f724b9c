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
        when an object stands in another part of the package, or the XML is none.
    """
    number: list[int] = []
    text: list[str] = []
    table: list[NDArray[np.float64]] = []

    def flush() -> None:
        table.append(np.array(" ".join(text).split(), np.float64).reshape(len(text), 4, 3))
        text.clear()

    def item(name: str, given: dict[str, str]) -> None:
        if name != f"{_CORE} item":
            return
        if any(key.endswith(" path") for key in given):
            raise InputError(f"{path}: 3MF: an item in another part: expected all in one model")
        number.append(int(given["objectid"]))
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
