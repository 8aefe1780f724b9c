"""The tips that may have traced a film: the stated one, or the usual ones."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import MOST_OFF, ROUNDING
from mpfcad.film.stylus.solve import RISE, Fitted
from mpfcad.film.stylus.tip import USUAL_ANGLE, USUAL_ANGLES, USUAL_RADII, StylusTip
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import deg, nm, um

#: A tip whose fit leaves this much more variance than the best one did not trace the film. No
#: meniscus is known to be of the model's shape to less than this misfit [mm].
WORSE, ALIKE = 1.25, 15 * nm
#: The radius that a stated tip is compared with, as a share of its own.
SHARPER = 0.75

#: Halvings between the largest usual radius that fits and the next.
_HALVINGS = 3
#: A stated tip is doubted where a larger one's sum of squares and priors is so much less.
_DOUBTED = 2.0

#: Fits a trace with a tip.
Fit = Callable[[StylusTip | None], Fitted]


@dataclass(frozen=True)
class TipFits:
    """The fits of all tips that may have traced a film.

    Attributes
    ----------
    fits
        the one whose value is told first
    notes
        why there are several; none where the tip is known
    cones
        the full angles [rad] that the tip may have
    """

    fits: list[Fitted]
    notes: list[str]
    cones: tuple[float, ...]


def fits_of_tips(trace: StylusTrace, fitted: Fit) -> TipFits:
    """Return the fits of all tips that may have traced the film.

    Without a stated tip the value is the median's of the usual ones that fit: what an unknown tip
    adds goes one way.
    """
    sharp = fitted(None)
    why = "tip not stated"
    if trace.tip is not None:
        found = _of_stated(trace.tip, sharp, fitted)
        if found is not None:
            return found
        why = (
            f"the trace is sharper than its tip of {trace.tip.radius / um:g} µm can draw, so the "
            "tip is taken as unknown"
        )
    fits = [sharp]
    for radius in USUAL_RADII:
        fits.append(fitted(StylusTip(radius)))
        # Once a tip is too large, every larger one is.
        if fits[-1].misfit > 2 * max(min(fit.misfit for fit in fits), ALIKE):
            break
    usual, above = _that_fit(fits)
    told = [fit for fit, left in zip(usual, left_as_read(usual), strict=True) if not left]
    usual = [*_median_first(told), *(fit for fit in usual if fit not in told)]
    worn = _between(usual, above, fitted) if above else []
    fits, _ = _that_fit([*usual, *worn])
    return TipFits(fits, [f"{why}; {_tip_words(fits)}"], USUAL_ANGLES)


def _that_fit(fits: list[Fitted]) -> tuple[list[Fitted], Fitted | None]:
    """Return the fits that leave nearly as little as the best, and the first that is too large."""
    best = min(fits, key=lambda fit: fit.misfit)
    kept = [fit for fit in fits if fit.misfit**2 <= _worst(best)]
    largest = max(_radius(fit) for fit in kept)
    return kept, next((fit for fit in fits if _radius(fit) > largest), None)


def left_as_read(fits: Sequence[Fitted]) -> list[bool]:
    """Return which fits leave more than noise allows, and count only since no shape is exact.

    What such a tip draws wrongly is not made up for by another scale of the heights.
    """
    best = min(fit.misfit for fit in fits)
    return [fit.misfit**2 > WORSE * best**2 for fit in fits]


def _worst(best: Fitted) -> float:
    """Return the square of the misfit [mm] up to which another tip fits as well as the best."""
    return float(WORSE * max(best.misfit, ALIKE) ** 2)


def _between(usual: list[Fitted], above: Fitted, fitted: Fit) -> list[Fitted]:
    """Return fits of radii between the largest usual one that fits and the next.

    A worn tip is none of the usual ones. Prism tips that are a little round make up for one that
    is too small, but the resin then reads too steep.
    """
    low, high, found = max(map(_radius, usual)), _radius(above), list[Fitted]()
    best = min(usual, key=lambda fit: fit.misfit)
    for _ in range(_HALVINGS):
        found.append(fitted(StylusTip((low + high) / 2)))
        best = min(best, found[-1], key=lambda fit: fit.misfit)
        if found[-1].misfit ** 2 <= _worst(best):
            low = (low + high) / 2
        else:
            high = (low + high) / 2
    return found


def _of_stated(tip: StylusTip, sharp: Fitted, fitted: Fit) -> TipFits | None:
    """Return the fits of a stated tip; None where the trace is sharper than it can draw."""
    if tip.radius == 0:
        return TipFits([sharp], [], ())
    stated, *other = tip.told(sharp.model.groove.wall_slope * (1 + MOST_OFF))
    told = fitted(stated)
    for usual in map(fitted, other):
        if _worst(usual) < told.misfit**2 and usual.misfit**2 <= _worst(sharp):
            words = (
                f"the walls are steeper than the tip's cone of {tip.angle / deg:g}° can draw: "
                "the heights' scale is off, or its angle is another"
            )
            return TipFits([usual], [words], (USUAL_ANGLE,))
    # A radius is known to a quarter: the trace must be sharper than that, too.
    if told.misfit**2 > _worst(sharp):
        sharper = fitted(replace(tip, radius=SHARPER * tip.radius))
        if sharper.misfit <= 0.98 * told.misfit:
            return None
    blunter, off = _blunter(tip, told, fitted), tip.radius_off
    ends = [replace(tip, radius=max(tip.radius + part, 0.0)) for part in (-off, off) if off]
    edges = list(map(fitted, ends))
    if blunter:
        words = (
            f"the prism tips look rounded by {told.value[ROUNDING] / um:.2g} µm beside the stated "
            f"tip of {tip.radius / um:g} µm; one of {_radii(blunter)[-1]:.3g} µm is likelier: the "
            "interval holds both"
        )
        return TipFits([*_median_first([told, *blunter]), *edges], [words], (tip.angle,))
    return TipFits([told, *edges], [], (tip.angle,))


def _blunter(tip: StylusTip, told: Fitted, fitted: Fit) -> list[Fitted]:
    """Return the fits of usual tips that are larger than a stated one and likelier than it.

    What a ball draws over a prism tip is as round as both together. A prism tip is rounded by a
    micrometre or so; where it had to be more, and a larger ball draws all else as well, the stated
    one is doubted.
    """
    whole = tip.radius + float(told.value[ROUNDING])
    larger = [r for r in USUAL_RADII if 1.1 * tip.radius < r <= 1.25 * whole]
    rises = [(_rise(told, fit), fit) for fit in (fitted(replace(tip, radius=r)) for r in larger)]
    least = min((rise for rise, _ in rises), default=0.0)
    return [fit for rise, fit in rises if rise < least + RISE] if least < -_DOUBTED else []


def _rise(one: Fitted, other: Fitted) -> float:
    """Return how much larger another fit's sum of squares and priors is, of the same heights."""
    model = replace(one.model, tip=other.model.tip)
    left, there = one.model.residual(one.value), model.residual(other.value)
    noise = one.noise * np.sqrt(correlation_sum(left))
    rise = (np.sum(there**2) - np.sum(left**2)) / noise**2
    rise += np.sum(model.prior(other.value) ** 2) - np.sum(model.prior(one.value) ** 2)
    return float(rise)


def _median_first(fits: list[Fitted]) -> list[Fitted]:
    """Return fits with the one first that has the median C; of two in the middle the less."""
    ordered = sorted(fits, key=lambda fit: fit.curvature)
    first = ordered[(len(ordered) - 1) // 2]
    return [first, *(fit for fit in fits if fit is not first)]


def _tip_words(fits: Sequence[Fitted]) -> str:
    """Return which tips fit a trace, and what the interval makes of it."""
    radii = _radii(fits)
    least = f"{radii[0]:.2g} µm" if radii[0] else "sharp"
    if len(fits) == 1:
        return f"only a tip that is {least} fits"
    return f"tips from {least} to {radii[-1]:.2g} µm fit: the interval holds all of them"


def _radii(fits: Sequence[Fitted]) -> list[float]:
    """Return radii in µm, rising; 0 of a sharp tip."""
    return sorted(_radius(fit) / um for fit in fits)


def _radius(fit: Fitted) -> float:
    return fit.model.tip.radius if fit.model.tip else 0.0
