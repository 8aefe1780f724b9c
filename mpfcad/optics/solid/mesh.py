"""Reads a film mesh from a file and makes sure that it can be traced as a repeating tile.

The tracer starts from the file alone. It asks for a closed, outward oriented mesh whose opposite
sides match: then the film continues beyond its edges as copies of itself, and what happens between
lamps far from the panel's rim is traced without one. Overhangs, voids and several bodies are as
good as one height over a flat underside.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import reads
from mpfcad.errors import InputError
from mpfcad.optics.solid.closed import at, check_solid, find_fault
from mpfcad.optics.solid.file import read_solid

#: Heights of films [mm], so that coordinates in µm or m are not taken for mm.
_HEIGHT = (0.001, 20.0)
#: Heights [mm] of films that are sold, and of what is read as mm without a question.
_USUAL, _UNASKED = (0.05, 0.7), (0.012, 3.0)
_NO_UNIT = ("STL", "binary STL", "PLY", "OBJ")
_OTHER = {"µm": 1e-3, "inch": 25.4, "mil": 0.0254, "m": 1e3, "cm": 10.0}


@dataclass(frozen=True, eq=False)
class FilmMesh:
    """A film tile as triangles.

    Attributes
    ----------
    vertex
        (v, 3) float64 [mm], moved so that the tile spans x 0…width, y 0…length, z 0…thickness
    top
        (t, 3) int64, vertex numbers of the facets that are neither underside nor side
    size
        (width, length, thickness) [mm]
    underside
        whether a flat underside at z = 0 closes the film over the whole tile; if not, `top` has all
        facets but the sides
    note
        in a line what was read, and what is doubtful of it
    """

    vertex: NDArray[np.float64]
    top: NDArray[np.int64]
    size: tuple[float, float, float]
    underside: bool = True
    note: str = ""

    @property
    def used(self) -> NDArray[np.bool_]:
        """Which vertices `top` has, (v,)."""
        used = np.zeros(len(self.vertex), bool)
        used[self.top] = True
        return used


@reads("a mesh or STEP file")
def read_film_mesh(path: Path) -> FilmMesh:
    """Return the film tile of a mesh or STEP file (coordinates in mm where it states no unit).

    Raises
    ------
    InputError
        when the file is missing or of no format that is read, or the mesh is open, inverted,
        touches itself or does not repeat from side to side; the text names the place.
    """
    path = Path(path)
    solid = read_solid(path)
    fault = find_fault(solid.vertex, solid.facet)
    if fault:
        solid = solid.last_steps_joined()
        check_solid(path, solid.vertex, solid.facet)
    mesh = film_of(path, solid.vertex, solid.facet)
    note = solid.summary(path)
    if not mesh.underside and is_flat_above(mesh):
        note += "; the film lies upside down: its flat side is up, and is traced so"
    high = mesh.size[2]
    if solid.kind.startswith(_NO_UNIT) and not _UNASKED[0] <= high <= _UNASKED[1]:
        note += f"; {high:.4g} mm high, taken as mm{_other_unit(high)}"
    return replace(mesh, note=note)


def _other_unit(height: float) -> str:
    """Return in which units a film's height [mm], as read, would be that of films as sold."""
    found = [
        f"in {name} it would be {height * factor:.3g} mm"
        for name, factor in _OTHER.items()
        if _USUAL[0] <= height * factor <= _USUAL[1]
    ]
    return f": {' or '.join(found)}: write it in mm" if found else ""


def film_of(path: Path, vertex: NDArray[np.float64], facet: NDArray[np.int64]) -> FilmMesh:
    """Return the film tile that the facets of a solid are.

    Raises
    ------
    InputError
        when it is no film or does not repeat from side to side; the text names the place.
    """
    low, high = vertex.min(axis=0), vertex.max(axis=0)
    vertex = vertex - low
    size = high - low
    if not (size > 0).all():
        raise InputError(f"{path}: mesh: extent {tuple(size)} mm: expected a solid")
    if not _HEIGHT[0] <= size[2] <= _HEIGHT[1]:
        raise InputError(
            f"{path}: mesh: {size[2]:g} mm high: expected {_HEIGHT[0]:g} to {_HEIGHT[1]:g} mm: "
            f"coordinates are in mm{_other_unit(float(size[2]))}"
        )
    whole = (float(size[0]), float(size[1]), float(size[2]))
    sides = [_lies_in(vertex, facet, axis, plane) for axis in (0, 1) for plane in (0.0, size[axis])]
    under = _lies_in(vertex, facet, 2, 0.0)
    underside = _covers(vertex, facet[under], size)
    traced = ~np.any(sides, axis=0)
    if underside:
        traced &= ~under
    top = facet[traced]
    for axis in (0, 1):
        rims = [_rim(facet[sides[2 * axis + i]], top, len(vertex)) for i in (0, 1)]
        _check_repeats(path, vertex, axis, size[axis], rims)
        for plane, rim in zip((0.0, size[axis]), rims, strict=True):
            _check_apart(path, vertex, axis, plane, top, rim)
    if underside:
        _check_above(path, vertex, top)
    return FilmMesh(vertex, top, whole, underside)


