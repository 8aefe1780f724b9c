"""Solids of boxes and of outlines drawn along y, sound and not, for the tests of meshes."""

import numpy as np
from manifold3d import triangulate
from scipy.spatial.transform import Rotation

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
SMALL = [(0.25, 0.25), (0.5, 0.25), (0.5, 0.5), (0.25, 0.5)]
#: Its sides cross.
BOW = [(0, 0), (1, 0), (0.25, 0.75), (0.5, 1)]
#: The right-hand edge goes up to 1 and comes back to 0.5 before it goes left.
SPIKE = [(0, 0), (1, 0), (1, 1), (1, 0.5), (0, 0.5)]
#: A notch whose corner lies on the underside.
NOTCH = [(0, 0), (1, 0), (1, 1), (0.5, 0), (0, 1)]
OVERHANG = [(0, 0), (1, 0), (1, 1), (0.5, 1), (0.75, 0.6), (0.2, 0.5), (0, 1)]
BESIDE = [(1, 0.25), (2, 0.25), (2, 0.5), (1, 0.5)]


def drawn(*rings, length=0.1, fan=False):
    """Return facets of a section drawn along y: outlines anticlockwise in (x, z), holes clockwise.

    fan: the ends of each outline as a fan, which closes what no triangulation does.
    """
    facets = []
    for ring in rings:
        for p, q in zip(ring, [*ring[1:], ring[0]], strict=True):
            a, b = (p[0], 0.0, p[1]), (q[0], 0.0, q[1])
            c, d = (q[0], length, q[1]), (p[0], length, p[1])
            facets += [(a, c, b), (a, d, c)]
    flat = np.concatenate(rings)
    faces = triangulate([np.asarray(ring, float) for ring in rings])
    if fan:
        starts = np.cumsum([0] + [len(ring) for ring in rings])
        faces = [(s, s + k, s + k + 1) for s, ring in zip(starts, rings, strict=False)
                 for k in range(1, len(ring) - 1)]  # fmt: skip
    for face in faces:
        near = [(flat[k][0], 0.0, flat[k][1]) for k in face]
        facets += [near, [(x, length, z) for x, _, z in near[::-1]]]
    return np.array(facets)


def box(low, high):
    (x, y, z), (X, Y, Z) = low, high
    solid = drawn([(x, z), (X, z), (X, Z), (x, Z)], length=Y - y)
    return solid + np.array([0.0, y, 0.0])


def turned(facets):
    """Return the mesh in a general position, where nothing of it is extruded along an axis."""
    return (
        Rotation.from_euler("xyz", [0.3, 0.5, 0.7]).apply(facets.reshape(-1, 3)).reshape(-1, 3, 3)
    )
