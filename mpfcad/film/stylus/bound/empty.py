"""Whether a trace may be that of grooves without resin: what a blunt tip does not reach.

A ball that the walls hold up draws the same arc over a bare groove and over little resin, and a fit
finds resin there of some shape and level. No shift of its fill alone leads from there to the empty
groove, so that groove is fitted itself.
"""

from dataclasses import replace

import numpy as np

from mpfcad.film.stylus.model import FILL
from mpfcad.film.stylus.solve import Fitted, solve

#: Less resin than this mean u is looked for; a covered groove is not empty.
_LITTLE = 1.2
#: Share of the grooves that may hold dirt: those whose sums rise most tell nothing.
_DIRTY = 1 / 6
#: Share of a sum that the last step of a fit gains.
_CLOSE = 1e-5


def may_be_empty(fit: Fitted, noise: float) -> bool:
    """Return whether the empty groove fits as well, at 95 % of χ² for the values that it has less.

    noise: of heights [mm], as if they were independent.
    """
    model, value = fit.model, fit.value
    if not _LITTLE < float(np.mean(fit.fills)) < model.top or model.profile != "filled":
        return False
    from scipy.stats import chi2

    empty = replace(model, least_fill=model.top)
    tried = value.copy()
    tried[FILL:] = model.top
    found = solve(empty, tried, noise, close=_CLOSE)
    change = empty.residual(found) ** 2 - model.residual(value) ** 2
    each = np.sort(np.bincount(model.number(value), change, model.grooves))
    kept = len(each) - int(np.ceil(_DIRTY * len(each))) if len(each) > 1 else 1
    return bool(np.sum(each[:kept]) / noise**2 < chi2.ppf(0.95, kept + 2))
