"""Second paths, from the converter that was drawn for a path, when the first has ended."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.roulette import roulette
from mpfcad.optics.base.sampling import disk, uniform
from mpfcad.optics.engine import go_on
from mpfcad.optics.spectral.converter import DEPTH, INDEX, THICKNESS, emitted_for, slant
from mpfcad.optics.spectral.film import any_direction, within
from mpfcad.optics.spectral.hue import MATERIAL, OWN
from mpfcad.optics.stokes.state import take_rows


@kernel
def restart(scene, hue, light, slot, wave, flow):
    """Start a path again in the converter that was drawn for it; return whether there is one.

    It is then as a ray that has just left the converter `hue.element`; a ray that ended within it
    has way and weight 0.
    """
    rng, tables = wave.rng[slot], hue.tables
    weight = roulette(hue.chance[slot], flow, rng)
    hue.chance[slot] = 0.0
    if weight <= 0.0:
        return False
    e = hue.element[slot]
    kind, forward = tables.species[e], tables.forward[0] != 0
    parameter = scene.parameter[e]
    is_film, depth = parameter[THICKNESS] > 0.0, parameter[DEPTH]
    if is_film:
        px, py, dz = any_direction(rng)
        length = 1.0
    else:
        px, py = disk(rng)
        dz = math.sqrt(max(0.0, 1.0 - px * px - py * py))
        length = slant(parameter[INDEX], dz)
    most = 0.0
    for b in range(hue.tint.shape[1]):
        if forward:
            hue.tint[slot, b] = tables.emitted[kind, b]
        else:
            if is_film:
                rate = depth + tables.soak[e, MATERIAL, b]
                hue.tint[slot, b] = tables.taken[kind, b] * rate
            else:
                hue.tint[slot, b] = emitted_for(tables, e, kind, b, depth, length)
            if hue.stage[slot] == OWN:
                hue.head[slot, b] = hue.offered[slot, b]
        most = max(most, hue.tint[slot, b])
    if forward or hue.stage[slot] == OWN:
        hue.stage[slot] = kind
    if most <= 0.0:
        return False
    for b in range(hue.tint.shape[1]):
        hue.tint[slot, b] /= most
    weight *= most
    take_rows(light, hue.kept[slot])
    x, y, z = hue.place[slot, 0], hue.place[slot, 1], hue.place[slot, 2]
    if is_film:
        way, x, y, px, py, dz, weight = within(
            scene, e, x, y, z, px, py, dz, weight, flow, light, hue, rng
        )
    else:
        way = 1 if uniform(rng) < 0.5 else -1
        dz *= way
    place = wave.place[slot]
    place[0], place[1], place[3], place[4], place[5] = x, y, px, py, dz
    wave.way[slot], wave.weight[slot] = way, weight
    return True


@kernel
def go_on_in_bands(scene, e, slot, wave, flow, hue):
    """Move a ray that has left element e on, or its second path; return whether one goes on."""
    goes_on = go_on(scene, e, slot, wave, flow, None, hue)
    if hue is not None:
        goes_on = goes_on or _go_on_again(scene, slot, wave, flow, hue)
    return goes_on


@kernel
def _go_on_again(scene, slot, wave, flow, hue):
    goes_on = False
    while not goes_on and restart(scene, hue, None, slot, wave, flow):
        goes_on = go_on(scene, hue.element[slot], slot, wave, flow, None, hue)
    return goes_on
