"""The space under the stack over a board of LEDs: boxes on a reflector, whose tops shine.

The LEDs of one cell repeat without end along x and y. Their sides and tops reflect diffusely; round
each the board may have another reflectance (a hole in the reflector, solder mask), and each may
stand in a cup (`cavity.cup`).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.mirror import Mirrored
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.cavity.emission import Emission, emitted_direction
from mpfcad.optics.cavity.endless import BRDF, HEIGHT, LOST, OPENING, REFLECTANCE, REFLECTOR

#: The columns of a board in `Scene.parameter`, beside those that it shares with tubes: height,
#: reflectance, specular fraction and BRDF.
PERIOD_ACROSS, PERIOD_ALONG, LED_WIDTH, LED_LENGTH, LED_HEIGHT, LED_REFLECTANCE = range(1, 7)
LED_FLUX, HOLE_RADIUS, HOLE_REFLECTANCE = range(BRDF + 1, BRDF + 4)
CUP_HEIGHT, CUP_RADIUS, CUP_RIM = range(BRDF + 4, BRDF + 7)
CUP_REFLECTANCE, CUP_SPECULAR_FRACTION, CUP_SQUARE = range(BRDF + 7, BRDF + 10)
#: The columns of an LED: its middle, flux as a multiple of `LED_FLUX`, share of all flux with it.
LED_X, LED_Y, LED_FACTOR, LED_SHARE = range(4)
LED_TOP, LED_SIDE, CUP_WALL = range(LOST + 1, LOST + 4)
_MOST_PIECES = 100_000


@dataclass(frozen=True)
class Cup:
    """A hollow round each LED in a sheet that covers the board; lengths in mm.

    Attributes
    ----------
    height
        of the sheet's top over the board; no less than that of the LEDs
    radius, rim_radius
        at the board; at the sheet's top, no less than there. Of a square cup half a side
    reflectance, specular_fraction
        of the walls and of the sheet's top, as of the reflector
    square
        whether it is square, its sides along x and y; else round
    """

    height: float
    radius: float
    rim_radius: float
    reflectance: float
    specular_fraction: float
    square: bool = False


@dataclass(frozen=True, eq=False)
class Board(Mirrored):
    """LEDs over a reflector, below everything else; lengths in mm.

    Attributes
    ----------
    height
        from the reflector (z = 0) to the next element
    period
        size of the cell that repeats along x and y
    position, factor
        (l, 2), (l,) float64, middles of the cell's LEDs; their flux as a multiple of `led_flux`
    led_size, led_height
        of the emitting top along x and y; its height over the reflector
    led_flux
        [lm] of an LED of factor 1
    led_reflectance
        diffuse, of an LED's top and sides 0…1
    emission
        intensity over direction
    reflectance, specular_fraction
        of the reflector 0…1; the mirror-like part of it 0…1, the rest is Lambertian
    hole_radius, hole_reflectance
        round each LED's middle the board has another, diffuse reflectance
    cup
        what each LED stands in, if it does; the board is seen at its bottom alone
    brdf, blend
        a table in the place of the reflector's two values, and its interpolation (`BsdfSheet`)
    """

    height: float
    period: tuple[float, float]
    position: NDArray[np.float64]
    factor: NDArray[np.float64]
    led_size: tuple[float, float]
    led_height: float
    led_flux: float
    led_reflectance: float
    emission: Emission
    reflectance: float
    specular_fraction: float
    hole_radius: float = 0.0
    hole_reflectance: float = 0.0
    cup: Cup | None = None
    name: str = "reflector"
    brdf: BsdfTable | None = None
    blend: float = 1.0

    @property
    def flux(self) -> float:
        """Flux [lm] of the cell's LEDs."""
        return float(self.led_flux * self.factor.sum())

    def array(self) -> NDArray[np.float64]:
        """Return what the kernels read of each LED, (l, 4) float64."""
        led = np.zeros((len(self.position), 4))
        led[:, [LED_X, LED_Y]], led[:, LED_FACTOR] = self.position, self.factor
        led[:, LED_SHARE] = np.cumsum(self.factor) / self.factor.sum()
        return led


@kernel
def near(x, centre, period):
    """Return x from the nearest of the places centre + i · period."""
    x -= centre
    return x - period * math.floor(x / period + 0.5)


@kernel
def led_at(parameter, led, x, y):
    """Return the number of the LED whose top covers a place, or -1."""
    half_width, half_length = 0.5 * parameter[LED_WIDTH], 0.5 * parameter[LED_LENGTH]
    for i in range(len(led)):
        across = near(x, led[i, LED_X], parameter[PERIOD_ACROSS])
        along = near(y, led[i, LED_Y], parameter[PERIOD_ALONG])
        if abs(across) <= half_width and abs(along) <= half_length:
            return i
    return -1


@kernel
def in_hole(parameter, led, x, y):
    """Return whether a place on the board is within the hole of an LED."""
    radius = parameter[HOLE_RADIUS]
    if radius <= 0.0:
        return False
    for i in range(len(led)):
        across = near(x, led[i, LED_X], parameter[PERIOD_ACROSS])
        along = near(y, led[i, LED_Y], parameter[PERIOD_ALONG])
        if across * across + along * along <= radius * radius:
            return True
    return False


