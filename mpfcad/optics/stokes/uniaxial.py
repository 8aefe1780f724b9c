"""A uniaxial plate, such as a stretched base, whose optic axis lies in its plane.

Light splits into the ordinary wave, which is polarised across the ray and the axis o, and the
extraordinary one, whose index at an angle ψ to the axis is n + Δn sin² ψ to the first order in Δn
(Born and Wolf, 15.3). Along a path of length s it falls behind by

    Γ = 2π/λ · Δn · sin² ψ · s.

Both waves keep the ray's way: they part by about Δn only, which is 0.1 at most of stretched films.
"""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.stokes.state import change, refer_to


@kernel
def delay(light, rate, ox, oy, length, dx, dy, dz):
    """Delay the extraordinary wave of a state along a path within the plate.

    `rate`: radians a mm across the axis (ox, oy, 0); `length`: of the path [mm]. Nothing happens
    without a state.
    """
    if light is not None:
        _delay(light, rate, ox, oy, length, dx, dy, dz)


@kernel
def _delay(light, rate, ox, oy, length, dx, dy, dz):
    tx, ty, tz = -dz * oy, dz * ox, dx * oy - dy * ox
    square = tx * tx + ty * ty + tz * tz
    if rate != 0.0 and square > 0.0:
        scale = 1.0 / math.sqrt(square)
        refer_to(light, scale * tx, scale * ty, scale * tz, dx, dy, dz)
        phase = rate * square * length
        # The ordinary wave, along the state's first axis, comes earlier.
        change(light, 1.0, 0.0, math.cos(phase), math.sin(phase))
