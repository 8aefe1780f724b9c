"""What a path weighs at each band of wavelengths, beside the weight by which it is drawn.

A path's way does not depend on how much of its light is absorbed, so one path serves all bands: its
weight at a band is that by which it was drawn, times the ratio of what is left at every event (the
weights of importance sampling; Hammersley and Handscomb, "Monte Carlo methods", 1964). The path is
drawn with what the band that loses least keeps at each event (`envelope`), so no ratio, a *tint*,
exceeds 1.

Channels of a meter: first a band each, of the lamps' own light; then, for each layer that converts
light (`converter`), a band each of what it emitted.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.stokes.state import ROWS

#: What a path of its length in weakens: a plate or prism, and resin of another material.
MATERIAL, RESIN = range(2)
#: What a path meets: a sheet or reflector, a lamp, the hole of an LED, a side wall or a cup's.
SURFACE, EMITTER, HOLE, WALL = range(4)
#: In the place of a converter's number: the lamps' own light.
OWN = -1


class Tables(NamedTuple):
    """How bands differ, e elements, b bands, c converters.

    Attributes
    ----------
    coloured
        (e,) int64, not 0 where an element treats bands differently
    soak
        (e, 2, b) float64 [1/mm], absorption of `MATERIAL` and `RESIN` over that of the scene
    strike
        (e, 4, b) float64, what is left at `SURFACE` … `WALL` over what the scene leaves, 0…1
    source
        (b,) float64, the lamps' power in each band for a luminance of 1
    luminance
        (b · (1 + c),) float64, luminance of what each channel counts
    species
        (e,) int64, the number of the converter that an element is, or `OWN`
    taken, emitted
        (c, b) float64, light emitted in all for light taken at a band, and its shares (`converter`)
    forward
        (1,) int64, not 0 where paths run from the lamps to the meter, as light does
    """

    coloured: NDArray[np.int64]
    soak: NDArray[np.float64]
    strike: NDArray[np.float64]
    source: NDArray[np.float64]
    luminance: NDArray[np.float64]
    species: NDArray[np.int64]
    taken: NDArray[np.float64]
    emitted: NDArray[np.float64]
    forward: NDArray[np.int64]


class Hue(NamedTuple):
    """The tables, and the state of the paths under way, s slots.

    Attributes
    ----------
    tables
        how bands differ
    tint
        (s, b) float64, weight at each band over the path's own
    stage
        (s,) int64, the converter that emitted what the meter sees, or `OWN`
    head
        (s, b) float64, what of its light the meter sees at each band
    chance, place, element, offered
        (s,), (s, 3), (s,), (s, b): the weight of all conversions that the path passed, and of the
        one drawn among them: where, in which element, and with which `head`
    kept
        (s, 4) float64, of polarised light what each meter saw there (`stokes.state`)
    score
        (p, channels) float64, sums of what the paths of each point saw
    at
        (2,) int64, the slot that is followed, and its point; -1: what it finds is not counted
    """

    tables: Tables
    tint: NDArray[np.float64]
    stage: NDArray[np.int64]
    head: NDArray[np.float64]
    chance: NDArray[np.float64]
    place: NDArray[np.float64]
    element: NDArray[np.int64]
    offered: NDArray[np.float64]
    kept: NDArray[np.float64]
    score: NDArray[np.float64]
    at: NDArray[np.int64]

    @classmethod
    def empty(cls, tables: Tables, slots: int, points: int) -> "Hue":
        """Return the state of no paths."""
        b = len(tables.source)

        def of_slots() -> NDArray[np.float64]:
            return np.zeros((slots, b))

        return cls(
            tables, of_slots(), np.zeros(slots, np.int64), of_slots(), np.zeros(slots),
            np.zeros((slots, 3)), np.zeros(slots, np.int64), of_slots(), np.zeros((slots, ROWS)),
            np.zeros((points, len(tables.luminance))), np.zeros(2, np.int64),
        )  # fmt: skip


@kernel
def look_at(hue, wave, slot):
    """Follow the path of a slot; of paths from the lamps the meter counts alone (`count_at`)."""
    if hue is not None:
        hue.at[0] = slot
        hue.at[1] = -1 if hue.tables.forward[0] != 0 else wave.path[slot] % len(hue.score)


@kernel
def count_at(hue, point):
    """Count what is found next at a point; -1: not at all."""
    if hue is not None:
        hue.at[1] = point if point < len(hue.score) else -1


@kernel
def is_coloured(hue, e):
    """Return whether an element treats bands differently."""
    found = False
    if hue is not None:
        found = hue.tables.coloured[e] != 0
    return found


@kernel
def begin_hue(hue, slot):
    """Start a path: alike at all bands."""
    if hue is not None:
        hue.stage[slot] = OWN
        hue.chance[slot] = 0.0
        for b in range(hue.tint.shape[1]):
            hue.tint[slot, b] = 1.0


@kernel
def stain(hue, e, material, length):
    """Weaken the tints by a path of a length [mm] in one of an element's materials."""
    if hue is not None:
        _stain(hue, e, material, length)


@kernel
def _stain(hue, e, material, length):
    if hue.tables.coloured[e] != 0 and length > 0.0:
        slot = hue.at[0]
        for b in range(hue.tint.shape[1]):
            hue.tint[slot, b] *= math.exp(-hue.tables.soak[e, material, b] * length)


@kernel
def even_out(hue, e, weight):
    """Return a weight times the largest tint, of which the tints become shares; 0: none is left.

    An element within which light may go on until all bands are taken needs it to see paths end.
    """
    if hue is not None:
        weight *= _even_out(hue, e)
    return weight


@kernel
def _even_out(hue, e):
    if hue.tables.coloured[e] == 0:
        return 1.0
    slot, most = hue.at[0], 0.0
    for b in range(hue.tint.shape[1]):
        most = max(most, hue.tint[slot, b])
    if most > 0.0:
        for b in range(hue.tint.shape[1]):
            hue.tint[slot, b] /= most
    return most


@kernel
def strike(hue, e, what):
    """Weaken the tints by a surface of an element."""
    if hue is not None:
        _strike(hue, e, what)


@kernel
def _strike(hue, e, what):
    if hue.tables.coloured[e] != 0:
        slot = hue.at[0]
        for b in range(hue.tint.shape[1]):
            hue.tint[slot, b] *= hue.tables.strike[e, what, b]


@kernel
def seen(hue, found):
    """Count light that a path has found; return its luminance.

    `found` is the luminance where it is, times the path's weight. Without bands it is returned.
    """
    luminance = found
    if hue is not None:
        slot, point = hue.at[0], hue.at[1]
        tables, bands = hue.tables, hue.tint.shape[1]
        stage = hue.stage[slot]
        luminance = 0.0
        if stage == OWN or tables.forward[0] != 0:
            first = bands * (1 + stage)
            for b in range(bands):
                part = found * hue.tint[slot, b]
                if point >= 0:
                    hue.score[point, first + b] += part
                luminance += part * tables.luminance[first + b]
        else:
            power = 0.0
            for b in range(bands):
                power += hue.tint[slot, b] * tables.source[b]
            power *= found
            first = bands * (1 + stage)
            for b in range(bands):
                part = power * hue.head[slot, b]
                hue.score[point, first + b] += part
                luminance += part * tables.luminance[first + b]
    return luminance
