"""One LED under two crossed films in Mitsuba, between mirrors: a lattice without end."""

import numpy as np

from tracer.mitsuba_scene import (
    film_shape,
    mirrors,
    mitsuba,
    path_tracer,
    plane,
    sheet_class,
)

#: Places from the LED and side of the square over which the mean is taken, in pitches: squares that
#: do not overlap, of whole bins of our map and whole grooves.
PLACES = ((0.0, 0.0), (0.25, 0.0), (0.0, 0.25), (0.25, 0.25), (-0.25, 0.25), (0.25, -0.25))
SPOT = 0.25
#: The LED over the reflector [µm]: light that slips under its edge meets a black back.
OVER = 0.25


def mitsuba_led(elements, windows):
    """Return a function for each place that traces n paths; `windows` are 2 × 2 cells of a film."""
    mi = mitsuba()
    mi.register_bsdf("sheet", sheet_class(mi))
    board, plate, bottom, film, crossed, top = elements
    mm, pitch = 1e3, board.period[0]
    half = 0.9 * pitch * mm
    grey = {"type": "rgb", "value": board.reflectance}
    # Heights count from the film: Mitsuba's ray offset is 9e-5 of the largest coordinate.
    floor = -board.height * mm - plate.thickness * mm - 20
    world = {"type": "scene", "reflector": plane(mi, floor, half, bsdf={
        "type": "blendbsdf", "weight": board.specular_fraction,
        "diffuse": {"type": "diffuse", "reflectance": grey},
        "mirror": {"type": "conductor", "material": "none", "specular_reflectance": grey},
    })}  # fmt: skip
    side = board.led_size[0]
    radiance = board.led_flux / (np.pi * side * board.led_size[1] * 1e-6)
    world["led"] = plane(
        mi, floor + OVER, side / 2 * mm,
        emitter={"type": "area", "radiance": {"type": "rgb", "value": float(radiance)}},
        bsdf={"type": "diffuse",
              "reflectance": {"type": "rgb", "value": board.led_reflectance}},
    )  # fmt: skip
    z = floor + board.height * mm
    box = mi.ScalarTransform4f().translate([0, 0, z + plate.thickness * mm / 2])
    world["plate"] = {
        "type": "cube", "to_world": box.scale([half, half, plate.thickness * mm / 2]),
        "bsdf": {"type": "dielectric", "int_ior": plate.index, "ext_ior": 1.0},
    }  # fmt: skip

    def sheet(element):
        return {"type": "sheet", "sigma": element.sigma, "index": element.index,
                "transmission": element.transmission}  # fmt: skip

    world["bottom"] = plane(mi, z + plate.thickness * mm + 10, half, bsdf=sheet(bottom))
    world["film"] = film_shape(mi, windows[0], film.index)
    over = world["film"].bbox().max.z + 10
    turned = mi.ScalarTransform4f().translate([0, 0, over]).rotate([0, 0, 1], 90)
    world["crossed"] = film_shape(mi, windows[1], crossed.index, turned)
    z = world["crossed"].bbox().max.z + 10
    world["top"] = plane(mi, z, half, bsdf=sheet(top))
    # From under the reflector to over the top sheet.
    mirrors(mi, world, (pitch / 2 * mm, pitch / 2 * mm), (floor + z) / 2, z - floor)
    scene = mi.load_dict(world)

    def trace_at(place):
        x, y = (at * pitch * mm for at in place)
        return path_tracer(
            mi, scene,
            lambda s: mi.Point3f(
                x + (s.x - 0.5) * SPOT * pitch * mm, y + (s.y - 0.5) * SPOT * pitch * mm, z + 10
            ),
            lambda v: mi.Vector3f(0, 0, -1),
        )  # fmt: skip

    return [trace_at(place) for place in PLACES]
