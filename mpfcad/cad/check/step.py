"""Read a STEP file back with OCCT, which did not write it, and compare it with its film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.mesh_check import refuse_above
from mpfcad.cad.check.step_read import read_bodies
from mpfcad.cad.check.step_text import MILLIMETRE, check_text, read_step_text
from mpfcad.cad.step.outline import solid_contact
from mpfcad.cad.step.solid import Bodies
from mpfcad.errors import ExportError
from mpfcad.film import CellFilm, FieldPiece, PrismFilm

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

#: Largest relative error of a body's volume, where coordinates of doubles allow it.
VOLUME_TOLERANCE = 1e-9
#: Error [mm] of a surface that doubles force at x = 400 mm.
SURFACE_TOLERANCE = 1e-12
#: Largest error [mm] of the extents.
EXTENT_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class StepCheck:
    """What a STEP file was found to hold.

    Attributes
    ----------
    valid
        OCCT finds every body valid: closed, no gaps, no self-intersections
    bodies
        volume [mm³] by name
    volume_error
        largest relative error of a body's volume
    low, high
        corners of the bounding box, x, y, z [mm]
    unit
        the file's length unit
    solid_count
        number of solids by name
    """

    valid: bool
    bodies: dict[str, float]
    volume_error: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    unit: str
    solid_count: dict[str, int]


def check_step(path: Path, film: PrismFilm, *, bodies: Bodies = "separate") -> StepCheck:
    """Return what the STEP file at `path` holds, once it is found to be `film`.

    Raises
    ------
    ExportError
        when the file is not in mm, lacks a body or has another, a body is not valid, or the file is
        off in volume, extent, number of solids or curvatures.
    """
    path = Path(path)
    expected = _expected(film, bodies)
    counts = {name: count for name, (count, _) in expected.items()}
    check_text(path, read_step_text(path), film, counts)
    shapes = read_bodies(path, repair=False)
    if set(shapes) != set(expected):
        raise ExportError(f"{path.name}: bodies {sorted(shapes)}: must be {sorted(expected)}")
    volumes, worst = {}, 0.0
    rounding = SURFACE_TOLERANCE * film.width * film.length
    for name, shape in shapes.items():
        count, volume = expected[name]
        check_solids(path, name, shape, count)
        volumes[name] = enclosed_volume(shape)
        error = abs(volumes[name] / volume - 1)
        tolerance = max(VOLUME_TOLERANCE, rounding / volume)
        refuse_above(path, f"{name}: relative volume error", error, tolerance)
        worst = max(worst, error)
    low, high = bounding_box(shapes)
    size = np.array([film.width, film.length, film.thickness])
    off = float(max(np.abs(low).max(), np.abs(high - size).max()))
    refuse_above(path, "extent error [mm]", off, EXTENT_TOLERANCE)
    return StepCheck(True, volumes, worst, _triple(low), _triple(high), "mm", counts)


def _triple(point: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])


def _expected(film: PrismFilm, bodies: Bodies) -> dict[str, tuple[int, float]]:
    """Return the number of solids and the volume [mm³] by the body's name."""
    resin = solid_contact(film) > 0
    fill = float(np.sum(film.fill_fraction[resin])) * film.groove.area * film.length
    if bodies == "fused":
        return {"film": (1, film.prism_volume + fill)}
    expected = {"BEF": (1, film.prism_volume)}
    return {**expected, "fill": (int(resin.sum()), fill)} if resin.any() else expected


def check_one_body(
    path: Path,
    body: str,
    volume: float,
    low: tuple[float, float, float],
    high: tuple[float, float, float],
) -> StepCheck:
    """Return what the STEP file at `path` holds, once it is one solid `body` of this size [mm].

    Raises
    ------
    ExportError
        when it is not in mm, holds another body, or one that is not valid or off in volume or
        extent.
    """
    path = Path(path)
    units = read_step_text(path).units
    if units != MILLIMETRE:
        raise ExportError(f"{path.name}: length units {sorted(units)}: must all be millimetres")
    shapes = read_bodies(path, repair=True)
    if set(shapes) != {body}:
        raise ExportError(f"{path.name}: bodies {sorted(shapes)}: must be {body}")
    check_solids(path, body, shapes[body], 1)
    found = enclosed_volume(shapes[body])
    error = abs(found / volume - 1)
    refuse_above(path, "relative volume error", error, VOLUME_TOLERANCE)
    corners = bounding_box(shapes)
    off = max(float(np.abs(a - b).max()) for a, b in zip(corners, (low, high), strict=True))
    refuse_above(path, "extent error [mm]", off, EXTENT_TOLERANCE)
    return StepCheck(True, {body: found}, error, *map(_triple, corners), "mm", {body: 1})


def check_film_body(path: Path, film: CellFilm | FieldPiece) -> StepCheck:
    """Return what a STEP file holds, once it is found to be the film as one solid `film`.

    Raises
    ------
    ExportError
        when it holds another body, or one that is not valid or off in volume or extent.
    """
    high = (*film.size, film.thickness)
    return check_one_body(path, "film", film.volume, (0, 0, 0), high)


def check_solids(path: Path, name: str, shape: TopoDS_Shape, expected: int) -> None:
    """Refuse a body that has not as many solids as expected, or one that is not valid."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    count = sum(1 for _ in _solids(shape))
    if count != expected:
        raise ExportError(f"{path.name}: {name}: {count} solids: must be {expected}")
    if not BRepCheck_Analyzer(shape).IsValid():
        raise ExportError(f"{path.name}: {name}: OCCT finds this body not valid")


def _solids(shape: TopoDS_Shape) -> Iterator[TopoDS_Shape]:
    """Yield the solids of a shape."""
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    explorer = TopExp_Explorer(shape, TopAbs_SOLID)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def enclosed_volume(shape: TopoDS_Shape) -> float:
    """Return the volume [mm³] that the faces enclose; negative when they face inward.

    OCCT integrates about a place of each solid: about the origin, thin solids far from it lose
    digits.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.TopAbs import TopAbs_VERTEX
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    volume = 0.0
    for solid in _solids(shape):
        corner = TopoDS.Vertex(TopExp_Explorer(solid, TopAbs_VERTEX).Current())
        properties = GProp_GProps(BRep_Tool.Pnt_s(corner))
        BRepGProp.VolumeProperties_s(solid, properties)
        volume += properties.Mass()
    return volume


def bounding_box(
    shapes: dict[str, TopoDS_Shape],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the two corners of the bodies' bounding box [mm]."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    for shape in shapes.values():
        BRepBndLib.AddOptimal_s(shape, box, False, False)
    low, high = box.CornerMin(), box.CornerMax()
    return (
        np.array([low.X(), low.Y(), low.Z()]),
        np.array([high.X(), high.Y(), high.Z()]),
    )
