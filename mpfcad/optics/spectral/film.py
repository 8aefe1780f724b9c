"""A film of phosphor or quantum dots with an index of its own: light is followed within it.

Its faces reflect and refract by Fresnel's law. Within it light of band b is taken at the rate a_b,
its depth over the thickness, and what is emitted starts where light was taken, alike in all
directions. So of what is emitted the share √(1 - 1/n²) is beyond the critical angle of the faces
and goes on between them until it is taken again, or is scattered. Seen backward, light of band m
along a path within is (the equation of transfer; Chandrasekhar, "Radiative transfer", 1950)

    L_m = (q_m/λ_m) yield Σ_b λ_b ∫ a_b exp(-a_m s) J_b(s) ds,

J_b the mean over all directions: a second path starts at a point of the first. The point is drawn
evenly along each step to a face or a particle. Where nothing scatters, light beyond the critical
angle has its whole way as one step, and its point the density κ exp(-κ s), κ the least rate above 0
of a band that the path has; light that is not taken there is guided to the film's rim, and lost.
"""

import math

from mpfcad.optics.base.circle import circle
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.phase import scattering_cosine
from mpfcad.optics.base.recorder import FLOW_ELEMENTS, FLOW_LOST
from mpfcad.optics.base.roulette import roulette
from mpfcad.optics.base.sampling import flight, turn, uniform
from mpfcad.optics.spectral.converter import (
    ASYMMETRY,
    DEPTH,
    INDEX,
    SCATTERING,
    THICKNESS,
    draws,
    offer,
    slant,
)
from mpfcad.optics.spectral.hue import MATERIAL, OWN, even_out, stain
from mpfcad.optics.stokes.interface import meet_interface
from mpfcad.optics.stokes.state import depolarise, keep_rows

_MOST_STEPS = 1_000_000


@kernel
def converter_passage(scene, e, up, x, y, dx, dy, dz, weight, flow, light, hue, rng):
    """Follow a ray through a converting sheet or film: (way, x, y, dx, dy, dz, weight)."""
    parameter = scene.parameter[e]
    index = parameter[INDEX]
    if parameter[THICKNESS] > 0.0:
        mirrored, cos_out = meet_interface(
            abs(dz), 1.0 / index, 0.0, 0.0, 1.0, dx, dy, dz, light, rng
        )
        if mirrored:
            return (-1 if up else 1), x, y, dx, dy, -dz, weight
        z = 0.0 if up else parameter[THICKNESS]
        dx, dy, dz = dx / index, dy / index, math.copysign(cos_out, dz)
        return within(scene, e, x, y, z, dx, dy, dz, weight, flow, light, hue, rng)
    length = slant(index, dz)
    offer(hue, light, e, parameter[DEPTH], length, x, y, weight, rng)
    left = weight * math.exp(-parameter[DEPTH] * length)
    stain(hue, e, MATERIAL, length)
    flow[FLOW_ELEMENTS + e] += weight - left
    return (1 if up else -1), x, y, dx, dy, dz, left


