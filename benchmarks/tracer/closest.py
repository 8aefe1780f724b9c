"""Closest hits by the tree, beside Embree."""

import numpy as np
from harness import CONCAVE, film_file

from tracer.race import entry, spent
from tracer.single_ray_scene import embree_closest

GROOVES, PANEL = 654, 7846


def closest_rows(folder, quick, present):
    from mpfcad.optics.bvh import build_bvh, closest_facets
    from mpfcad.optics.mesh import read_film_mesh

    path = film_file(folder / "panel.stl", [CONCAVE] * (GROOVES if quick else PANEL), length=20.0)
    name = "closest hit by the tree, beside Embree's robust single rays"
    if not present["embreex"]:
        yield entry(f"{name}: absent", None, "k/s")
        return
    mesh = read_film_mesh(path)
    tree = build_bvh(mesh)
    vertex, facet = mesh.vertex, mesh.top
    peer = embree_closest(vertex - [mesh.size[0] / 2, mesh.size[1] / 2, 0.0], facet)
    random = np.random.default_rng(1).random((200_000, 4))
    origin = random[:, :3] * [mesh.size[0], mesh.size[1], 0.0]
    k, phi = np.sqrt(random[:, 2]), 2 * np.pi * random[:, 3]
    direction = np.stack([k * np.cos(phi), k * np.sin(phi), np.sqrt(1 - k * k)], axis=1)
    local = (origin - [mesh.size[0] / 2, mesh.size[1] / 2, 0.0]).astype(np.float32)
    narrow = direction.astype(np.float32)
    hits = np.empty(len(origin), np.int64)
    closest_facets(tree, origin[:10], direction[:10], hits[:10])
    best = [0.0, 0.0]
    for _ in range(3):
        _, cpu = spent(closest_facets, tree, origin, direction, hits)
        best[0] = max(best[0], len(hits) / cpu / 1e3)
        _, cpu = spent(peer, local, narrow)
        best[1] = max(best[1], len(hits) / cpu / 1e3)
    yield entry(name, best[0], "k/s", peer=best[1], ratio=best[0] / best[1], goal=0.9)
