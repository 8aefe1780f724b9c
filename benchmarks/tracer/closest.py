"""Closest hits by the tree, beside Embree."""

import numpy as np
from harness import CONCAVE, film_file

from tracer.mesh import pyramids
from tracer.race import entry, spent
from tracer.single_ray_scene import embree_closest

GROOVES, PANEL = 654, 7846
CELLS, FIELD = 200, 400
RAYS = 200_000


def closest_rows(folder, quick, present):
    if not present["embreex"]:
        yield entry("closest hit by the tree, beside Embree: absent", None, "k/s")
        return
    film = film_file(folder / "panel.stl", [CONCAVE] * (GROOVES if quick else PANEL), length=20.0)
    field = pyramids(folder / "pyramids.stl", CELLS if quick else FIELD)
    for name, path in (("film", film), ("pyramids", field)):
        yield from _rows(name, path)


def _rows(name, path):
    """Yield the rates of both for rays from all over the underside, and how many hits agree."""
    from mpfcad.optics.search.bvh.build import build_bvh
    from mpfcad.optics.search.bvh.walk import closest_facets
    from mpfcad.optics.solid.mesh import read_film_mesh

    mesh = read_film_mesh(path)
    tree = build_bvh(mesh)
    middle = [mesh.size[0] / 2, mesh.size[1] / 2, 0.0]
    peer = embree_closest(mesh.vertex - middle, mesh.top)
    random = np.random.default_rng(1).random((RAYS, 4))
    origin = random[:, :3] * [mesh.size[0], mesh.size[1], 0.0]
    k, phi = np.sqrt(random[:, 2]), 2 * np.pi * random[:, 3]
    direction = np.stack([k * np.cos(phi), k * np.sin(phi), np.sqrt(1 - k * k)], axis=1)
    local, narrow = (origin - middle).astype(np.float32), direction.astype(np.float32)
    hits = np.empty(RAYS, np.int64)
    closest_facets(tree, origin[:10], direction[:10], hits[:10])
    best = [0.0, 0.0]
    for _ in range(10):
        _, cpu = spent(closest_facets, tree, origin, direction, hits)
        best[0] = max(best[0], RAYS / cpu / 1e3)
        theirs, cpu = spent(peer, local, narrow)
        best[1] = max(best[1], RAYS / cpu / 1e3)
    # Ours repeats beyond the sides, where theirs ends.
    alike = (hits == theirs)[theirs >= 0].mean()
    title = f"closest hit by the tree, {len(mesh.top)} facets ({name}), beside Embree's robust rays"
    yield entry(title, best[0], "k/s", peer=best[1], ratio=best[0] / best[1], goal=0.9,
                same=alike > 0.999)  # fmt: skip
    yield entry("    share of their hits that are ours", alike, "")