@kernel
def within(scene, e, x, y, z, dx, dy, dz, weight, flow, light, hue, rng):
    """Follow a ray from a point within a film: (way, x, y, dx, dy, dz, weight); ended: 0, 0."""
    parameter = scene.parameter[e]
    index, thickness = parameter[INDEX], parameter[THICKNESS]
    scattering = parameter[SCATTERING]
    for _ in range(_MOST_STEPS):
        free, to_face = flight(thickness, scattering, z, dz, rng)
        step = min(free, to_face)
        if scattering == 0.0 and index * index * (1.0 - dz * dz) >= 1.0:
            step = math.inf
        offer_within(hue, light, parameter, e, step, x, y, z, dx, dy, dz, weight, rng)
        before = weight
        weight = _left(hue, e, parameter, step, weight)
        flow[FLOW_ELEMENTS + e] += before - weight
        weight = roulette(weight, flow, rng)
        if weight == 0.0:
            return 0, x, y, dx, dy, dz, 0.0
        x += step * dx
        y += step * dy
        if free < to_face:
            z += step * dz
            cosine = scattering_cosine(scene.phase, -1, parameter[ASYMMETRY], uniform(rng))
            dx, dy, dz = turn(dx, dy, dz, cosine, 2.0 * math.pi * uniform(rng))
            depolarise(light)
            continue
        top = dz > 0.0
        z = thickness if top else 0.0
        mirrored, cos_out = meet_interface(abs(dz), index, 0.0, 0.0, 1.0, dx, dy, dz, light, rng)
        if mirrored:
            dz = -dz
            continue
        way = 1 if top else -1
        return way, x, y, dx * index, dy * index, math.copysign(cos_out, dz), weight
    flow[FLOW_LOST] += weight
    return 0, x, y, dx, dy, dz, 0.0


@kernel
def _left(hue, e, parameter, step, weight):
    """Return the weight after a step [mm], and weaken the tints; 0 of what is guided away."""
    if math.isinf(step):
        return 0.0
    length = step / parameter[THICKNESS]
    stain(hue, e, MATERIAL, length)
    return even_out(hue, e, weight * math.exp(-parameter[DEPTH] * length))


@kernel
def any_direction(rng):
    """Return a direction drawn evenly from all."""
    dz = 2.0 * uniform(rng) - 1.0
    sine = math.sqrt(max(0.0, 1.0 - dz * dz))
    px, py = circle(uniform(rng))
    return sine * px, sine * py, dz


@kernel
def offer_within(hue, light, parameter, e, step, x, y, z, dx, dy, dz, weight, rng):
    """Let a path have come from a point of its next step within: one of all is drawn."""
    if hue is not None:
        _offer_within(hue, light, parameter, e, step, x, y, z, dx, dy, dz, weight, rng)


@kernel
def _offer_within(hue, light, parameter, e, step, x, y, z, dx, dy, dz, weight, rng):
    slot, tables = hue.at[0], hue.tables
    kind, thickness = tables.species[e], parameter[THICKNESS]
    forward = tables.forward[0] != 0
    # Lengths in thicknesses: rates are depths; `span` is 1 over the density of the point drawn.
    if math.isinf(step):
        rate = 0.0
        for b in range(hue.tint.shape[1]):
            depth = parameter[DEPTH] + tables.soak[e, MATERIAL, b]
            if hue.tint[slot, b] > 0.0 and depth > 0.0 and (rate == 0.0 or depth < rate):
                rate = depth
        if rate == 0.0:
            return
        length = -math.log(1.0 - uniform(rng)) / rate
        span = math.exp(rate * length) / rate
    else:
        length = uniform(rng) * step / thickness
        span = step / thickness
    chance = 0.0
    for b in range(hue.tint.shape[1]):
        depth = parameter[DEPTH] + tables.soak[e, MATERIAL, b]
        part = hue.tint[slot, b] * math.exp(-depth * length)
        if forward:
            part *= tables.taken[kind, b] * depth
            if hue.stage[slot] == OWN:
                part *= tables.source[b]
        else:
            part *= tables.emitted[kind, b]
        chance += part
    chance *= span
    if draws(hue, weight * chance, rng):
        s = length * thickness
        height = (z + s * dz) % (2.0 * thickness)
        place = hue.place[slot]
        place[0], place[1], place[2] = x + s * dx, y + s * dy, height
        if height > thickness:
            place[2] = 2.0 * thickness - height
        hue.element[slot] = e
        keep_rows(light, hue.kept[slot])
        for b in range(hue.tint.shape[1]):
            depth = parameter[DEPTH] + tables.soak[e, MATERIAL, b]
            left = hue.tint[slot, b] * math.exp(-depth * length)
            hue.offered[slot, b] = left * tables.emitted[kind, b] * span / chance
