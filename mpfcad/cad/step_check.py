"""Read a STEP file back, as text and with OCCT, and compare it with the film it should be."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.outline import has_solid_parabola, solid_contact
from mpfcad.errors import ExportError
from mpfcad.film import PrismFilm

if TYPE_CHECKING:
    from OCP.TDF import TDF_Label
    from OCP.TopoDS import TopoDS_Shape

#: Largest relative error of a body's volume.
VOLUME_TOLERANCE = 1e-6
#: Largest error [mm] of the extents and of a parabola's place.
EXTENT_TOLERANCE = 1e-6
#: Largest relative error of a parabola's curvature: STEP carries 13 digits.
CURVATURE_TOLERANCE = 1e-9


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


def check_step(path: Path, film: PrismFilm) -> StepCheck:
    """Return what the STEP file at `path` holds, once it is found to be `film`.

    Raises
    ------
    ExportError
        when the file is not in mm, lacks a body or has another, a body is not valid, or the file is
        off in volume, extent, number of solids or curvatures.
    """
    path = Path(path)
    expected = _expected(film)
    _check_text(path, film, expected)
    shapes = _read(path)
    if set(shapes) != set(expected):
        raise ExportError(f"{path.name}: bodies {sorted(shapes)}: must be {sorted(expected)}")
    volumes, counts, worst = {}, {}, 0.0
    for name, shape in shapes.items():
        count, volume = expected[name]
        counts[name] = _check_solids(path, name, shape, count)
        volumes[name] = _volume(shape)
        error = abs(volumes[name] / volume - 1)
        _limit(path, f"{name}: relative volume error", error, VOLUME_TOLERANCE)
        worst = max(worst, error)
    low, high = _extent(shapes)
    size = np.array([film.width, film.length, film.thickness])
    off = float(max(np.abs(low).max(), np.abs(high - size).max()))
    _limit(path, "extent error [mm]", off, EXTENT_TOLERANCE)
    return StepCheck(True, volumes, worst, _triple(low), _triple(high), "mm", counts)


def _limit(path: Path, what: str, value: float, limit: float) -> None:
    # Written so that NaN fails.
    if not value <= limit:
        raise ExportError(f"{path.name}: {what}: {value:.3g}: must be at most {limit:.3g}")


def _triple(point: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])


def _expected(film: PrismFilm) -> dict[str, tuple[int, float]]:
    """Return the number of solids and the volume [mm³] by the body's name."""
    expected = {"BEF": (1, film.prism_volume)}
    resin = solid_contact(film) > 0
    if resin.any():
        volume = float(np.sum(film.fill_fraction[resin])) * film.groove.area * film.length
        expected["fill"] = (int(resin.sum()), volume)
    return expected


def _check_text(path: Path, film: PrismFilm, expected: dict[str, tuple[int, float]]) -> None:
    """Compare unit, names, number of solids and curvatures without any CAD library."""
    try:
        text = path.read_bytes()
    except OSError as error:
        raise ExportError(f"{path.name}: {error.strerror}") from error
    if not text.startswith(b"ISO-10303-21;") or not text.rstrip().endswith(b"END-ISO-10303-21;"):
        raise ExportError(f"{path.name}: not a whole STEP file")
    lengths = re.findall(rb"LENGTH_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(([^)]*)\)", text)
    if set(lengths) != {b".MILLI.,.METRE."}:
        raise ExportError(f"{path.name}: length units {lengths}: must all be millimetres")
    names = {name.decode() for name in re.findall(rb"= PRODUCT\('([^']*)'", text)}
    if not set(expected) <= names:
        raise ExportError(f"{path.name}: products {sorted(names)}: must hold {sorted(expected)}")
    solids = len(re.findall(rb"= MANIFOLD_SOLID_BREP\(", text))
    wanted = sum(count for count, _ in expected.values())
    if solids != wanted:
        raise ExportError(f"{path.name}: {solids} solids: must be {wanted}")
    _check_parabolas(path, text, film)


