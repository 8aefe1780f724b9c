"""Meshes of films beside the job's: plain prisms, lens arrays, composites of bonded films [mm]."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.units import um

#: Facets from a lens' middle to its corner; even, so that middles are corners of facets.
_STEPS = 16


def made_mesh(kind: str, words: str, value: Callable[[str], float]) -> FilmMesh:
    """Return the mesh of a film that its layer's values describe; `value` gives one by its name.

    Raises
    ------
    InputError
        beginning with `words`, when there is no such film.
    """

    def size(*keys: str) -> list[float]:
        return [value(f"{key}_um") * um for key in keys]

    if kind == "bef":
        return bef_mesh(*size("pitch", "depth", "base"))
    if kind == "lens":
        return lens_mesh(words, *size("pitch", "sag", "base"))
    pitch, depth, base, bond, cover = size("pitch", "depth", "base", "bond", "cover")
    upper_pitch, upper_depth = size("upper_pitch", "upper_depth")
    return composite_mesh(words, pitch, depth, base, bond, cover, (upper_pitch, upper_depth))


def bef_mesh(pitch: float, depth: float, base: float) -> FilmMesh:
    """Return one groove of a plain prism film, from tip to tip."""
    x = np.tile([0.0, pitch / 2, pitch], 2)
    z = np.tile([base + depth, base, base + depth], 2)
    vertex = np.stack([x, np.repeat([0.0, pitch], 3), z], axis=1)
    top = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    return FilmMesh(vertex, top, (pitch, pitch, base + depth))


def lens_mesh(name: str, pitch: float, sag: float, base: float) -> FilmMesh:
    """Return spherical lenses in hexagons side by side, two of them in a tile of pitch by √3 pitch.

    A lens is `sag` high over the corners of its hexagon, pitch/√3 from its middle. Corners of
    facets lie on the sphere, in a net of triangles that has the hexagons' sides among its lines.

    Raises
    ------
    InputError
        when a lens is more than half a sphere.
    """
    reach = pitch / math.sqrt(3)
    if sag > reach:
        raise InputError(
            f"{name}: sag_um: {sag / um:g}: expected at most half a sphere, {reach / um:.6g}"
        )
    radius = (reach**2 + sag**2) / (2 * sag)
    length, rows = math.sqrt(3) * pitch, 3 * _STEPS
    step = length / rows
    even = np.arange(rows + 1) * step
    odd = np.concatenate([[0.0], (np.arange(rows) + 0.5) * step, [length]])
    centre = np.array([(a * pitch, b * length) for a, b in ((0, 0), (1, 0), (0, 1), (1, 1))])
    centre = np.vstack([centre, [pitch / 2, length / 2]])

    def column(i: int) -> NDArray[np.float64]:
        x, y = i * pitch / (2 * _STEPS), odd if i % 2 else even
        # The ends of an odd column halve an upright side of facets, whose ends are equally high.
        at = np.clip(y, step / 2, length - step / 2) if i % 2 else y
        away = np.hypot(x - centre[:, :1], at - centre[:, 1:]).min(axis=0)
        z = base + sag - radius + np.sqrt(radius**2 - np.minimum(away, reach) ** 2)
        return np.stack([np.full_like(y, x), y, z], axis=1)

    columns = [column(i) for i in range(2 * _STEPS + 1)]
    start = np.cumsum([0, *map(len, columns)])
    strips = [_strip(start[i], start[i + 1], rows, i % 2 == 1) for i in range(2 * _STEPS)]
    vertex = np.concatenate(columns)
    return FilmMesh(vertex, np.concatenate(strips), (pitch, length, base + sag))


def _strip(left: int, right: int, rows: int, is_odd: bool) -> NDArray[np.int64]:
    """Return the facets between two columns of which the left or the right one is odd."""
    even, odd = (right, left) if is_odd else (left, right)
    j = np.arange(rows + 1)
    facets = np.concatenate(
        [
            np.stack([even + j, odd + j, odd + j + 1], axis=1),
            np.stack([even + j, odd + j + 1, even + j + 1], axis=1)[:-1],
        ]
    )
    return facets[:, ::-1] if is_odd else facets


def composite_mesh(
    name: str, pitch: float, depth: float, base: float, bond: float, cover: float,
    upper: tuple[float, float],
) -> FilmMesh:  # fmt: skip
    """Return a prism film whose tips stand `bond` deep in the underside of a cover.

    The cover lies over the bond `cover` thick, with prisms across the lower ones on it, (pitch,
    depth), or flat where that depth is 0. All is of one index; what is left of the grooves is air.

    Raises
    ------
    InputError
        when the tips do not stand in the bond, or go through the cover.
    """
    if not 0 < bond < depth:
        raise InputError(
            f"{name}: bond_um: {bond / um:g}: expected above 0 and below depth_um, {depth / um:g}"
        )
    if cover <= bond:
        raise InputError(f"{name}: cover_um: {cover / um:g}: expected above bond_um, {bond / um:g}")
    low, high, half = base + depth - bond, base + depth - bond + cover, pitch / 2
    wide, length = half * (1 - bond / depth), upper[0]
    # The air's prism, seen along y: valley, left and right under the bond.
    hole = [(half, base), (half - wide, low), (half + wide, low)]
    vertex = [(x, y, z) for y in (0.0, length) for x, z in hole]
    facets = [(0, 3, 4), (0, 4, 1), (0, 2, 5), (0, 5, 3), (1, 4, 5), (1, 5, 2)]
    # Flat above, it is drawn along y as a whole.
    rise = [upper[1], 0.0, upper[1]] if upper[1] > 0 else [0.0, 0.0]
    steps, first = len(rise), len(vertex)
    along = np.linspace(0.0, length, steps)
    vertex += [(x, y, high + z) for x in (0.0, pitch) for y, z in zip(along, rise, strict=True)]
    for i in range(first, first + steps - 1):
        facets += [(i, i + steps, i + steps + 1), (i, i + steps + 1, i + 1)]
    return FilmMesh(np.array(vertex), np.array(facets), (pitch, length, high + upper[1]))
