"""A ray over a board whose LEDs stand in cups: hollows in a white sheet that covers the board.

A cup is a round or square frustum about its LED's middle, from the board up to the sheet's top. It
is convex and holds that LED alone, so a ray in it meets the LED or leaves the cup in one place.
"""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.cavity.board import (
    CUP_HEIGHT,
    CUP_RADIUS,
    CUP_RIM,
    CUP_SPECULAR_FRACTION,
    CUP_SQUARE,
    CUP_WALL,
    LED_HEIGHT,
    LED_LENGTH,
    LED_SIDE,
    LED_TOP,
    LED_WIDTH,
    LED_X,
    LED_Y,
    PERIOD_ACROSS,
    PERIOD_ALONG,
    box_hit,
    near,
)
from mpfcad.optics.cavity.endless import HEIGHT, LOST, OPENING, REFLECTOR, lambertian
from mpfcad.optics.stokes.state import depolarise, mirror_light


@kernel
def _reach(parameter, u, v):
    """Return how far from its middle a place is, as a cup's radius is stated."""
    if parameter[CUP_SQUARE] > 0.0:
        return max(abs(u), abs(v))
    return math.sqrt(u * u + v * v)


@kernel
def _nearest(parameter, led, x, y):
    """Return (LED's number, u, v): the cup nearest to a place, and the place from its middle."""
    number, best, at_u, at_v = -1, math.inf, 0.0, 0.0
    for i in range(len(led)):
        u = near(x, led[i, LED_X], parameter[PERIOD_ACROSS])
        v = near(y, led[i, LED_Y], parameter[PERIOD_ALONG])
        reach = _reach(parameter, u, v)
        if reach < best:
            number, best, at_u, at_v = i, reach, u, v
    return number, at_u, at_v


@kernel
def _flat_walls(size, slope, place, direction, dz):
    """Return (distance, side) at which a ray passes place = ± (size + slope · dz · distance)."""
    best, side = math.inf, 1.0
    for turn in range(2):
        sign = 1.0 - 2.0 * turn
        rate = sign * direction - slope * dz
        if rate > 0.0:
            distance = max(0.0, (size - sign * place) / rate)
            if distance < best:
                best, side = distance, sign
    return best, side


@kernel
def _round_wall(size, slope, u, v, dx, dy, dz):
    """Return the distance at which a ray leaves a cone of radius size + slope · dz · distance."""
    a = dx * dx + dy * dy - slope * slope * dz * dz
    b = u * dx + v * dy - size * slope * dz
    c = min(0.0, u * u + v * v - size * size)
    square = b * b - a * c
    if b > 0.0:
        return -c / (b + math.sqrt(square)) if square >= 0.0 else math.inf
    return (math.sqrt(square) - b) / a if a > 0.0 else math.inf


@kernel
def wall_hit(parameter, u, v, z, dx, dy, dz):
    """Return (distance, normal inwards) of the wall of a cup that a ray in it meets; or inf.

    (u, v) is the ray's place from the cup's middle.
    """
    slope = (parameter[CUP_RIM] - parameter[CUP_RADIUS]) / parameter[CUP_HEIGHT]
    size = parameter[CUP_RADIUS] + slope * z
    long = math.sqrt(1.0 + slope * slope)
    if parameter[CUP_SQUARE] > 0.0:
        across, side_x = _flat_walls(size, slope, u, dx, dz)
        along, side_y = _flat_walls(size, slope, v, dy, dz)
        if across <= along:
            return across, -side_x / long, 0.0, slope / long
        return along, 0.0, -side_y / long, slope / long
    distance = _round_wall(size, slope, u, v, dx, dy, dz)
    if distance == math.inf:
        return math.inf, 0.0, 0.0, 0.0
    u, v = u + distance * dx, v + distance * dy
    far = math.sqrt(u * u + v * v) * long
    return distance, -u / far, -v / far, slope / long


@kernel
def cup_hit(parameter, led, x, y, z, dx, dy, dz):
    """Return what a ray meets over a board with cups, as `board.board_hit` does without."""
    rim, top = parameter[CUP_HEIGHT], parameter[LED_HEIGHT]
    end = parameter[HEIGHT]
    if dz == 0.0:
        return LOST, x, y, z, -1, 0.0, 0.0, 0.0
    if z > rim and dz < 0.0:
        flight = (rim - z) / dz
        x, y, z = x + flight * dx, y + flight * dy, rim
        _, u, v = _nearest(parameter, led, x, y)
        if _reach(parameter, u, v) > parameter[CUP_RIM]:
            return CUP_WALL, x, y, z, -1, 0.0, 0.0, 1.0
    if z < rim or dz < 0.0:
        number, u, v = _nearest(parameter, led, x, y)
        best, nx, ny, nz = wall_hit(parameter, u, v, z, dx, dy, dz)
        what, reach = CUP_WALL, ((rim if dz > 0.0 else 0.0) - z) / dz
        if best >= reach:
            best, what = reach, OPENING if dz > 0.0 else REFLECTOR
        half_width, half_length = 0.5 * parameter[LED_WIDTH], 0.5 * parameter[LED_LENGTH]
        if dz < 0.0 and z > top:
            flight = (top - z) / dz
            over_u, over_v = abs(u + flight * dx), abs(v + flight * dy)
            if flight <= best and over_u <= half_width and over_v <= half_length:
                best, what, nx, ny, nz = flight, LED_TOP, 0.0, 0.0, 1.0
        distance, across = box_hit(u, v, dx, dy, 0.0, 0.0, half_width, half_length)
        if distance < best and z + distance * dz < top:
            best, what, nz = distance, LED_SIDE, 0.0
            nx = -math.copysign(1.0, dx) if across else 0.0
            ny = 0.0 if across else -math.copysign(1.0, dy)
        if what != OPENING:
            z = 0.0 if what == REFLECTOR else min(max(z + best * dz, 0.0), rim)
            return what, x + best * dx, y + best * dy, z, number, nx, ny, nz
    flight = (end - z) / dz
    return OPENING, x + flight * dx, y + flight * dy, end, -1, 0.0, 0.0, 0.0


@kernel
def cup_direction(parameter, dx, dy, dz, nx, ny, nz, light, rng):
    """Return the direction after a cup's wall or the sheet's top, n its normal."""
    if uniform(rng) < parameter[CUP_SPECULAR_FRACTION]:
        mirror_light(light, nx, ny, nz)
        twice = 2.0 * (dx * nx + dy * ny + dz * nz)
        return dx - twice * nx, dy - twice * ny, dz - twice * nz
    depolarise(light)
    return lambertian(nx, ny, nz, rng)
