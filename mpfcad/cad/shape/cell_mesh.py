"""Films of cells as one closed triangle mesh. Plain numpy.

A pyramid is a stack of square rings, one for each chord of its profile: its faces bend in one
direction only, so long narrow trapezoids are enough. A paraboloid bends in both and gets a grid
whose quadrilaterals are plane, as its height is a sum of one function of x and one of y.
"""

import math

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.shape.mesh import Mesh
from mpfcad.cad.step.outline import drawn_sliver
from mpfcad.errors import InputError
from mpfcad.film import CellFilm
from mpfcad.film.cell import reach_of
from mpfcad.units import deg

#: Most facets of a mesh: more are no use to anyone.
MOST_FACETS = 12_000_000
#: Widest angle [deg] that is proposed: a job allows up to 5.
WIDEST = 5.05


def build_cell_mesh(film: CellFilm, angle_tolerance: float) -> Mesh:
    """Return the film as one closed mesh with facets within `angle_tolerance` [rad] of the surface.

    Raises
    ------
    InputError
        when that takes too many facets: the text says what angle, and how many cells, fit.
    """
    pyramid = film.shape == "pyramid"
    each, cells = _facets_each(film, angle_tolerance), film.count[0] * film.count[1]
    if each * cells > MOST_FACETS:
        wider = math.ceil(angle_tolerance / deg * 10) / 10
        while _facets_each(film, wider * deg) * cells > MOST_FACETS and wider < WIDEST:
            wider += 0.1
        hint = f"{wider:.1f} deg, or " if wider < WIDEST else ""
        raise InputError(
            f"film: {film.count[0]} x {film.count[1]} cells at {angle_tolerance / deg:g} deg: "
            f"{each * cells / 1e6:.3g} million facets: expected at most {MOST_FACETS / 1e6:g} "
            f"million: {hint}{MOST_FACETS // each} cells fit"
        )
    steps = _steps(film, angle_tolerance)
    if not pyramid:
        vertices, top = _dishes(film, *steps)
    elif film.tip_to_tip:
        vertices, top = _valleys(film, *_rings(film, *steps))
    else:
        vertices, top = _pyramids(film, *_rings(film, *steps))
    return close_top(film.size, vertices, _rim(film, vertices), top)


def _share(film: CellFilm) -> float:
    """Return the share of the angle that one direction may use: a dish bends in both."""
    return 1.0 if film.shape == "pyramid" else 1 / math.sqrt(2)


def _facets_each(film: CellFilm, angle_tolerance: float) -> int:
    """Return how many facets a cell's top has, within an angle [rad]."""
    along_x, along_y = (len(steps) for steps in _steps(film, angle_tolerance))
    if film.shape == "pyramid":
        return 8 * (along_x if film.along is None else along_x + along_y)
    return 2 * (2 * along_x - 2) * (2 * along_y - 2)


def _steps(film: CellFilm, angle_tolerance: float) -> tuple[NDArray[np.float64], ...]:
    """Return the chords' ends of the profiles along x and along y, `_profile_steps` of each."""
    return tuple(_profile_steps(film, c, angle_tolerance * _share(film)) for c in film.both)


def _profile_steps(film: CellFilm, curvature: float, angle_tolerance: float) -> NDArray[np.float64]:
    """Return the distances [mm] from the valley, 0 … w, between which the profile is a chord."""
    w = film.groove.half_width
    reach = w
    if film.profile == "filled":
        reach = float(film.groove.contact_position(curvature))
        sliver = drawn_sliver(max(film.size))
        reach = 0.0 if reach < sliver else w if w - reach < sliver else reach
    turn = math.atan(curvature * reach)
    count = max(math.ceil(turn / (2 * angle_tolerance)), 4) if reach > 0 else 0
    if curvature * w < 1e-9:
        return np.array([0.0, w])
    inner = np.tan(np.linspace(0, turn, count + 1)) / curvature if count else np.zeros(1)
    inner[-1] = reach
    return inner if reach == w else np.append(inner, w)


