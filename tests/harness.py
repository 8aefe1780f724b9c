"""What the tracer's tests share: small film meshes on disk, and single paths."""

from pathlib import Path

import numpy as np
from manifold3d import triangulate
from numba import njit, uint64

from mpfcad.optics import sheet, slab
from mpfcad.optics.base.kernel import FLAVOUR
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE, disk, start_path
from mpfcad.optics.bsdf.passage import bsdf_passage
from mpfcad.optics.caught import NO_NET
from mpfcad.optics.element import BSDF, SHEET, SLAB, TABLE
from mpfcad.optics.engine import trace_paths
from mpfcad.optics.film.passage import (
    ABSORPTION,
    INDEX,
    INDEX_BELOW,
    RESIN_ABSORPTION,
    film_passage,
    placed_film_passage,
)
from mpfcad.optics.lowering import COLUMNS
from mpfcad.optics.search.tile import build_tile
from mpfcad.optics.search.tile_table import build_tile_table
from mpfcad.optics.slab import slab_passage
from mpfcad.optics.solid.mesh import FilmMesh, read_film_mesh
from mpfcad.optics.stokes.engine import trace_polarised
from mpfcad.optics.stokes.state import LIGHT_SHAPE, ROWS
from mpfcad.optics.wave import Wave
from mpfcad.store.kernel import kept

PITCH, DEPTH, HALF = 0.050, 0.025, 0.025

#: The films of the reference figures [mm]: 150 µm below the valleys, tips 25 µm above them.
BARE = (np.array([-HALF, 0.0, HALF]), np.array([DEPTH, 0.0, DEPTH]))
_BOW = np.linspace(-0.04 / 3, 0.04 / 3, 23)
CONCAVE = (np.r_[-HALF, _BOW, HALF], np.r_[DEPTH, 0.008 + 30 * _BOW**2, DEPTH])


_FLOOR = np.linspace(-0.018, 0.018, 13)
#: A groove that is wider below than at its mouth, between lands.
REENTRANT = (
    np.r_[-HALF, -0.012, _FLOOR, 0.012, HALF],
    np.r_[DEPTH, DEPTH, 0.005 + 20 * (_FLOOR**2 - 0.018**2), DEPTH, DEPTH],
)


def groove(curvature: float, profile: str = "filled", chords: int = 24):
    """Return (x, z) of a groove whose parabola has C [1/mm] through the tips, x from -w to w."""
    contact = HALF
    if profile == "filled":
        contact = min(HALF, max(0.0, 2 / max(curvature, 1e-9) - HALF))
    if contact < 1e-7:
        return BARE
    x = np.linspace(-contact, contact, chords + 1)
    z = DEPTH - curvature / 2 * (HALF - x) * (HALF + x)
    if contact < HALF:
        x, z = np.r_[-HALF, x, HALF], np.r_[DEPTH, z, DEPTH]
    return x, z


def row(grooves, base: float):
    """Return (x, z) of grooves side by side on a base, from x = 0."""
    x = [g[0][:-1] + HALF + i * PITCH for i, g in enumerate(grooves)]
    z = [g[1][:-1] + base for g in grooves]
    return np.r_[np.concatenate(x), len(grooves) * PITCH], np.r_[np.concatenate(z), base + DEPTH]


def extruded(x, z, length: float) -> np.ndarray:
    """Return the facets (n, 3, 3) of the solid under the polyline z(x), drawn along y."""
    n = len(x)
    points = np.array([[(a, y, b) for a, b in zip(x, z, strict=True)] for y in (0.0, length)])
    ground = points * (1.0, 1.0, 0.0)
    facets = []

    def quad(a, b, c, d):
        facets.extend([(a, b, c), (a, c, d)])

    for i in range(n - 1):
        (p, q), (r, s) = points[:, i], points[:, i + 1]
        (e, f), (g, h) = ground[:, i], ground[:, i + 1]
        quad(p, r, s, q)
        quad(e, f, h, g)
        quad(e, g, r, p)
        quad(f, q, s, h)
    quad(ground[0, 0], points[0, 0], points[1, 0], ground[1, 0])
    quad(ground[0, -1], ground[1, -1], points[1, -1], points[0, -1])
    return np.array(facets)


def drawn(rings, length: float) -> np.ndarray:
    """Return the facets (n, 3, 3) of a cross-section drawn along y.

    rings: (n, 2) corners x, z each, anticlockwise about film, clockwise about air.
    """
    rings = [np.asarray(ring, float) for ring in rings]
    facets = []
    for ring in rings:
        for p, q in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            near, far = [[(a, y, b) for a, b in (p, q)] for y in (0.0, length)]
            facets += [(near[1], near[0], far[0]), (near[1], far[0], far[1])]
    flat = np.concatenate(rings)
    for face in triangulate(rings):
        a, b, c = flat[face]
        facets.append([(*v[:1], 0.0, v[1]) for v in (a, b, c)])
        facets.append([(*v[:1], length, v[1]) for v in (a, c, b)])
    return np.array(facets)


