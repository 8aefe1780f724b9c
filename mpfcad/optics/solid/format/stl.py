"""STL, binary and as text."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.solid.format.body import Body, MeshFile

_RECORD = np.dtype(
    [("normal", "<f4", (3,)), ("vertex", "<f4", (3, 3)), ("attribute", "<u2")], align=False
)
_HEAD = 84


def read_stl_text(path: Path, data: bytes) -> MeshFile:
    """Return the bodies of an STL written as text.

    Raises
    ------
    InputError
        when a facet has not three corners of three numbers.
    """
    bodies: list[Body] = []
    name, rows = "solid", []
    for number, line in enumerate(data.decode("latin-1").splitlines(), 1):
        words = line.split()
        match words[0].lower() if words else "":
            case "solid":
                name = " ".join(words[1:]) or "solid"
            case "vertex":
                rows.append(_numbers(path, number, words))
            case "endfacet" if len(rows) % 3:
                raise InputError(f"{path}: line {number}: facet: expected three vertices")
            case "endsolid":
                bodies, rows = _ended(path, bodies, name, rows)
    if rows:
        raise InputError(f"{path}: endsolid: missing: expected after the last facet")
    if sum(len(body.corner) for body in bodies) < 4:
        raise InputError(f"{path}: an STL as text: expected 4 facets or more")
    return MeshFile("STL as text", tuple(bodies), single=True)


def _ended(
    path: Path, bodies: list[Body], name: str, rows: list[list[float]]
) -> tuple[list[Body], list[list[float]]]:
    corner = np.array(rows, float).reshape(-1, 3, 3)
    return ([*bodies, Body(name, corner)] if len(corner) else bodies), []


def _numbers(path: Path, number: int, words: list[str]) -> list[float]:
    try:
        values = [float(word) for word in words[1:]]
        if len(values) != 3:
            raise ValueError
    except ValueError:
        raise InputError(
            f"{path}: line {number}: {' '.join(words)}: expected vertex and three numbers"
        ) from None
    return values


def read_stl_binary(path: Path, data: bytes) -> MeshFile:
    """Return the body of a binary STL; bytes after its last facet are left out and noted.

    Raises
    ------
    InputError
        when the file is shorter than its count of facets says.
    """
    count = int.from_bytes(data[80:_HEAD], "little")
    size = _HEAD + count * _RECORD.itemsize
    if len(data) < _HEAD or len(data) < size or count < 4:
        raise InputError(
            f"{path}: not a binary STL: {len(data)} bytes for {count} facets, expected {size} and "
            "4 facets or more"
        )
    note: tuple[str, ...] = ()
    if len(data) > size:
        note = (f"{len(data) - size} bytes after the last facet left out",)
    corner: NDArray = np.frombuffer(data, _RECORD, count, offset=_HEAD)["vertex"]
    return MeshFile("binary STL", (Body("solid", corner.astype(float)),), True, note)
