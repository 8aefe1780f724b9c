"""What lamps give directly to a place on the reflector: the next event, without chance.

A path that meets the reflector adds at once what the lamps shine there, and leaves them out where
it meets them next (next-event estimation; Coveyou, Cain and Yost, "Adjoint and importance in Monte
Carlo application", 1967). Nothing is drawn for it: the Lambertian part is a view factor in closed
form, of the nearest lamp and its two neighbours; the mirrored part is whether that ray meets one.
Under a finite panel, where lamps end, the same closed form is a control variate.
"""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import floor, root, select
from mpfcad.optics.cavity.endless import (
    LAMP_HEIGHT,
    LAMP_PITCH,
    LAMP_POSITION,
    LAMP_RADIUS,
    NO_LAMP,
    SPECULAR_FRACTION,
    lamp_hit,
)
from mpfcad.optics.cavity.finite import FACTOR, POSITION

#: The numbers (first, last) of the lamps whose light is counted already: none, all.
NONE_COUNTED = (1, 0)
ALL_COUNTED = (NO_LAMP, -NO_LAMP)


@kernel
def _sines(across, height, radius):
    """Return the sines from the vertical between which a lamp is seen, `across` from its axis."""
    square = across * across + height * height
    middle = across * root(square - radius * radius) / square
    half = height * radius / square
    return middle - half, middle + half


@kernel
def lamp_view(pitch, position, height, radius, x):
    """Return what share of a Lambertian reflector's light goes to lamps, and the nearest's number.

    Of the nearest lamp and its neighbours, without what the nearest hides of them. An endless strip
    seen between two angles takes half the difference of their sines. One place or eight; the number
    is float64.
    """
    nearest = floor((x - position) / pitch + 0.5)
    across = position + nearest * pitch - x
    low, high = _sines(across, height, radius)
    left_low, left_high = _sines(across - pitch, height, radius)
    right_low, right_high = _sines(across + pitch, height, radius)
    left = select(left_high < low, left_high, low) - left_low
    right = right_high - select(right_low > high, right_low, high)
    left, right = select(left > 0.0, left, 0.0), select(right > 0.0, right, 0.0)
    return 0.5 * (left + high - low + right), nearest


@kernel
def panel_surplus(parameter, lamp, x, before, after):
    """Return by how much a panel's lamps, were they endless, would shine more than by chance.

    The mean over all directions in which the reflector may turn a ray at x, less what comes from
    the one it took: a control variate of mean 0, for what the lamps as they are give a ray is met
    where it is. Of the nearest lamp and its neighbours, each by its factor; `before` and `after`
    are the sines from the vertical, seen along y, of the ray come and gone. And its slope by the
    mirrored part.
    """
    nearest, left, right = _neighbours(lamp, x)
    height, radius = parameter[LAMP_HEIGHT], parameter[LAMP_RADIUS]
    low, high = _sines(lamp[nearest, POSITION] - x, height, radius)
    factor = lamp[nearest, FACTOR]
    mean, mirrored, taken = _shine(low, high, factor, before, after)
    if left >= 0:
        first, last = _sines(lamp[left, POSITION] - x, height, radius)
        found = _shine(first, min(last, low), lamp[left, FACTOR], before, after)
        mean, mirrored, taken = mean + found[0], mirrored + found[1], taken + found[2]
    if right >= 0:
        first, last = _sines(lamp[right, POSITION] - x, height, radius)
        found = _shine(max(first, high), last, lamp[right, FACTOR], before, after)
        mean, mirrored, taken = mean + found[0], mirrored + found[1], taken + found[2]
    share = parameter[SPECULAR_FRACTION]
    return (1.0 - share) * mean + share * mirrored - taken, mirrored - mean


@kernel
def _neighbours(lamp, x):
    """Return the numbers of the lamp nearest to x, of that before it and of that after, or -1."""
    nearest, left, right = 0, -1, -1
    for i in range(len(lamp)):
        if abs(lamp[i, POSITION] - x) < abs(lamp[nearest, POSITION] - x):
            nearest = i
    middle = lamp[nearest, POSITION]
    for i in range(len(lamp)):
        place = lamp[i, POSITION]
        if place < middle and (left < 0 or place > lamp[left, POSITION]):
            left = i
        if place > middle and (right < 0 or place < lamp[right, POSITION]):
            right = i
    return nearest, left, right


@kernel
def _shine(low, high, factor, before, after):
    """Return what comes from between two sines: over Lambertian directions, and in two of them."""
    if high <= low:
        return 0.0, 0.0, 0.0
    return (
        0.5 * (high - low) * factor,
        factor if low <= before < high else 0.0,
        factor if low <= after < high else 0.0,
    )


@kernel
def direct_light(parameter, x, dx, dz):
    """Return (share of a ray's reflected light that lamps send there, nearest's number, slope).

    The slope is that of the share by the mirrored part, where there is one. `parameter` is the
    cavity's; the ray meets the reflector at x with direction (dx, dz) across.
    """
    pitch, position = parameter[LAMP_PITCH], parameter[LAMP_POSITION]
    height, radius = parameter[LAMP_HEIGHT], parameter[LAMP_RADIUS]
    share, nearest = lamp_view(pitch, position, height, radius, x)
    mirrored = parameter[SPECULAR_FRACTION]
    slope = -share
    share = share * (1.0 - mirrored)
    if mirrored > 0.0:
        distance, _, _ = lamp_hit(
            x, 0.0 * x, dx, -dz, pitch, position, height, radius, 1.0 * NO_LAMP
        )
        met = distance < math.inf
        share = share + select(met, mirrored, 0.0)
        slope = slope + select(met, 1.0, 0.0)
    return share, nearest, slope
