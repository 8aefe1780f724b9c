"""What a path's arrival at the topmost sheet sends into a meter above: without chance.

A path from an LED meets a meter of 1° by chance once in thousands. Each time that it comes up to a
sheet that scatters, with nothing above but the meter, the light that the sheet would turn into the
meter's cone is added at once (next-event estimation; Coveyou, Cain and Yost, 1967), and the path
goes on as if nothing had happened; what leaves upward by itself is not counted.
"""

import math
from typing import NamedTuple

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import disk
from mpfcad.optics.sheet import INDEX, TRANSMISSION, move_density, sheet_transmittance

#: Harmonics of the cell's period along each axis that are scored.
HARMONICS = 6
#: 1, cos, sin, cos, … along one axis.
TERMS = 1 + 2 * HARMONICS


class CellMeter(NamedTuple):
    """A luminance meter that looks straight down at a cell that repeats.

    Attributes
    ----------
    acceptance
        sine of its half angle
    across, along
        the cell's size [mm]; it lies about x = y = 0
    bins
        along each axis, of the luminance's map of a cell
    reach
        cells on either side of the LED's own whose map is scored, of each LED by itself; 0: all
        cells are one, with its coefficients
    """

    acceptance: float
    across: float
    along: float
    bins: int
    reach: int = 0

    @property
    def side(self) -> int:
        """Bins along each axis of an LED's map."""
        return (2 * self.reach + 1) * self.bins

    def size(self, leds: int) -> int:
        """Return how many numbers a path scores.

        TERMS² coefficients, then bins² of the map; with `reach` the score as a whole, then side² of
        each LED's map.
        """
        if self.reach > 0:
            return 1 + leds * self.side * self.side
        return TERMS * TERMS + self.bins * self.bins


@kernel
def turned_into(parameter, acceptance, dx, dy, dz, rng):
    """Return the luminance that a ray of flux 1 a mm² makes in the meter, by way of the sheet.

    The sheet's density of direction cosines is one of projected solid angle, so it is the luminance
    itself. The direction is drawn in the meter's cone.
    """
    px, py = disk(rng)
    kx, ky = acceptance * px, acceptance * py
    kz = math.sqrt(1.0 - kx * kx - ky * ky)
    density = move_density(parameter, kx - dx, ky - dy)
    passed = sheet_transmittance(abs(dz), kz, parameter[INDEX])
    return density * passed * parameter[TRANSMISSION]


@kernel
def part_at(meter, x, y):
    """Return the number of the bin of the cell at a place, rows along x."""
    u, v = x / meter.across + 0.5, y / meter.along + 0.5
    u, v = u - math.floor(u), v - math.floor(v)
    row, column = min(int(u * meter.bins), meter.bins - 1), min(int(v * meter.bins), meter.bins - 1)
    return row * meter.bins + column


@kernel
def score_at(meter, score, terms, x, y, value):
    """Add a value at a place to the coefficients and the map; terms (2, TERMS) is scratch."""
    u = x / meter.across + 0.5
    v = y / meter.along + 0.5
    u, v = u - math.floor(u), v - math.floor(v)
    for axis in range(2):
        angle = 2.0 * math.pi * ((u if axis == 0 else v) - 0.5)
        cosine, sine = math.cos(angle), math.sin(angle)
        c, s = 1.0, 0.0
        terms[axis, 0] = 1.0
        for h in range(HARMONICS):
            c, s = c * cosine - s * sine, s * cosine + c * sine
            terms[axis, 1 + 2 * h] = c
            terms[axis, 2 + 2 * h] = s
    for i in range(TERMS):
        part = value * terms[0, i]
        for j in range(TERMS):
            score[i * TERMS + j] += part * terms[1, j]
    row, column = min(int(u * meter.bins), meter.bins - 1), min(int(v * meter.bins), meter.bins - 1)
    score[TERMS * TERMS + row * meter.bins + column] += value


@kernel
def score_spread(meter, score, led, x, y, value):
    """Add an LED's value at a place to the score as a whole and to that LED's map."""
    score[0] += value
    half = meter.reach + 0.5
    side = (2 * meter.reach + 1) * meter.bins
    row = math.floor((x / meter.across + half) * meter.bins)
    column = math.floor((y / meter.along + half) * meter.bins)
    if 0 <= row < side and 0 <= column < side:
        score[1 + (led * side + int(row)) * side + int(column)] += value
