"""Plates and films over an emitter in Mitsuba's polarised variant."""

import math

import numpy as np

from tracer.mitsuba_scene import PITCH, film_shape, plane


def mitsuba():
    """Return Mitsuba with its polarised variant for one ray at a time, which needs no LLVM."""
    import mitsuba as mi

    mi.set_variant("scalar_spectral_polarized")
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
    emitter = {"type": "area", "radiance": {"type": "uniform", "value": 1.0}}
    black = {"type": "diffuse", "reflectance": {"type": "uniform", "value": 0.0}}
    light = plane(mi, -1.0, 3e7, emitter=emitter, bsdf=black)
    scene = mi.load_dict({"type": "scene", "light": light, **bodies})
    integrator = mi.load_dict({"type": "path", "max_depth": 2000, "rr_depth": 1000})
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(seed, 1)
    down = -math.sqrt(1 - tilt[0] ** 2 - tilt[1] ** 2)
    d, shift = mi.Vector3f(tilt[0], tilt[1], down), top / down
    found = np.empty((rays, 4))
    for i in range(rays):
        u = sampler.next_2d()
        # Over the same place of the film's underside, whatever the tilt.
        x, y = ((u[k] - 0.5) * PITCH + shift * tilt[k] for k in (0, 1))
        ray = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(x, y, top), d))
        # (4, 4, wavelengths): of unpolarised light from the emitter.
        found[i] = np.array(integrator.sample(scene, sampler, ray)[0])[:, 0, 0]
    wanted = np.cross([-d[k] for k in range(3)], [1.0, 0.0, 0.0])
    wanted = mi.Vector3f(*(float(v) for v in wanted / np.linalg.norm(wanted)))
    turn = np.array(mi.mueller.rotate_stokes_basis(-d, mi.mueller.stokes_basis(-d), wanted))
    values = found @ turn.T
    return values.mean(axis=0), values.std(axis=0) / math.sqrt(rays)
