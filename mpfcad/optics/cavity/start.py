"""Where the light of a cavity starts: a point and a direction on one of its emitters."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.cavity.board import led_start
from mpfcad.optics.cavity.endless import tube_start
from mpfcad.optics.cavity.finite import lamp_start


@kernel
def cavity_start(scene, y, rng):
    """Return (x, y, z, dx, dy, dz, emitter's number) of a path of the cavity's own light.

    `y` [mm] is used where nothing changes along y.
    """
    if len(scene.led) > 0:
        return led_start(scene, rng)
    if len(scene.lamp) > 0:
        return lamp_start(scene.parameter[0], scene.wall, scene.lamp, rng)
    x, z, dx, dy, dz = tube_start(scene.parameter[0], rng)
    return x, y, z, dx, dy, dz, 0
