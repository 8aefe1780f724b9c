"""Prism film and resin as closed meshes of their own, in float64."""

from dataclasses import replace

import numpy as np

from mpfcad.cad.shape.mesh import CrossSection, Mesh, build_cross_section, build_mesh, mesh_contact
from mpfcad.film import PrismFilm


def build_body_meshes(film: PrismFilm, angle_tolerance: float) -> dict[str, Mesh]:
    """Return `BEF` and, where a groove holds resin, `fill`, each closed and outward.

    An `ideal` film is moulded of one material: it is one body `film`.
    """
    if film.profile == "ideal":
        return {"film": build_mesh(film, angle_tolerance, np.float64)}
    empty = replace(film, curvature=np.full(film.groove_count, film.groove.curvature_empty))
    meshes = {"BEF": build_mesh(empty, angle_tolerance, np.float64)}
    if np.any(mesh_contact(film) > 0):
        section = build_cross_section(film, angle_tolerance, np.float64)
        meshes["fill"] = _build_fill(film, section)
    return meshes


def _build_fill(film: PrismFilm, section: CrossSection) -> Mesh:
    """Return the resin, one closed piece a groove: its parabola above, its valley below.

    The pieces share no corner, so that each stays closed where two touch along a tip. The valley
    sees the whole parabola, so the caps are fanned from it.
    """
    contact = mesh_contact(film)
    bare = (contact < film.groove.half_width).astype(np.int64)
    filled = contact > 0
    first = (section.tip[:-1] + bare)[filled]
    top = (section.tip[1:] - bare)[filled] - first + 1
    start = np.concatenate(([0], np.cumsum(top + 1)))
    corners = int(start[-1])
    index = np.arange(corners)
    piece = np.repeat(np.arange(len(top)), top + 1)
    place = index - start[piece]
    valley = place == top[piece]
    source = np.where(valley, 0, first[piece] + place)
    x = np.where(valley, film.groove_position[filled][piece], section.x[source])
    z = np.where(valley, film.base, section.z[source])
    ahead = np.where(valley, start[piece], index + 1)
    strip = np.stack(
        [index, ahead, ahead + corners, index, ahead + corners, index + corners], axis=1
    ).reshape(-1, 3)
    chord = index[place < top[piece] - 1]
    cap = np.stack([start[piece[chord]] + top[piece[chord]], chord + 1, chord], axis=1)
    near = np.stack([x, np.zeros_like(x), z], axis=1)
    far = np.stack([x, np.full_like(x, film.length), z], axis=1)
    triangles = np.concatenate([strip, cap, cap[:, ::-1] + corners])
    return Mesh(np.concatenate([near, far]), triangles)
