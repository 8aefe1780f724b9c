"""Films and the MPF stack in Mitsuba; each function returns one that traces n paths.

Mitsuba counts in µm, so that its ray offsets stay small beside a facet. Its rays are fed straight
to the path integrator: a sensor's own shape would throw light back into the film.
"""

import tempfile
from pathlib import Path

import numpy as np

from tracer.stl import read_mesh

PITCH = 50.0  # µm


def film_shape(mi, path, index, to_world=None):
    vertex, facet = read_mesh(path)
    return mesh_shape(mi, vertex * 1e3, facet, index, to_world)


def mesh_shape(mi, vertex, facet, index, to_world=None):
    """Return vertices (v, 3) [µm] and facets (t, 3) as a shape of a refractive index."""
    record = np.zeros(len(facet), [("count", "u1"), ("vertex", "<i4", 3)])
    record["count"], record["vertex"] = 3, facet
    with tempfile.TemporaryDirectory() as folder:
        ply = Path(folder) / "film.ply"
        header = (
            "ply\nformat binary_little_endian 1.0\nelement vertex "
            f"{len(vertex)}\nproperty float x\nproperty float y\nproperty float z\nelement face "
            f"{len(facet)}\nproperty list uchar int vertex_indices\nend_header\n"
        )
        ply.write_bytes(header.encode() + vertex.astype("<f4").tobytes() + record.tobytes())
        glass = {"type": "dielectric", "int_ior": index, "ext_ior": 1.0}
        mesh = {"type": "ply", "filename": str(ply), "face_normals": True, "bsdf": glass}
        return mi.load_dict(mesh if to_world is None else {**mesh, "to_world": to_world})


def mitsuba():
    """Return Mitsuba with its vectorised variant."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    return mi


def plane(mi, z, half, **more):
    """Return a rectangle at height z, `half` as long as it is: of both sides, or of x and y."""
    x, y = np.broadcast_to(half, 2).tolist()
    to_world = mi.ScalarTransform4f().translate([0, 0, z]).scale([x, y, 1])
    return {"type": "rectangle", "to_world": to_world, **more}


def path_tracer(mi, scene, origin, direction):
    """Return trace(n, seed) → (mean, standard error) for rays from origin(u), direction(v)."""
    import drjit as dr

    integrator = mi.load_dict({"type": "path", "max_depth": 2000, "rr_depth": 1000})

    def trace(n, seed):
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, n)
        ray = mi.Ray3f(origin(sampler.next_2d()), direction(sampler.next_2d()))
        found, _, _ = integrator.sample(scene, sampler, mi.RayDifferential3f(ray))
        value = np.array(dr.ravel(found.y), float)
        return value.mean(), value.std() / np.sqrt(n)

    return trace


def mitsuba_film(path, index, lambertian, reflectance=0.0, beside=0.0, top=180.0):
    """Put a film over an emitter of radiance 1 and a reflectance, between black halves otherwise.

    `beside` [µm]: all but what lies as near to the middle is cut off by four perfect mirrors.
    """
    mi = mitsuba()
    light = {
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}},
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}},
    }
    world = {"type": "scene", "film": film_shape(mi, path, index)}
    world["light"] = plane(mi, -1.0, 3e5, **light)
    if beside:
        mirrors(mi, world, (beside, beside), 100, 500)

    def origin(u):
        return mi.Point3f((u.x - 0.5) * PITCH, (u.y - 0.5) * PITCH, top)

    def direction(v):
        if not lambertian:
            return mi.Vector3f(0, 0, -1)
        d = mi.warp.square_to_cosine_hemisphere(v)
        return mi.Vector3f(d.x, d.y, -d.z)

    return path_tracer(mi, mi.load_dict(world), origin, direction)


def sheet_class(mi):
    """Return the tracer's own sheet as a BSDF in Python, which the vectorised variant compiles."""
    import drjit as dr

    class Sheet(mi.BSDF):
        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.sigma, self.index = props["sigma"], props["index"]
            self.survival = props["transmission"]
            flag = mi.BSDFFlags
            both = flag.FrontSide | flag.BackSide
            self.m_components = [flag.DeltaTransmission | both, flag.DeltaReflection | both]
            self.m_flags = self.m_components[0] | self.m_components[1]

        def sample(self, ctx, si, one, two, active=True):
            radius = dr.sqrt(-2 * dr.log(1 - two.x))
            sine, cosine = dr.sincos(2 * dr.pi * two.y)
            kx = -si.wi.x + self.sigma * radius * cosine
            ky = -si.wi.y + self.sigma * radius * sine
            rest = 1 - kx * kx - ky * ky
            kz = dr.sqrt(dr.maximum(rest, 0))
            r1, r2 = (mi.fresnel(c, self.index)[0] for c in (dr.abs(si.wi.z), kz))
            passed = (rest > 0) & (one < (1 - r1) * (1 - r2) / (1 - r1 * r2))
            through = mi.Vector3f(kx, ky, -dr.mulsign(kz, si.wi.z))
            back = mi.Vector3f(-si.wi.x, -si.wi.y, si.wi.z)
            sample = mi.BSDFSample3f()
            sample.wo = dr.select(passed, through, back)
            sample.pdf, sample.eta = 1.0, 1.0
            sample.sampled_type = dr.select(
                passed, mi.UInt32(+mi.BSDFFlags.DeltaTransmission),
                mi.UInt32(+mi.BSDFFlags.DeltaReflection),
            )  # fmt: skip
            sample.sampled_component = dr.select(passed, mi.UInt32(0), mi.UInt32(1))
            return sample, mi.Color3f(self.survival) & active

        def eval(self, ctx, si, wo, active=True):
            return mi.Color3f(0)

        def pdf(self, ctx, si, wo, active=True):
            return mi.Float(0)

        def eval_pdf(self, ctx, si, wo, active=True):
            return mi.Color3f(0), mi.Float(0)

    return Sheet


