"""3MF, read by lib3mf: every item that is built, with its components where they stand, in mm."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.solid.format.body import Body, MeshFile

_DEEPEST = 16
#: Factors to mm, in the order of lib3mf's ModelUnit.
_UNITS = {
    "MicroMeter": 1e-3, "MilliMeter": 1.0, "CentiMeter": 10.0, "Inch": 25.4, "Foot": 304.8,
    "Meter": 1000.0,
}  # fmt: skip


def read_3mf(path: Path, data: bytes) -> MeshFile:
    """Return the bodies of a 3MF file.

    Raises
    ------
    InputError
        when lib3mf cannot read it, or nothing is built.
    """
    import lib3mf

    model = lib3mf.Wrapper().CreateModel()
    try:
        model.QueryReader("3mf").ReadFromBuffer(np.frombuffer(data, np.uint8))
        unit = model.GetUnit().name
        items, bodies = model.GetBuildItems(), []
        while items.MoveNext():
            item = items.GetCurrent()
            place = _place(item.GetObjectTransform() if item.HasObjectTransform() else None)
            bodies += _bodies(path, item.GetObjectResource(), place, 0)
    except lib3mf.ELib3MFException as error:
        raise InputError(f"{path}: lib3mf cannot read this 3MF: {error}") from None
    if not bodies:
        raise InputError(f"{path}: 3MF: nothing to build: expected an item with a mesh")
    factor = _UNITS[unit]
    scaled = tuple(Body(body.name, body.corner * factor) for body in bodies)
    note = () if factor == 1 else (f"unit {unit.lower()} converted to mm",)
    return MeshFile("3MF", scaled, note=note)


def _bodies(path: Path, thing: Any, place: NDArray[np.float64], deep: int) -> list[Body]:
    """Return the bodies of an object, and of its components, where they stand."""
    if deep > _DEEPEST:
        raise InputError(f"{path}: 3MF: components {_DEEPEST} deep: expected fewer")
    if thing.IsMeshObject():
        point = np.array([tuple(p.Coordinates) for p in thing.GetVertices()], float)
        facet = np.array([tuple(t.Indices) for t in thing.GetTriangleIndices()], np.int64)
        if len(facet) == 0:
            return []
        moved = point @ place[:3] + place[3]
        # A mirrored instance turns its facets inside out: turned back, as the standard says.
        order = facet[:, ::-1] if np.linalg.det(place[:3]) < 0 else facet
        return [Body(thing.GetName() or "body", moved[order])]
    found = []
    for n in range(thing.GetComponentCount()):
        part = thing.GetComponent(n)
        inner = _place(part.GetTransform() if part.HasTransform() else None)
        whole = np.vstack([inner[:3] @ place[:3], inner[3] @ place[:3] + place[3]])
        found += _bodies(path, part.GetObjectResource(), whole, deep + 1)
    return found


def _place(transform: Any) -> NDArray[np.float64]:
    """Return a transform as (4, 3): rows of the rotation, then the shift."""
    if transform is None:
        return np.eye(4)[:, :3]
    return np.array([list(row) for row in transform.Fields], float)