def _check_parabolas(path: Path, text: bytes, film: PrismFilm) -> None:
    """Compare each parabola's place and its curvature, 1/(2 focal length), with its groove's."""
    parabolas = np.array(
        [
            (int(axis), float(focal))
            for axis, focal in re.findall(rb"= PARABOLA\('[^']*',#(\d+),([^)]*)\)", text)
        ]
    ).reshape(-1, 2)
    origin = dict(re.findall(rb"#(\d+) = AXIS2_PLACEMENT_3D\('[^']*',#(\d+),", text))
    points = dict(re.findall(rb"#(\d+) = CARTESIAN_POINT\('[^']*',\(([^)]*)\)\)", text))
    vertex = np.array(
        [
            [float(part) for part in points[origin[b"%d" % int(axis)]].split(b",")]
            for axis in parabolas[:, 0]
        ]
    ).reshape(-1, 3)
    groove = np.clip((vertex[:, 0] / film.groove.pitch).astype(int), 0, film.groove_count - 1)
    drawn = np.zeros(film.groove_count, bool)
    drawn[groove] = True
    if np.any(drawn != has_solid_parabola(film)):
        index = int(np.argmax(drawn != has_solid_parabola(film)))
        raise ExportError(
            f"{path.name}: groove {index} has {'a' if drawn[index] else 'no'} parabola"
        )
    if len(groove) == 0:
        return
    curvature = film.curvature[groove]
    off = np.abs(1 / (2 * parabolas[:, 1]) / curvature - 1)
    _limit(path, "relative curvature error", float(off.max()), CURVATURE_TOLERANCE)
    bottom = film.thickness - curvature / 2 * film.groove.half_width**2
    off = np.hypot(vertex[:, 0] - film.groove_position[groove], vertex[:, 2] - bottom)
    _limit(path, "place of a parabola [mm]", float(off.max()), EXTENT_TOLERANCE)


def _read(path: Path) -> dict[str, TopoDS_Shape]:
    """Return the bodies in the file by name, read with OCCT."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    from mpfcad.cad.step import mute_occt, new_document

    mute_occt()
    document = new_document()
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(False)
    if reader.ReadFile(str(path)) != IFSelect_RetDone or not reader.Transfer(document):
        raise ExportError(f"{path.name}: OCCT cannot read this file")
    roots = Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    bodies: dict[str, TopoDS_Shape] = {}
    for index in range(1, roots.Length() + 1):
        for name, shape in _parts(roots.Value(index)):
            if name in bodies:
                raise ExportError(f"{path.name}: two bodies named {name}")
            bodies[name] = shape
    return bodies


def _parts(label: TDF_Label) -> Iterator[tuple[str, TopoDS_Shape]]:
    """Yield the name and shape of each part under a label of an OCCT document."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.TDataStd import TDataStd_Name
    from OCP.XCAFDoc import XCAFDoc_ShapeTool

    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        components = Sequence_TDF_Label()
        XCAFDoc_ShapeTool.GetComponents_s(label, components)
        for index in range(1, components.Length() + 1):
            yield from _parts(components.Value(index))
        return
    name = TDataStd_Name()
    found = label.FindAttribute(TDataStd_Name.GetID_s(), name)
    yield name.Get().ToExtString() if found else "", XCAFDoc_ShapeTool.GetShape_s(label)


def _check_solids(path: Path, name: str, shape: TopoDS_Shape, expected: int) -> int:
    """Return how many solids a body has, once they are as many as expected and all valid."""
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    count = 0
    explorer = TopExp_Explorer(shape, TopAbs_SOLID)
    while explorer.More():
        count += 1
        explorer.Next()
    if count != expected:
        raise ExportError(f"{path.name}: {name}: {count} solids: must be {expected}")
    if not BRepCheck_Analyzer(shape).IsValid():
        raise ExportError(f"{path.name}: {name}: OCCT finds this body not valid")
    return count


def _volume(shape: TopoDS_Shape) -> float:
    """Return the volume [mm³] that the faces enclose; negative when they face inward."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return properties.Mass()


def _extent(
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