@kernel
def box_hit(x, y, dx, dy, cx, cy, half_width, half_length):
    """Return (distance, whether through a side across) at which a ray enters an upright box."""
    enter, leave, across = 0.0, math.inf, False
    if dx != 0.0:
        a, b = (cx - half_width - x) / dx, (cx + half_width - x) / dx
        near_x, leave = min(a, b), max(a, b)
        if near_x > enter:
            enter, across = near_x, True
    elif abs(x - cx) >= half_width:
        return math.inf, False
    if dy != 0.0:
        a, b = (cy - half_length - y) / dy, (cy + half_length - y) / dy
        if min(a, b) > enter:
            enter, across = min(a, b), False
        leave = min(leave, max(a, b))
    elif abs(y - cy) >= half_length:
        return math.inf, False
    if enter <= 0.0 or enter >= leave:
        return math.inf, False
    return enter, across


@kernel
def _side_hit(parameter, led, x, y, dx, dy, reach):
    """Return (distance, normal x, normal y) of the first side within `reach`, or (inf, 0, 0).

    The ray's way is cut into pieces no longer than a cell, so few boxes are near each.
    """
    across, along = parameter[PERIOD_ACROSS], parameter[PERIOD_ALONG]
    half_width, half_length = 0.5 * parameter[LED_WIDTH], 0.5 * parameter[LED_LENGTH]
    speed = math.sqrt(dx * dx + dy * dy)
    if speed == 0.0:
        return math.inf, 0.0, 0.0
    step = min(across, along) / speed
    start = 0.0
    for _ in range(_MOST_PIECES):
        end = min(start + step, reach)
        x0, x1 = x + start * dx, x + end * dx
        y0, y1 = y + start * dy, y + end * dy
        best, nx, ny = math.inf, 0.0, 0.0
        for i in range(len(led)):
            cx, cy = led[i, LED_X], led[i, LED_Y]
            first = math.ceil((min(x0, x1) - half_width - cx) / across)
            last = math.floor((max(x0, x1) + half_width - cx) / across)
            bottom = math.ceil((min(y0, y1) - half_length - cy) / along)
            top = math.floor((max(y0, y1) + half_length - cy) / along)
            for k in range(first, last + 1):
                for m in range(bottom, top + 1):
                    distance, through = box_hit(
                        x, y, dx, dy, cx + k * across, cy + m * along, half_width, half_length
                    )
                    if distance < best:
                        best = distance
                        nx = -math.copysign(1.0, dx) if through else 0.0
                        ny = 0.0 if through else -math.copysign(1.0, dy)
        if best <= end:
            return best, nx, ny
        if end >= reach:
            break
        start = end
    return math.inf, 0.0, 0.0


@kernel
def board_hit(parameter, led, x, y, z, dx, dy, dz):
    """Return what a ray meets over a board: (what, x, y, z, LED's number, normal)."""
    if dz == 0.0:
        return LOST, x, y, z, -1, 0.0, 0.0, 0.0
    top = parameter[LED_HEIGHT]
    if dz < 0.0 and z > top:
        flight = (top - z) / dz
        x, y, z = x + flight * dx, y + flight * dy, top
        number = led_at(parameter, led, x, y)
        if number >= 0:
            return LED_TOP, x, y, z, number, 0.0, 0.0, 1.0
    if z < top or (z == top and dz < 0.0 and top > 0.0):
        reach = ((top if dz > 0.0 else 0.0) - z) / dz
        distance, nx, ny = _side_hit(parameter, led, x, y, dx, dy, reach)
        if distance < reach:
            z = min(max(z + distance * dz, 0.0), top)
            return LED_SIDE, x + distance * dx, y + distance * dy, z, -1, nx, ny, 0.0
    end = parameter[HEIGHT] if dz > 0.0 else 0.0
    flight = (end - z) / dz
    what = OPENING if dz > 0.0 else REFLECTOR
    return what, x + flight * dx, y + flight * dy, end, -1, 0.0, 0.0, 0.0


@kernel
def board_reflectance(parameter, led, x, y):
    """Return (reflectance, whether a hole's) of the board at a place."""
    if in_hole(parameter, led, x, y):
        return parameter[HOLE_REFLECTANCE], True
    return parameter[REFLECTANCE], False


@kernel
def led_start(scene, rng):
    """Return a point and direction of the LEDs' light: (x, y, z, dx, dy, dz, LED's number).

    The LED is drawn by its flux, the point evenly on its top.
    """
    led, parameter = scene.led, scene.parameter[0]
    x, y = uniform(rng) - 0.5, uniform(rng) - 0.5
    dx, dy, dz = emitted_direction(scene.emission, rng)
    i = 0
    if len(led) > 1:
        share = uniform(rng)
        while i < len(led) - 1 and share >= led[i, LED_SHARE]:
            i += 1
    x = led[i, LED_X] + x * parameter[LED_WIDTH]
    y = led[i, LED_Y] + y * parameter[LED_LENGTH]
    return x, y, parameter[LED_HEIGHT], dx, dy, dz, i