def is_flat_above(mesh: FilmMesh) -> bool:
    """Tell whether a film of any underside has a flat upper side over its whole tile."""
    size = np.array(mesh.size)
    above = mesh.top[_lies_in(mesh.vertex, mesh.top, 2, size[2])]
    return _covers(mesh.vertex, above, size)


def _lies_in(
    vertex: NDArray[np.float64], facet: NDArray[np.int64], axis: int, plane: float
) -> NDArray[np.bool_]:
    """Return which facets lie in the plane where a coordinate is `plane` [mm]."""
    return (vertex[:, axis] == plane)[facet].all(axis=1)


def _covers(
    vertex: NDArray[np.float64], under: NDArray[np.int64], size: NDArray[np.float64]
) -> bool:
    """Return whether flat facets fill the rectangle of the tile."""
    corner = vertex[under]
    area = np.abs(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2]).sum()
    return bool(abs(area / 2 - size[0] * size[1]) <= 1e-6 * size[0] * size[1])


def _rim(side: NDArray[np.int64], top: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return the edges (n, 2) of a side, as its facets run, beyond which a traced facet lies."""
    edges = (facet.ravel() * count + np.roll(facet, -1, axis=1).ravel() for facet in (side, top))
    along, across = edges
    back = across % count * count + across // count
    rim = np.intersect1d(along, back, assume_unique=True)
    return np.stack([rim // count, rim % count], axis=1)


def _check_repeats(
    path: Path, vertex: NDArray[np.float64], axis: int, size: float, rims: list[NDArray[np.int64]]
) -> None:
    """Raise unless opposite sides of the tile end along the same lines, the film within both."""
    lines = [vertex[rim][..., (1 - axis, 2)].reshape(-1, 4) for rim in (rims[0], rims[1][:, ::-1])]
    ordered = [line[np.lexsort(line.T)] for line in lines]
    if ordered[0].shape == ordered[1].shape and (ordered[0] == ordered[1]).all():
        return
    rows = [np.ascontiguousarray(line).view([("", float)] * 4).ravel() for line in lines]
    only = [np.setdiff1d(rows[i], rows[1 - i]) for i in (0, 1)]
    for i, left_over in enumerate(only):
        if len(left_over):
            name = "xy"[axis]
            place = np.full(3, (0.0, size)[i])
            a = np.array(left_over[0].tolist())
            place[[1 - axis, 2]] = (a[:2] + a[2:]) / 2
            raise InputError(
                f"{path}: mesh: the surface at {name} = 0 and {name} = {size:g} mm differs at "
                f"{at(place)}: the tile must repeat from side to side"
            )


def _check_apart(
    path: Path, vertex: NDArray[np.float64], axis: int, plane: float,
    top: NDArray[np.int64], rim: NDArray[np.int64],
) -> None:  # fmt: skip
    """Raise where a body only just reaches a side of the tile, and so touches its own copy."""
    lone = np.zeros(len(vertex), bool)
    lone[top] = True
    lone &= vertex[:, axis] == plane
    lone[rim] = False
    alone = np.flatnonzero(lone)
    if len(alone):
        raise InputError(
            f"{path}: mesh: touches its copy in the next tile at {at(vertex[alone[0]])}: "
            "bodies must end within the tile or go on beyond it"
        )


def _check_above(path: Path, vertex: NDArray[np.float64], top: NDArray[np.int64]) -> None:
    """Raise where the upper surface touches the flat underside."""
    corner = vertex[top]
    thin = corner[..., 2] == 0
    if thin.any():
        raise InputError(
            f"{path}: mesh: touches itself at {at(corner[thin][0])}: "
            "the upper surface must lie above the underside"
        )
