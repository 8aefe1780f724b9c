"""A film in raysect, and a mesh in Embree."""

import numpy as np

from tracer.mitsuba_scene import PITCH
from tracer.stl import read_mesh


def raysect_film(path, index, lambertian):
    """Put two pitches of a film between mirrors over an emitter of radiance 1.

    raysect follows one ray at a time. Facets of some 20 mm it meets in single precision; with those
    its transmittance is 3 % off, and another percent off in each other unit of length.
    """
    from raysect.optical import ConstantSF, Point3D, Ray, Vector3D, World
    from raysect.optical.material import Dielectric, UniformSurfaceEmitter
    from raysect.optical.material.debug import PerfectReflectingSurface
    from raysect.primitive import Box, Mesh

    vertex, facet = read_mesh(path)
    world = World()
    glass = Dielectric(ConstantSF(index), ConstantSF(1.0))
    keep = [Mesh(vertex, facet, smoothing=False, parent=world, material=glass)]
    light = UniformSurfaceEmitter(ConstantSF(1.0))
    keep.append(Box(Point3D(-99, -99, -1), Point3D(99, 99, -0.001), parent=world, material=light))
    p, far = PITCH / 1e3, 1.0
    for low, high in (((p, -far), (far, far)), ((-far, -far), (-p, far)), ((-far, p), (far, far)),
                      ((-far, -far), (far, -p))):  # fmt: skip
        keep.append(Box(Point3D(*low, -0.5), Point3D(*high, 1.0), parent=world,
                        material=PerfectReflectingSurface()))  # fmt: skip

    def trace(n, seed):
        random = np.random.default_rng(seed).random((n, 4))
        value = np.empty(n)
        for i, (a, b, c, d) in enumerate(random):
            k, phi = (np.sqrt(c), 2 * np.pi * d) if lambertian else (0.0, 0.0)
            down = Vector3D(k * np.cos(phi), k * np.sin(phi), -np.sqrt(1 - k * k))
            start = Point3D((a - 0.5) * 0.05, (b - 0.5) * 0.05, 0.18)
            ray = Ray(start, down, min_wavelength=500, max_wavelength=501, bins=1, max_depth=1000,
                      extinction_prob=1e-9, extinction_min_depth=900)  # fmt: skip
            value[i] = ray.trace(world).samples[0]
        return value.mean(), value.std() / np.sqrt(n), keep

    return trace


def embree_closest(vertex, facet):
    """Return closest(origins, directions) → facets, one robust ray at a time."""
    from embreex import rtcore_scene
    from embreex.mesh_construction import TriangleMesh

    scene = rtcore_scene.EmbreeScene(robust=True)
    TriangleMesh(scene, vertex[facet].astype(np.float32))
    return lambda origin, direction: scene.run(origin, direction)
