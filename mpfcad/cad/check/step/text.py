"""What a STEP file of a film says as text, found without any CAD library."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.step.outline import has_solid_parabola
from mpfcad.errors import ExportError
from mpfcad.film import PrismFilm
from mpfcad.gate import Gate
from mpfcad.units import um

#: The only length unit that a file may state.
MILLIMETRE = {".MILLI.,.METRE."}
#: Largest error [mm] of a parabola's place.
PLACE_LIMIT = 1e-9
#: Largest relative error of a parabola's curvature.
CURVATURE_LIMIT = 1e-9


@dataclass(frozen=True, eq=False)
class StepText:
    """The film's surfaces as a STEP file states them.

    Attributes
    ----------
    units
        every length unit in the file
    products
        names of all products
    solid_count
        number of solids
    vertex, normal
        (p, 3) float64 [mm] and unit vectors, the vertices of the parabolas and their planes
    curvature
        (p,) float64 [1/mm] of the parabolas, 1/(2 focal length); negative where they open downward
    low
        (p, 3) float64 [mm], the least x, y and z of the corners between which a parabola is drawn;
        its vertex where no edge follows it
    centre, radius
        (c, 3) and (c,) float64 [mm] of the circles
    plane_point, plane_normal
        (q, 3) float64 [mm] and unit vectors of the planes
    patch
        (b, 3, 3, 3) float64 [mm], the control points of the biquadratic patches
    """

    units: frozenset[str]
    products: frozenset[str]
    solid_count: int
    vertex: NDArray[np.float64]
    normal: NDArray[np.float64]
    curvature: NDArray[np.float64]
    low: NDArray[np.float64]
    centre: NDArray[np.float64]
    radius: NDArray[np.float64]
    plane_point: NDArray[np.float64]
    plane_normal: NDArray[np.float64]
    patch: NDArray[np.float64]


def read_step_text(path: Path) -> StepText:
    """Return what the STEP file at `path` states.

    Raises
    ------
    ExportError
        when it is no whole STEP file, or a surface refers to what is not there.
    """
    text = _read(path)
    products = re.findall(rb"=PRODUCT\('([^']*)'", text)
    try:
        surfaces = _surfaces(text)
    except (KeyError, ValueError) as error:
        raise ExportError(f"{path.name}: a surface is not whole: {error}") from error
    return StepText(
        _units(text),
        frozenset(name.decode() for name in products),
        text.count(b"=MANIFOLD_SOLID_BREP("),
        *surfaces,
    )


def read_units(path: Path) -> frozenset[str]:
    """Return every length unit that the STEP file at `path` states.

    Raises
    ------
    ExportError
        when it is no whole STEP file.
    """
    return _units(_read(path))


def _read(path: Path) -> bytes:
    try:
        text = path.read_bytes()
    except OSError as error:
        raise ExportError(f"{path.name}: {error.strerror}") from error
    if not text.startswith(b"ISO-10303-21;") or not text.rstrip().endswith(b"END-ISO-10303-21;"):
        raise ExportError(f"{path.name}: not a whole STEP file")
    return text


def _units(text: bytes) -> frozenset[str]:
    found = re.findall(rb"LENGTH_UNIT\(\)NAMED_UNIT\(\*\)SI_UNIT\(([^)]*)\)", text)
    return frozenset(unit.decode() for unit in found)


def _surfaces(text: bytes) -> tuple[NDArray[np.float64], ...]:
    """Return the attributes of parabolas, circles, planes and patches."""
    axes = {
        key: places
        for key, *places in re.findall(
            rb"(#\d+)=AXIS2_PLACEMENT_3D\('[^']*',(#\d+),(#\d+),(#\d+)\)", text
        )
    }
    points = dict(re.findall(rb"(#\d+)=CARTESIAN_POINT\('[^']*',\(([^)]*)\)\)", text))
    directions = dict(re.findall(rb"(#\d+)=DIRECTION\('[^']*',\(([^)]*)\)\)", text))
    named = re.findall(rb"(#\d+)=PARABOLA\('[^']*',(#\d+),([^)]*)\)", text)
    parabolas = [rest for _, *rest in named]
    circles = re.findall(rb"=CIRCLE\('[^']*',(#\d+),([^)]*)\)", text)
    planes = re.findall(rb"=PLANE\('[^']*',(#\d+)\)", text)
    patches = re.findall(rb"=B_SPLINE_SURFACE_WITH_KNOTS\('[^']*',2,2,\(([#\d,()]*)\),\.", text)
    focal = np.array([float(value) for _, value in parabolas])
    opening = _triples([directions[axes[key][2]] for key, _ in parabolas])
    return (
        _triples([points[axes[key][0]] for key, _ in parabolas]),
        _triples([directions[axes[key][1]] for key, _ in parabolas]),
        np.sign(opening[:, 2]) / (2 * focal),
        _lowest_corners(text, points, [(key, points[axes[place][0]]) for key, place, _ in named]),
        _triples([points[axes[key][0]] for key, _ in circles]),
        np.array([float(value) for _, value in circles]),
        _triples([points[axes[key][0]] for key in planes]),
        _triples([directions[axes[key][1]] for key in planes]),
        _triples([points[key] for patch in patches for key in re.findall(rb"#\d+", patch)]).reshape(
            -1, 3, 3, 3
        ),
    )


def _lowest_corners(
    text: bytes, points: dict[bytes, bytes], curves: list[tuple[bytes, bytes]]
) -> NDArray[np.float64]:
    """Return the least coordinates [mm] of the ends of the edges along each (curve, vertex)."""
    wanted = {key: place for place, (key, _) in enumerate(curves)}
    low = np.full((len(curves), 3), np.inf)
    if wanted:
        corner = dict(re.findall(rb"(#\d+)=VERTEX_POINT\('[^']*',(#\d+)\)", text))
        edges = re.findall(rb"=EDGE_CURVE\('[^']*',(#\d+),(#\d+),(#\d+),", text)
        edges = [(start, end, wanted[curve]) for start, end, curve in edges if curve in wanted]
        for side in (0, 1):
            ends = _triples([points[corner[edge[side]]] for edge in edges])
            np.minimum.at(low, [edge[2] for edge in edges], ends)
    return np.where(np.isfinite(low), low, _triples([vertex for _, vertex in curves]))


def _triples(texts: list[bytes]) -> NDArray[np.float64]:
    return np.array([[float(part) for part in text.split(b",")] for text in texts]).reshape(-1, 3)


def check_text(
    path: Path, found: StepText, film: PrismFilm, solids: dict[str, int]
) -> tuple[Gate, ...]:
    """Return how far parabolas are off those of the film.

    Raises
    ------
    ExportError
        when the file is not in mm, or lacks a product, solid or parabola of the film.
    """
    if found.units != MILLIMETRE:
        raise ExportError(
            f"{path.name}: length units {sorted(found.units)}: expected all millimetres"
        )
    if not set(solids) <= found.products:
        raise ExportError(
            f"{path.name}: products {sorted(found.products)}: expected {sorted(solids)}"
        )
    wanted = sum(solids.values())
    if found.solid_count != wanted:
        raise ExportError(f"{path.name}: {found.solid_count} solids: expected {wanted}")
    return _check_parabolas(path, found, film)


def _check_parabolas(path: Path, found: StepText, film: PrismFilm) -> tuple[Gate, ...]:
    """Compare each parabola's place and curvature with its groove's."""
    vertex = found.vertex
    groove = np.clip((vertex[:, 0] / film.groove.pitch).astype(int), 0, film.groove_count - 1)
    drawn = np.zeros(film.groove_count, bool)
    drawn[groove] = True
    if np.any(drawn != has_solid_parabola(film)):
        index = int(np.argmax(drawn != has_solid_parabola(film)))
        raise ExportError(
            f"{path.name}: groove {index} has {'a' if drawn[index] else 'no'} parabola"
        )
    if len(groove) == 0:
        return ()
    curvature = film.curvature[groove]
    bend = float(np.max(np.abs(found.curvature / curvature - 1)))
    bottom = film.thickness - curvature / 2 * film.groove.half_width**2
    place = np.hypot(vertex[:, 0] - film.groove_position[groove], vertex[:, 2] - bottom).max()
    return (
        Gate("step_curvature_error", bend, CURVATURE_LIMIT, detail=path.name),
        Gate("step_place_error_um", float(place) / um, PLACE_LIMIT / um, detail=path.name),
    )
