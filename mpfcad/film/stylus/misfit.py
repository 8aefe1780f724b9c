"""Whether a trace shows grooves at all: what the fit leaves of their mean shape."""

import numpy as np

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.stylus.model import CENTRE, PITCH, Fitted
from mpfcad.film.stylus.spread import correlation_sum
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import um

#: A trace whose residual exceeds this share of its own standard deviation shows no such groove.
UNEXPLAINED = 0.5
#: Shares of the relief by which the grooves' mean shape may differ from the model before it is
#: said, and before the trace is refused. A sine of the same pitch differs by 3 … 26 %.
_SAID, _REFUSED = 0.015, 0.08
#: Parts of a pitch whose mean residuals are looked at.
_PARTS = 25
#: A sum of so many squares is above this many times its mean with a chance below 1e-4.
_CHANCE = 2.4


def check_shape(trace: StylusTrace, fit: Fitted, groove: Groove) -> list[str]:
    """Return what is to be said of a trace whose shape is not quite a groove's.

    Raises
    ------
    InputError
        when it shows none of this pitch and depth.
    """
    relief = float(np.std(fit.model.levelled(fit.value)))
    if not fit.rms <= UNEXPLAINED * relief:
        raise InputError(
            f"{trace.name}: z_um: residual {fit.rms / um:.3g} µm rms of {relief / um:.3g} µm of "
            f"relief: expected a trace that shows grooves of pitch {groove.pitch / um:g} µm and "
            f"depth {groove.depth / um:g} µm"
        )
    off = shape_misfit(fit)
    if off > _REFUSED * relief:
        raise InputError(
            f"{trace.name}: z_um: the grooves' mean shape is {off / um:.3g} µm rms off walls and "
            f"parabola, {off / relief:.0%} of {relief / um:.3g} µm of relief: expected a trace "
            f"across grooves of pitch {groove.pitch / um:g} µm and depth {groove.depth / um:g} µm"
        )
    if off > _SAID * relief:
        return [
            f"the grooves' mean shape is {off / um:.2g} µm rms off walls and parabola, "
            f"{off / relief:.1%} of the relief, more than noise: are these such grooves?"
        ]
    return []


def shape_misfit(fit: Fitted) -> float:
    """Return by how much the mean groove differs from the model, rms [mm]; 0 if noise may do that.

    The residual's mean in each 25th of a pitch over all grooves; what its scatter about that mean
    gives by chance is taken off.
    """
    model, value = fit.model, fit.value
    residual = model.residual(value)
    turn = (model.x - value[CENTRE]) / value[PITCH] + 0.5
    part = np.minimum((turn % 1 * _PARTS).astype(np.int64), _PARTS - 1)
    count = np.maximum(np.bincount(part, minlength=_PARTS), 1)
    mean = np.bincount(part, residual, _PARTS) / count
    noise = residual - mean[part]
    # Neighbours in a part and a groove may be off together.
    together = np.maximum(count * value[PITCH] / np.ptp(model.x), 1.0)
    inflated = np.minimum(correlation_sum(noise), together)
    chance = float(np.mean(np.bincount(part, noise**2, _PARTS) / count**2 * inflated))
    found = float(np.mean(mean**2))
    return float(np.sqrt(found - chance)) if found > _CHANCE * chance else 0.0
