"""The roulette that ends faint paths without bias."""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.recorder import FLOW_ROULETTE
from mpfcad.optics.base.sampling import uniform

#: Weight below which a path is faint.
ROULETTE_BELOW = 0.1


@kernel
def roulette(weight, flow, rng):
    """End a faint path half of the time, and double it otherwise; `flow` keeps the difference."""
    if weight >= ROULETTE_BELOW or weight == 0.0:
        return weight
    if uniform(rng) < 0.5:
        flow[FLOW_ROULETTE] += weight
        return 0.0
    flow[FLOW_ROULETTE] -= weight
    return 2.0 * weight
