"""Read a STEP file back with OCCT, which did not write it, and compare it with its film."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.check.step.read import read_bodies
from mpfcad.cad.check.step.text import MILLIMETRE, check_text, read_step_text, read_units
from mpfcad.cad.step.outline import solid_contact
from mpfcad.cad.step.solid import Bodies
from mpfcad.errors import ExportError
from mpfcad.film import CellFilm, FieldPiece, PrismFilm
from mpfcad.gate import Gate, worst_of_each, yes_no
from mpfcad.units import um

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

Triple = tuple[float, float, float]
#: Largest relative error of a body's volume, where coordinates of doubles allow it.
VOLUME_LIMIT = 1e-9
#: Error [mm] of a surface that doubles force at x = 400 mm.
SURFACE_ROUNDING = 1e-12
#: Largest error [mm] of the extents.
EXTENT_LIMIT = 1e-6


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
    gates
        each figure against its limit
    """

    valid: bool
    bodies: dict[str, float]
    volume_error: float
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    unit: str
    solid_count: dict[str, int]
    gates: tuple[Gate, ...]


def check_step(path: Path, film: PrismFilm, *, bodies: Bodies = "separate") -> StepCheck:
    """Return what the STEP file at `path` holds, measured against `film`; its gates judge.

    Raises
    ------
    ExportError
        when the file is not in mm, or has other bodies, solids or parabolas than the film.
    """
    path = Path(path)
    expected = _expected(film, bodies)
    counts = {name: count for name, (count, _) in expected.items()}
    gates = check_text(path, read_step_text(path), film, counts)
    shapes = read_bodies(path, repair=False)
    size = (film.width, film.length, film.thickness)
    rounding = SURFACE_ROUNDING * film.width * film.length
    return _measure(path, shapes, expected, ((0.0, 0.0, 0.0), size), rounding, gates)


def _measure(
    path: Path,
    shapes: dict[str, TopoDS_Shape],
    expected: dict[str, tuple[int, float]],
    extent: tuple[Triple, Triple],
    rounding: float,
    gates: tuple[Gate, ...] = (),
) -> StepCheck:
    """Return what bodies were found to be.

    `expected` is number of solids and volume [mm³] by name, `rounding` the volume [mm³] that
    doubles do not tell apart, `gates` what is known already.
    """
    if set(shapes) != set(expected):
        raise ExportError(f"{path.name}: bodies {sorted(shapes)}: expected {sorted(expected)}")
    volumes, volume_gates, invalid = {}, [], []
    for name, shape in shapes.items():
        count, volume = expected[name]
        invalid += [] if check_solids(path, name, shape, count) else [name]
        volumes[name] = enclosed_volume(shape)
        error = abs(volumes[name] / volume - 1)
        limit = max(VOLUME_LIMIT, rounding / volume)
        volume_gates.append(Gate("step_volume_error", error, limit, detail=f"{path.name}: {name}"))
    low, high = bounding_box(shapes)
    off = max(float(np.abs(a - b).max()) for a, b in zip((low, high), extent, strict=True))
    why = f"{path.name}: {', '.join(invalid)}: OCCT finds this body not valid"
    found = (
        yes_no("step_valid", not invalid, why),
        *gates,
        *worst_of_each(volume_gates),
        Gate("step_extent_error_um", off / um, EXTENT_LIMIT / um, detail=path.name),
    )
    counts = {name: count for name, (count, _) in expected.items()}
    worst = max(abs(volumes[name] / expected[name][1] - 1) for name in volumes)
    return StepCheck(not invalid, volumes, worst, _triple(low), _triple(high), "mm", counts, found)


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
    *,
    repair: bool = True,
) -> StepCheck:
    """Return what the STEP file at `path` holds, measured against one solid `body` of this size.

    `repair`: read with what OCCT fits to patches; planes and extrusions need none of it.

    Raises
    ------
    ExportError
        when it is not in mm, or holds another body.
    """
    path = Path(path)
    units = read_units(path)
    if units != MILLIMETRE:
        raise ExportError(f"{path.name}: length units {sorted(units)}: expected all millimetres")
    shapes = read_bodies(path, repair=repair)
    return _measure(path, shapes, {body: (1, volume)}, (low, high), 0.0)


def check_film_body(path: Path, film: CellFilm | FieldPiece) -> StepCheck:
    """Return what a STEP file holds, measured against the film as one solid `film`.

    Raises
    ------
    ExportError
        when it is not in mm, or holds another body.
    """
    high = (*film.size, film.thickness)
    return check_one_body(path, "film", film.volume, (0, 0, 0), high)


def check_solids(path: Path, name: str, shape: TopoDS_Shape, expected: int) -> bool:
    """Return whether OCCT finds a body valid; refuse another number of solids than expected."""
    from OCP.BRepCheck import BRepCheck_Analyzer

    count = sum(1 for _ in _solids(shape))
    if count != expected:
        raise ExportError(f"{path.name}: {name}: {count} solids: expected {expected}")
    return bool(BRepCheck_Analyzer(shape).IsValid())


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