def write_facets(path: Path, facets) -> Path:
    """Write a binary STL; no normals, as readers must not need them."""
    facets = np.asarray(facets, "<f4")
    record = np.zeros(len(facets), [("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    record["v"] = facets
    path.write_bytes(b" " * 80 + np.uint32(len(facets)).tobytes() + record.tobytes())
    return path


def film_file(path: Path, grooves, base: float = 0.15, length: float = 0.1) -> Path:
    """Write a tile of grooves."""
    return write_facets(path, extruded(*row(grooves, base), length))


def _circle(x, z, radius, corners):
    angle = 2 * np.pi * np.arange(corners) / corners
    return np.stack([x + radius * np.cos(angle), z + radius * np.sin(angle)], axis=1)


_UNDERCUT = [(0, 0), (0.1, 0), (0.1, 0.2), (0.06, 0.2), (0.08, 0.16), (0.075, 0.155), (0.03, 0.15),
             (0.02, 0.16), (0.04, 0.2), (0, 0.2)]  # fmt: skip
_ROD = _circle(0.05, 0.176, 0.01, 24)
_SHEET = [(0, 0), (0.1, 0), (0.1, 0.1), (0, 0.1)]
_PRISM = [(0, 0.13), (0.1, 0.13), (0.1, 0.15), (0.07, 0.178), (0.03, 0.15), (0, 0.15)]
_BELOW = [(0, 0.03), (0.025, 0), (0.05, 0.028), (0.08, 0.005), (0.1, 0.03), (0.1, 0.2), (0, 0.2)]

#: Cross-sections 0.1 mm wide that are no height over a flat underside, as `drawn` takes them.
#: In the film over the rods some light is guided over thousands of reflections.
SECTIONS = {
    "undercut": [_UNDERCUT],
    "rod in an undercut over a void": [_UNDERCUT, _ROD, _circle(0.03, 0.08, 0.02, 40)[::-1]],
    "sheet under a film": [_SHEET, _PRISM],
    "grooves below": [_BELOW],
    "rods under grooves": [_BELOW, _circle(0.05, -0.05, 0.04, 50), _circle(0.02, -0.1, 0.017, 33)],
}


def section_mesh(folder: Path, name: str, length: float = 0.1) -> FilmMesh:
    """Return one of `SECTIONS`, read from disk."""
    return read_film_mesh(write_facets(folder / "section.stl", drawn(SECTIONS[name], length)))


def film_mesh(folder: Path, grooves, base: float = 0.15, length: float = 0.1) -> FilmMesh:
    """Return a tile of grooves, read from disk as the tracer reads it."""
    return read_film_mesh(film_file(folder / "film.stl", grooves, base, length))


def even_pyramids(folder: Path) -> FilmMesh:
    """Return a tile of four equal upright pyramids of 50 µm, 25 µm high, on 150 µm."""
    return crossed_mesh(folder, height=0.025, lean=0.0, fall=0.0)


def crossed_mesh(
    folder: Path, size: float = 0.1, height: float = 0.03, base: float = 0.15,
    lean: float = 0.05, fall: float = 0.2,
):  # fmt: skip
    """Return a tile that is no extrusion: four leaning pyramids of different height on a base."""
    cells = 2
    side = size / cells
    facets = []
    for i in range(cells):
        for j in range(cells):
            corner = [
                ((i + a) * side, (j + b) * side, base) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))
            ]
            tip = base + height * (1 - fall * (i + 2 * j))
            top = ((i + 0.5) * side, (j + 0.5 - lean) * side, tip)
            facets += [(corner[k], corner[(k + 1) % 4], top) for k in range(4)]
    # Underside and sides with the top's edge vertices, so that every edge has one partner.
    steps = np.linspace(0, size, cells + 1)
    rim = [(s, 0.0) for s in steps[:-1]] + [(size, s) for s in steps[:-1]]
    rim += [(s, size) for s in steps[:0:-1]] + [(0.0, s) for s in steps[:0:-1]]
    centre = (size / 2, size / 2, 0.0)
    for a, b in zip(rim, rim[1:] + rim[:1], strict=True):
        p, q = (*a, 0.0), (*b, 0.0)
        r, s = (*a, base), (*b, base)
        facets += [(centre, q, p), (p, q, s), (p, s, r)]
    return read_film_mesh(write_facets(folder / "crossed.stl", facets))


def net_mesh(lines, z) -> FilmMesh:
    """Return the tile over a square net of n `lines` [mm] with the heights z (n, n) [mm]."""
    lines, z = (np.float32(v).astype(float) for v in (lines, z))
    x, y = np.meshgrid(lines, lines, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    top = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    vertex = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    return FilmMesh(vertex, top, (float(lines[-1]), float(lines[-1]), float(z.max())))


def dish_mesh(cells: int = 2, chords: int = 6) -> FilmMesh:
    """Return a tile of dishes of 50 µm, their tips on the cells' corners."""
    local = HALF * np.sin(np.linspace(-np.pi / 2, np.pi / 2, chords + 1))
    start = np.arange(cells)[:, None] * PITCH + HALF
    lines = np.append((start + local[:-1]).ravel(), cells * PITCH)
    drop = np.append(np.tile(20 * (HALF**2 - local[:-1] ** 2), cells), 0.0)
    return net_mesh(lines, 0.175 - drop[:, None] - drop)


def pillar_mesh() -> FilmMesh:
    """Return a tile of 3 by 3 squares of 50 µm, the middle one raised on upright walls."""
    step, low, high = np.float32([0, 0.05, 0.1, 0.15]).astype(float), 0.15, 0.175
    facets = []

    def quad(*p):
        facets.extend([(p[0], p[1], p[2]), (p[0], p[2], p[3])])

    for i in range(3):
        for j in range(3):
            z = high if i == j == 1 else low
            around = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
            ring = [(step[a], step[b], z) for a, b in around]
            quad(*ring)
            if z == high:
                foot = [(*p[:2], low) for p in ring]
                for k in range(4):
                    quad(foot[k], foot[(k + 1) % 4], ring[(k + 1) % 4], ring[k])
    vertex, top = np.unique(np.reshape(facets, (-1, 3)), axis=0, return_inverse=True)
    return FilmMesh(vertex, top.reshape(-1, 3), (float(step[-1]), float(step[-1]), high))


def single_paths(scene, source, seed, first, out, flow):
    """Put the radiance of paths first, first+1 … into out; add their flows to flow (f,)."""
    wave = Wave.empty(len(scene.kind), len(source.position))
    trace_paths(
        scene, source, np.uint64(seed), np.uint64(source.kind), np.uint64(first), wave, out, flow,
        NO_NET,
    )  # fmt: skip


def compiled(kernel):
    """Return a kernel as a function that Python can call."""
    return kept(njit(error_model="numpy", _nrt=False)(kernel.py_func), f"{FLAVOUR} alone")


@kept
@njit
def pass_layers(scene, enter_below, seed, out):
    """Send Lambertian light into a scene without cavity; out (n, 4): way, kx, ky, weight."""
    rng = np.zeros(RNG_SIZE, np.uint64)
    count = len(scene.kind)
    for i in range(len(out)):
        start_path(rng, uint64(seed), uint64(7), uint64(i))
        dx, dy = disk(rng)
        dz = np.sqrt(max(0.0, 1.0 - dx * dx - dy * dy))
        x, y = 0.37 * scene.tiles.size[0, 0], 0.41 * scene.length
        shift_x, shift_y = disk(rng)
        x, y = x + 7.0 * shift_x, y + 7.0 * shift_y
        up, e, weight = True, 0, 1.0
        if not enter_below:
            up, e, dz = False, count - 1, -dz
        while 0 <= e < count:
            way = 1
            p = scene.parameter[e]
            if scene.kind[e] == SLAB:
                way, x, y, dx, dy, dz, travelled = slab_passage(
                    scene.phase, p, up, x, y, dx, dy, dz, None, None, rng
                )
                weight *= np.exp(-p[slab.ABSORPTION] * travelled)
            elif scene.kind[e] == SHEET:
                passed, dx, dy, dz = sheet.sheet_passage(p, dx, dy, dz, None, rng)
                weight *= p[sheet.TRANSMISSION]
                way = 1 if passed == up else -1
            elif scene.kind[e] == BSDF:
                passed, dx, dy, dz, kept = bsdf_passage(scene.bsdf, int(p[TABLE]), dx, dy, dz, rng)
                weight *= kept
                way = 1 if passed == up else -1
            else:
                way, x, y, dx, dy, dz, travelled, soaked = placed_film_passage(
                    scene.tiles, scene.phase, p, up, x, y, dx, dy, dz, None, rng
                )
                weight *= np.exp(-p[ABSORPTION] * travelled - p[RESIN_ABSORPTION] * soaked)
            if way == 0:
                break
            up = way > 0
            e += way
        out[i, 0] = 0.0 if 0 <= e < count else (1.0 if up else -1.0)
        out[i, 1], out[i, 2], out[i, 3] = dx, dy, weight


@kept
@njit
def pass_film(tiles, index, up, start, seed, out):
    """Send given rays (n, 5: x, y, dx, dy, dz) through a film; out (n, 4): way, dx, dy, dz."""
    rng = np.zeros(RNG_SIZE, np.uint64)
    film = np.zeros(COLUMNS)
    film[INDEX], film[INDEX_BELOW] = index, 1.0
    phase = np.zeros((1, 2))
    for i in range(len(start)):
        start_path(rng, uint64(seed), uint64(8), uint64(i))
        x, y, dx, dy, dz = start[i, 0], start[i, 1], start[i, 2], start[i, 3], start[i, 4]
        way, x, y, dx, dy, dz, _, _ = film_passage(
            tiles, phase, film, up, x, y, dx, dy, dz, None, rng
        )
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = way, dx, dy, dz


def rays(count: int, up: bool, seed: int = 1, size=(0.1, 0.1)) -> np.ndarray:
    """Return Lambertian rays (n, 5: x, y, dx, dy, dz) over a tile."""
    rng = np.random.default_rng(seed)
    k = np.sqrt(rng.random(count)) * 0.999999
    angle = 2 * np.pi * rng.random(count)
    out = np.empty((count, 5))
    out[:, :2] = rng.random((count, 2)) * size
    out[:, 2], out[:, 3] = k * np.cos(angle), k * np.sin(angle)
    out[:, 4] = np.sqrt(1 - k * k) * (1 if up else -1)
    return out


def edge_rays(mesh, up) -> np.ndarray:
    """Return rays (n, 5) at the vertices of an extruded film and along its edges."""
    vertex = np.unique(mesh.vertex[np.unique(mesh.top)][:, 0])
    x = np.concatenate([vertex, vertex, (vertex[1:] + vertex[:-1]) / 2, [-0.0, mesh.size[0]]])
    sign = 1.0 if up else -1.0
    cases = []
    for d in (
        (0.0, 0.0, 1.0),  # exactly vertical: along the edges of an upright wall, through vertices
        (0.0, -0.0, 1.0),
        (0.0, 0.8, 0.6),  # in the plane of the edges along y
        (0.6, 0.0, 0.8),
        (np.sqrt(0.5), 0.0, np.sqrt(0.5)),  # along the faces of 90° prisms
        (-np.sqrt(0.5), 0.0, np.sqrt(0.5)),
        (1.0, 0.0, 1e-9),  # grazing
        (1e-300, 1e-300, 1.0),
    ):
        for y in (0.0, mesh.size[1], 0.05):
            cases += [(a, y, d[0], d[1], sign * d[2]) for a in x]
    return np.array(cases)


def aimed(mesh, up, count=4000):
    """Return rays (n, 5) whose first way ends at a vertex or on an edge."""
    rng = np.random.default_rng(7)
    corner = mesh.vertex[mesh.top[rng.integers(len(mesh.top), size=count)]]
    along = np.where(rng.random(count) < 0.5, 0.0, rng.random(count))[:, None]
    target = corner[:, 0] + along * (corner[:, 1] - corner[:, 0])
    start = rays(count, up, seed=8)
    flight = start[:, 2:].copy()
    if up and mesh.underside:
        flight[:, :2] /= 1.5
        flight[:, 2] = np.sqrt(1 - (flight[:, :2] ** 2).sum(axis=1))
    z = 0.0 if up else mesh.vertex[mesh.used, 2].max()
    start[:, :2] = (target + ((z - target[:, 2]) / flight[:, 2])[:, None] * flight)[:, :2]
    return start


def through(mesh, start, up, accelerator=None, index=1.5, seed=1) -> np.ndarray:
    """Return way and direction (n, 4) of rays that have passed a film."""
    out = np.empty((len(start), 4))
    pass_film(build_tile_table([build_tile(mesh, accelerator)]), index, up, start, seed, out)
    return out


def within(value, expected, error, sigmas: float, what: str = "") -> None:
    """Assert that a figure lies within a number of its standard errors."""
    away = np.abs(np.asarray(value) - expected) / error
    assert np.max(away) <= sigmas, f"{what}: {value} against {expected}: {np.max(away):.1f} sigma"


def polarised_paths(scene, source, seed, count, first=0) -> np.ndarray:
    """Return I, Q, U, V of paths first, first+1 …, (n, 4), of a meter of one point."""
    stokes, flow = np.empty((count, ROWS)), np.zeros(len(FLOWS) + len(scene.kind))
    trace_polarised(
        scene, source, np.uint64(seed), np.uint64(source.kind), np.uint64(first),
        np.zeros(LIGHT_SHAPE), np.zeros(RNG_SIZE, np.uint64), stokes, flow,
    )  # fmt: skip
    return stokes