def mitsuba_stack(path, stack, points):
    """Build the MPF stack of lamps, reflector, clear plate, sheet, film, sheet between mirrors.

    The mirrors stand half a pitch beside two lamps, and along the lamps as far apart, so that all
    repeats without end. The sheets are 0.01 mm from the film, and the faces of the plate are those
    of a box. Lamps are emitters that next-event estimation knows.
    """
    mi = mitsuba()
    mi.register_bsdf("sheet", sheet_class(mi))
    pitch, mm = stack[0].lamp_pitch, 1e3
    wall = pitch * mm
    film = film_shape(mi, path, stack[3].index)
    world, start = stack_world(mi, stack, film, (-wall / 2, wall / 2), (wall, wall))
    scene = mi.load_dict(world)

    def trace_at(u):
        x = (u * pitch - pitch / 2) * mm
        return path_tracer(
            mi, scene,
            lambda s: mi.Point3f(x + (s.x - 0.5) * mm, (s.y - 0.5) * PITCH, start),
            lambda v: mi.Vector3f(0, 0, -1),
        )  # fmt: skip

    return [trace_at(u) for u in points]


def stack_world(mi, elements, film, axes, walls):
    """Return the MPF stack between mirrors, and a height [µm] over it.

    elements: cavity, clear plate, sheet, film, sheet. film: its shape, from z = 0 up. axes: x of
    the lamps [µm]. walls: x and y of the mirrors [µm]. Lamps are emitters that next-event
    estimation knows.
    """
    cavity, plate, bottom, _, top = elements
    mm, half = 1e3, [1.05 * wall for wall in walls]
    grey = {"type": "rgb", "value": cavity.reflectance}
    # Heights count from the film: Mitsuba's ray offset is 9e-5 of the largest coordinate.
    floor = -cavity.height * mm - plate.thickness * mm - 20
    world = {"type": "scene", "reflector": plane(mi, floor, half, bsdf={
        "type": "blendbsdf", "weight": cavity.specular_fraction,
        "diffuse": {"type": "diffuse", "reflectance": grey},
        "mirror": {"type": "conductor", "material": "none", "specular_reflectance": grey},
    })}  # fmt: skip
    z = floor + cavity.lamp_height * mm
    for number, x in enumerate(axes):
        world[f"lamp{number}"] = {
            "type": "cylinder", "p0": [x, -walls[1], z], "p1": [x, walls[1], z],
            "radius": cavity.lamp_radius * mm,
            "emitter": {"type": "area",
                        "radiance": {"type": "rgb", "value": cavity.lamp_luminance}},
            "bsdf": {"type": "diffuse",
                     "reflectance": {"type": "rgb", "value": cavity.lamp_reflectance}},
        }  # fmt: skip
    z = floor + cavity.height * mm
    box = mi.ScalarTransform4f().translate([0, 0, z + plate.thickness * mm / 2])
    world["plate"] = {
        "type": "cube", "to_world": box.scale([*half, plate.thickness * mm / 2]),
        "bsdf": {"type": "dielectric", "int_ior": plate.index, "ext_ior": 1.0},
    }  # fmt: skip

    def sheet(element):
        return {"type": "sheet", "sigma": element.sigma, "index": element.index,
                "transmission": element.transmission}  # fmt: skip

    world["bottom"] = plane(mi, z + plate.thickness * mm + 10, half, bsdf=sheet(bottom))
    world["film"] = film
    z = film.bbox().max.z + 10
    world["top"] = plane(mi, z, half, bsdf=sheet(top))
    mirrors(mi, world, walls, floor / 2, -floor)
    return world, z + 10


def mirrors(mi, world, walls, height, half):
    """Add four upright perfect mirrors at ± x and ± y [µm], `half` to each side of `height`."""
    for i, (axis, angle) in enumerate((((0, 1, 0), 90), ((1, 0, 0), 90))):
        for side in (-1, 1):
            place = [0, 0, height]
            place[i] = side * walls[i]
            turn = mi.ScalarTransform4f().translate(place).rotate(axis, angle)
            world[f"mirror{i}{side}"] = {
                "type": "rectangle", "to_world": turn.scale(max(half, 1.1 * max(walls))),
                "bsdf": {"type": "twosided", "bsdf": {"type": "conductor", "material": "none"}},
            }  # fmt: skip