def _rings(
    film: CellFilm, along_x: NDArray[np.float64], along_y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return how far from the valleys along x and along y each ring lies, and its height [mm].

    A ring is the line of one height. Where one profile begins higher than the other, the rings
    below its begin lie on the cell's edge there.
    """
    groove, profile = film.groove, film.profile
    both = zip((along_x, along_y), film.both, strict=True)
    heights = [_drawn_height(film, steps, curvature) for steps, curvature in both]
    if film.along is None or film.along == film.curvature:
        return along_x, along_y, film.base + heights[0]
    z = np.union1d(*heights)
    # Two heights nearer than float32 tells apart are one ring.
    z = z[np.append(np.diff(z) > 2 * np.spacing(np.float32(film.thickness)), True)]
    reach = [groove.half_width * reach_of(groove, profile, c, z) for c in film.both]
    for place, height in zip(reach, heights, strict=True):
        place[z <= height[0]] = 0.0
        place[-1] = groove.half_width
    return reach[0], reach[1], film.base + z


def _drawn_height(
    film: CellFilm, steps: NDArray[np.float64], curvature: float
) -> NDArray[np.float64]:
    """Return the heights [mm] over the bare valley of a profile's chords' ends."""
    height = film.groove.height(steps, curvature, film.profile)
    covered = film.groove.curvature_covered
    if len(steps) == 2 and film.profile == "filled" and curvature > covered:
        height[0] = 0.0  # its resin is merged into the bare walls
    return height


def _pyramids(
    film: CellFilm,
    along_x: NDArray[np.float64],
    along_y: NDArray[np.float64],
    height: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices and top facets of whole pyramids, valleys on the cells' edges."""
    nx, ny = film.count
    pitch, w = film.groove.pitch, film.groove.half_width
    lattice = np.stack(np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="ij"), -1)
    ground = lattice.reshape(-1, 2) * pitch
    rings = len(height) - 2
    middle = (lattice[:-1, :-1].reshape(-1, 2) + 0.5) * pitch
    quarter = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    inner = w - np.stack([along_x, along_y], axis=1)[1:-1]
    ring = (middle[:, None, None] + quarter * inner[:, None]).reshape(-1, 2)
    flat = np.concatenate([ground, ring, middle])
    z = np.concatenate(
        [
            np.full(len(ground), height[0]),
            np.tile(np.repeat(height[1:-1], 4), len(middle)),
            np.full(len(middle), film.thickness),
        ]
    )
    cell = np.arange(len(middle))
    corner = (cell // ny)[:, None] * (ny + 1) + (cell % ny)[:, None]
    first = corner + np.array([0, ny + 1, ny + 2, 1])
    begin = len(ground) + (cell[:, None, None] * rings + np.arange(rings)[:, None]) * 4
    loops = np.concatenate([first[:, None], begin + np.arange(4)], axis=1)
    here, ahead = loops, np.roll(loops, -1, axis=2)
    low = np.stack([here[:, :-1], ahead[:, :-1], ahead[:, 1:]], -1)
    high = np.stack([here[:, :-1], ahead[:, 1:], here[:, 1:]], -1)
    tip = np.broadcast_to((len(ground) + len(ring) + cell)[:, None], here[:, -1].shape)
    cap = np.stack([here[:, -1], ahead[:, -1], tip], -1)
    top = np.concatenate([part.reshape(-1, 3) for part in (low, high, cap)])
    if film.along is not None:
        top = _with_width(flat, top, w)
    return np.column_stack([flat, z]), top


def _with_width(flat: NDArray[np.float64], top: NDArray[np.int64], w: float) -> NDArray[np.int64]:
    """Return the facets that have any area: sides of rings on a cell's edge have none."""
    a, b, c = (flat[top[:, i]] for i in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return top[area > 1e-12 * w**2]


def _valleys(
    film: CellFilm,
    along_x: NDArray[np.float64],
    along_y: NDArray[np.float64],
    height: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices and top facets of one cell with its valleys in the middle.

    A quarter is a ridge from the middle to the tip, and lines of one height from it to both sides.
    """
    w, count = film.groove.half_width, len(height)
    side = np.full(count, w)
    quarter = np.concatenate([
        np.stack([x, y, height], axis=1)
        for x, y in ((along_x, along_y), (along_x, side), (side, along_y))
    ])  # fmt: skip
    low, ahead = np.arange(count - 1), np.arange(1, count)
    facets = np.concatenate([
        np.stack(corners, axis=1)
        for corners in (
            (low, ahead, ahead + count), (low, ahead + count, low + count),
            (low, low + 2 * count, ahead + 2 * count), (low, ahead + 2 * count, ahead),
        )
    ])  # fmt: skip
    points, tops = [], []
    for number, (a, b) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        points.append(quarter * (a, b, 1) + (w, w, 0))
        # A mirror image has its facets the other way round.
        tops.append((facets if a == b else facets[:, ::-1]) + number * len(quarter))
    every = np.concatenate(points)
    vertex, index = np.unique(every.round(12), axis=0, return_inverse=True)
    top = _with_width(vertex[:, :2], index.reshape(-1)[np.concatenate(tops)], w)
    used, top = np.unique(top, return_inverse=True)  # of a ring on the edge there is no far end
    return vertex[used], top.reshape(-1, 3)


def _dishes(
    film: CellFilm, *steps: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the vertices and top facets of dishes, tips on the cells' corners."""
    pitch, w = film.groove.pitch, film.groove.half_width
    local = [np.concatenate([-one[::-1], one[1:]])[:-1] for one in steps]
    lines = [
        np.append((np.arange(n)[:, None] * pitch + w + at).ravel(), n * pitch)
        for n, at in zip(film.count, local, strict=True)
    ]
    drops = [
        np.append(np.tile(curvature / 2 * (w - at) * (w + at), n), 0.0)
        for n, at, curvature in zip(film.count, local, film.both, strict=True)
    ]
    x, y = np.meshgrid(*lines, indexing="ij")
    z = film.thickness - drops[0][:, None] - drops[1][None, :]
    number = np.arange(x.size).reshape(x.shape)
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    top = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), top


def close_top(
    size: tuple[float, float],
    vertices: NDArray[np.floating],
    rim: NDArray[np.int64],
    top: NDArray[np.int64],
) -> Mesh:
    """Return a top with four upright sides, and an underside at z = 0 fanned from its middle.

    `rim` is the top's outermost vertices, anticlockwise from above; `size` [mm] starts at 0, 0.
    """
    count = len(rim)
    start = len(vertices)
    below = vertices[rim] * np.array([1.0, 1.0, 0.0])
    centre = np.array([[size[0] / 2, size[1] / 2, 0.0]])
    foot = start + np.arange(count)
    ahead, next_foot = np.roll(rim, -1), np.roll(foot, -1)
    side = np.concatenate(
        [np.stack([rim, foot, next_foot], 1), np.stack([rim, next_foot, ahead], 1)]
    )
    under = np.stack([next_foot, foot, np.full(count, start + count)], 1)
    everything = np.concatenate([vertices, below, centre]).astype(np.float32)
    return Mesh(everything, np.concatenate([top, side, under]))


def _rim(film: CellFilm, vertices: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the top's outermost vertices, anticlockwise from above."""
    x, y = vertices[:, 0], vertices[:, 1]
    near, far = np.flatnonzero(y == 0), np.flatnonzero(y == film.size[1])
    left, right = np.flatnonzero(x == 0), np.flatnonzero(x == film.size[0])
    return np.concatenate(
        [
            near[np.argsort(x[near])][:-1],
            right[np.argsort(y[right])][:-1],
            far[np.argsort(-x[far])][:-1],
            left[np.argsort(-y[left])][:-1],
        ]
    )
