"""A union of bodies has facets far narrower than long: no ray is lost at them."""

import manifold3d
import numpy as np
from harness import rays, through, write_facets

from mpfcad.optics.solid.mesh import read_film_mesh


def test_no_ray_is_lost_on_the_slivers_of_a_union(tmp_path):
    union = manifold3d.Manifold.cube([0.4, 0.4, 0.15])
    for place, radius, chords in (((0.1, 0.12, 0.16), 0.03, 64), ((0.27, 0.28, 0.14), 0.06, 24)):
        union += manifold3d.Manifold.sphere(radius, chords).translate(place)
    mesh = union.to_mesh()
    corner = np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts)]
    film = read_film_mesh(write_facets(tmp_path / "a.stl", corner))
    for up in (True, False):
        assert (through(film, rays(200_000, up, size=(0.4, 0.4)), up)[:, 0] != 0).all()
