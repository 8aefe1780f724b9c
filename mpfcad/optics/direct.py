"""What lamps give directly to a place on the reflector: the next event, without chance.

A path that meets the reflector adds at once what the lamps shine there, and leaves them out where
it meets them next (next-event estimation; Coveyou, Cain and Yost, "Adjoint and importance in Monte
Carlo application", 1967). Nothing is drawn for it: the Lambertian part is a view factor in closed
form, of the nearest lamp and its two neighbours; the mirrored part is whether that ray meets one.
"""

import math

from mpfcad.optics.cavity import (
    LAMP_HEIGHT,
    LAMP_PITCH,
    LAMP_POSITION,
    LAMP_RADIUS,
    NO_LAMP,
    SPECULAR_FRACTION,
    lamp_hit,
)
from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import floor, root, select

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
def direct_light(parameter, x, dx, dz):
    """Return the share of a ray's reflected light that lamps send there, and the nearest's number.

    `parameter` is the cavity's; the ray meets the reflector at x with direction (dx, dz) across.
    """
    pitch, position = parameter[LAMP_PITCH], parameter[LAMP_POSITION]
    height, radius = parameter[LAMP_HEIGHT], parameter[LAMP_RADIUS]
    share, nearest = lamp_view(pitch, position, height, radius, x)
    mirrored = parameter[SPECULAR_FRACTION]
    share = share * (1.0 - mirrored)
    if mirrored > 0.0:
        distance, _, _ = lamp_hit(
            x, 0.0 * x, dx, -dz, pitch, position, height, radius, 1.0 * NO_LAMP
        )
        share = share + select(distance < math.inf, mirrored, 0.0)
    return share, nearest
