"""The rays that wait before the cavity: which of them are followed sixteen at a time."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import WIDE
from mpfcad.optics.base.recorder import FLOW_ELEMENTS
from mpfcad.optics.cavity.endless import BRDF, NO_LAMP
from mpfcad.optics.cavity.endless_lanes import cavity_passages
from mpfcad.optics.spectral.hue import is_coloured


@kernel
def pass_cavity_queue(scene, rays, wave, flow, score, hue):
    """Follow through the cavity what goes sixteen rays at a time; return how many rays that were.

    These are put first: what does not start on a lamp, under an endless row of tubes over a
    reflector that is no table, which treats all bands alike.
    """
    if len(scene.led) > 0 or len(scene.lamp) > 0 or scene.parameter[0, BRDF] >= 0.0:
        return 0
    if is_coloured(hue, 0):
        return 0
    landed = flow[FLOW_ELEMENTS + len(scene.kind) :]
    count = 0
    for i in range(len(rays)):
        if wave.lamp[rays[i]] == NO_LAMP:
            rays[count], rays[i] = rays[i], rays[count]
            count += 1
    for i in range(0, count, WIDE):
        cavity_passages(
            scene.parameter[0],
            scene.glow,
            rays[i : min(i + WIDE, count)],
            wave,
            flow,
            landed,
            score,
            hue,
        )
    return count
