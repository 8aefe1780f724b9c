"""What a fit leaves of a trace that all grooves share."""

import numpy as np

from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import CENTRE, PITCH
from mpfcad.film.stylus.solve import Fitted

#: Share of the relief by which the grooves' mean shape may differ from the model before it is said.
SAID = 0.015
#: Parts of a pitch whose mean residuals are looked at.
_PARTS = 25
#: A sum of so many squares is above this many times its mean with a chance below 1e-4.
_CHANCE = 2.4


def misfit_share(fit: Fitted) -> float:
    """Return `shape_misfit` over the relief's standard deviation."""
    relief = float(np.std(fit.model.levelled(fit.value)))
    return shape_misfit(fit) / relief if relief > 0 else 1.0


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
