"""Whether a trace shows grooves at all: what the fit leaves of their mean shape."""

import numpy as np

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.stylus.model import PITCH
from mpfcad.film.stylus.residual import SAID, shape_misfit
from mpfcad.film.stylus.solve import Fitted
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.film.stylus.upright import lie_of
from mpfcad.units import um

#: A trace whose residual exceeds this share of its own standard deviation shows no such groove.
UNEXPLAINED = 0.5
#: Grooves whose C differ by more than this share of their mean, standard deviation, are not alike.
_UNLIKE = 0.35
#: Shares of the relief by which the grooves' mean shape may differ from the model before it is
#: asked whether upside down it fits as well, and before it is refused in any case. A meniscus of a
#: circle's shape differs by up to 5 %, and far more upside down; a sine by 2 … 26 %, either way.
_ASKED, _REFUSED = 0.04, 0.08


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
    _refuse_unlike(trace, fit)
    off = shape_misfit(fit)
    options = (groove, fit.model.profile, trace.tip)
    if off > _REFUSED * relief or (
        off > _ASKED * relief and lie_of(trace.position, trace.height, *options).way != "up"
    ):
        raise InputError(
            f"{trace.name}: z_um: the grooves' mean shape is {off / um:.3g} µm rms off walls and "
            f"parabola, {off / relief:.0%} of {relief / um:.3g} µm of relief: expected a trace "
            f"across grooves of pitch {groove.pitch / um:g} µm and depth {groove.depth / um:g} µm"
        )
    if off > SAID * relief:
        return [
            f"the grooves' mean shape is {off / um:.2g} µm rms off walls and parabola, "
            f"{off / relief:.1%} of the relief, more than noise: are these such grooves?"
        ]
    return []


def _refuse_unlike(trace: StylusTrace, fit: Fitted) -> None:
    """Refuse grooves of which some are, and others are not; noise may make a flat groove's C."""
    each = fit.curvature_of_each
    if len(each) < 4:
        return
    mean, seen = float(np.mean(each)), fit.value[PITCH] ** 2 / 8 / fit.noise
    spread = float(np.std(each)) - 3 / seen
    if spread > _UNLIKE * mean:
        raise InputError(
            f"{trace.name}: z_um: the grooves' C are {each.min():.3g} … {each.max():.3g} /mm: "
            "expected grooves that are alike, of one coupon"
        )
