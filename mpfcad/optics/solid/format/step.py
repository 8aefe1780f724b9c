"""STEP, read and tessellated by Open CASCADE: a body a solid, facets within a slope."""

import os
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.boundary.apart import apart
from mpfcad.errors import InputError
from mpfcad.optics.solid.format.body import Body, MeshFile

#: Largest angle [rad] between the normals at the ends of a facet's edge on a curved face.
SLOPE_TOLERANCE = np.radians(0.5)
#: Largest distance [mm] of a chord from its curve, and the shortest chord [mm].
_DEFLECTION, _LEAST = 1e-3, 1e-6
#: More faces take the kernel minutes to hours.
MOST_FACES = 20_000


def read_step(path: Path, data: bytes) -> MeshFile:
    """Return the solids of a STEP file as facets [mm].

    Raises
    ------
    InputError
        when the kernel cannot read it, it holds no solid, or more faces than can be tessellated.
    """
    faces = data.count(b"ADVANCED_FACE") + data.count(b"FACE_SURFACE")
    if faces > MOST_FACES:
        raise InputError(
            f"{path}: STEP: {faces} faces: expected at most {MOST_FACES} to tessellate: give the "
            "film's STL, or fewer grooves"
        )
    bodies = apart(
        path, "a STEP file of solids", read_solids, path, data, libraries=("OCP.STEPControl",)
    )
    if not bodies:
        raise InputError(f"{path}: STEP: no solid in it: expected one or more")
    kind = f"STEP, facets within {np.degrees(SLOPE_TOLERANCE):g} deg of the surface's slope"
    return MeshFile(kind, tuple(bodies))


def read_solids(path: Path, data: bytes) -> list[Body]:
    """Return the solids as facets [mm]; the kernel crashes at some damaged files."""
    shape = _shape(path, data)
    _refuse_losses(path, data, shape)
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    BRepMesh_IncrementalMesh(shape, _parameters())
    walk = TopExp_Explorer(shape, TopAbs_SOLID)
    bodies: list[Body] = []
    while walk.More():
        bodies.append(_body(path, TopoDS.Solid(walk.Current()), len(bodies) + 1))
        walk.Next()
    return bodies


def _refuse_losses(path: Path, data: bytes, shape: Any) -> None:
    """Refuse a file of whose faces or solids the kernel has left some out.

    It passes over what it does not understand, an edge with a damaged name, say, and closes what is
    left as well as it can: another film.
    """
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID

    for what, names, kind in (
        ("faces", b"ADVANCED_FACE|FACE_SURFACE", TopAbs_FACE),
        ("solids", b"MANIFOLD_SOLID_BREP|FACETED_BREP|BREP_WITH_VOIDS", TopAbs_SOLID),
    ):
        found = _distinct(shape, kind)
        named = len(re.findall(rb"=\s*(?:%s)\s*\(" % names, data))
        if found < named:
            raise InputError(
                f"{path}: STEP: {found} of {named} {what} can be read: expected a file without "
                "damage"
            )


def _distinct(shape: Any, kind: Any) -> int:
    """Return how many parts of a kind there are; one that stands in several places counts once."""
    from OCP.TopExp import TopExp_Explorer

    found: dict[int, Any] = {}
    walk = TopExp_Explorer(shape, kind)
    while walk.More():
        # What places share is one object, as long as it is held.
        own = walk.Current().TShape()
        found[id(own)] = own
        walk.Next()
    return len(found)


def _parameters() -> Any:
    """Return how the kernel tessellates: the slope rules, with no corners inside a face."""
    from OCP.IMeshTools import IMeshTools_Parameters

    parameters = IMeshTools_Parameters()
    parameters.Angle = parameters.AngleInterior = float(SLOPE_TOLERANCE)
    # The kernel's own least size is a share of the deflection, and would be wider than a groove.
    parameters.Deflection = parameters.DeflectionInterior = _DEFLECTION
    parameters.MinSize = _LEAST
    parameters.InternalVerticesMode = False
    parameters.ControlSurfaceDeflection = False
    return parameters


def _shape(path: Path, data: bytes) -> Any:
    """Return the shape that the kernel reads, in mm."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader

    # By a plain name of its own: the kernel takes no path that is not in its code page.
    handle, name = tempfile.mkstemp(suffix=".step")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        reader = STEPControl_Reader()
        if reader.ReadFile(name) != IFSelect_RetDone or reader.TransferRoots() < 1:
            raise InputError(
                f"{path}: begins as STEP, and the CAD kernel finds no solid in it: expected a STEP "
                "file with a solid"
            )
        return reader.OneShape()
    finally:
        Path(name).unlink()


def _body(path: Path, solid: Any, number: int) -> Body:
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    corners = []
    walk = TopExp_Explorer(solid, TopAbs_FACE)
    while walk.More():
        face = TopoDS.Face(walk.Current())
        walk.Next()
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, location)
        if mesh is None:
            raise InputError(f"{path}: STEP: a face of solid {number} cannot be tessellated")
        move = location.Transformation()
        nodes = [mesh.Node(n).Transformed(move) for n in range(1, mesh.NbNodes() + 1)]
        point = np.array([(p.X(), p.Y(), p.Z()) for p in nodes])
        facet = np.array([mesh.Triangle(n).Get() for n in range(1, mesh.NbTriangles() + 1)]) - 1
        if face.Orientation() == TopAbs_REVERSED:
            facet = facet[:, ::-1]
        corners.append(point[facet])
    return Body(f"solid {number}", np.concatenate(corners))
