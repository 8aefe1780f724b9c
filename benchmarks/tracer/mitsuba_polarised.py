"""Plates and films over an emitter in Mitsuba's polarised variant."""

import numpy as np

from tracer.mitsuba_scene import PITCH, film_shape, plane


def mitsuba():
    """Return Mitsuba with its vectorised polarised variant."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_mono_polarized")
    return mi


def plates(mi, index: float, count: int) -> dict:
    """Return so many plane plates 1 mm thick, 1 mm apart, wider than light goes."""
    glass = {"type": "dielectric", "int_ior": index, "ext_ior": 1.0}
    faces = {}
    for i in range(count):
        faces[f"top{i}"] = plane(mi, 2000.0 * i + 1000.0, 3e6, bsdf=glass)
        # The lower face looks down, out of the glass.
        turned = mi.ScalarTransform4f().translate([0, 0, 2000.0 * i]).rotate([1, 0, 0], 180)
        to_world = turned.scale([3e6, 3e6, 1])
        faces[f"low{i}"] = {"type": "rectangle", "to_world": to_world, "bsdf": glass}
    return faces


def film(mi, path, index: float) -> dict:
    """Return a film read from an STL."""
    return {"film": film_shape(mi, path, index)}


def stokes(mi, bodies: dict, tilt, top: float, rays: int, seed: int):
    """Return the mean I, Q, U, V with standard errors, (4,) each, of light that leaves upward.

    It comes from an emitter of radiance 1 below and goes along (-tilt, up); Q is light along y less
    light along x, as `mpfcad.optics.stokes.engine.trace_stokes` has it. `top` [µm] is where rays
    start, over a pitch about x = 0.
    """
    import drjit as dr

    emitter = {"type": "area", "radiance": {"type": "uniform", "value": 1.0}}
    black = {"type": "diffuse", "reflectance": {"type": "uniform", "value": 0.0}}
    light = plane(mi, -1.0, 3e7, emitter=emitter, bsdf=black)
    scene = mi.load_dict({"type": "scene", "light": light, **bodies})
    integrator = mi.load_dict({"type": "path", "max_depth": 2000, "rr_depth": 1000})
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, rays)
    u = sampler.next_2d()
    down = -np.sqrt(1 - tilt[0] ** 2 - tilt[1] ** 2)
    d = mi.Vector3f(tilt[0], tilt[1], float(down))
    # Over the same place of the film's underside, whatever the tilt.
    shift = top / down
    x = (u.x - 0.5) * PITCH + float(shift * tilt[0])
    origin = mi.Point3f(x, (u.y - 0.5) * PITCH + float(shift * tilt[1]), top)
    found, _, _ = integrator.sample(scene, sampler, mi.RayDifferential3f(mi.Ray3f(origin, d)))
    towards = -d
    wanted = dr.normalize(dr.cross(towards, mi.Vector3f(1, 0, 0)))
    turned = mi.mueller.rotate_stokes_basis(towards, mi.mueller.stokes_basis(towards), wanted)
    matrix = turned @ found
    values = np.array([np.array(dr.ravel(matrix[i, 0][0]), float) for i in range(4)])
    return values.mean(axis=1), values.std(axis=1) / np.sqrt(rays)
