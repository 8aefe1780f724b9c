"""Second paths, from the converter that was drawn for a path, when the first has ended."""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.roulette import roulette
from mpfcad.optics.base.sampling import disk, uniform
from mpfcad.optics.engine import go_on
from mpfcad.optics.spectral.converter import DEPTH, INDEX, emitted_for, slant
from mpfcad.optics.spectral.hue import OWN


@kernel
def restart(scene, hue, slot, wave, flow):
    """Start a path again in the converter that was drawn for it; return whether there is one.

    It is then as a ray that has just left the converter `hue.element`.
    """
    rng, tables = wave.rng[slot], hue.tables
    weight = roulette(hue.chance[slot], flow, rng)
    hue.chance[slot] = 0.0
    if weight <= 0.0:
        return False
    e = hue.element[slot]
    kind, forward = tables.species[e], tables.forward[0] != 0
    px, py = disk(rng)
    dz = math.sqrt(max(0.0, 1.0 - px * px - py * py))
    length, depth = slant(scene.parameter[e, INDEX], dz), scene.parameter[e, DEPTH]
    most = 0.0
    for b in range(hue.tint.shape[1]):
        if forward:
            hue.tint[slot, b] = tables.emitted[kind, b]
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
    up = uniform(rng) < 0.5
    place = wave.place[slot]
    place[0], place[1] = hue.place[slot, 0], hue.place[slot, 1]
    place[3], place[4], place[5] = px, py, dz if up else -dz
    wave.way[slot] = 1 if up else -1
    wave.weight[slot] = weight * most
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
    while not goes_on and restart(scene, hue, slot, wave, flow):
        goes_on = go_on(scene, hue.element[slot], slot, wave, flow, None, hue)
    return goes_on
