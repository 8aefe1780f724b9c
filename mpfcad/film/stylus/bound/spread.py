"""How well a fitted trace is known: from groove to groove, and from its residual's correlation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.bound.below import Below, below_tips
from mpfcad.film.stylus.bound.empty import may_be_empty
from mpfcad.film.stylus.bound.half_width import design_of, half_widths
from mpfcad.film.stylus.bound.response import Response, response_of
from mpfcad.film.stylus.bound.slope import Held, held_fits
from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import CENTRE, FILL, PITCH, ROUNDING, SLOPE, WETTING
from mpfcad.film.stylus.solve import RISE, Fitted

#: The larger of two half-widths is too wide: this share of it holds 95 % of simulated truths.
SHARE = 0.8
#: Walls are in sight where ln(slope) is known to this, and the mean u is above that.
_IN_SIGHT, _COVERED = 0.01, 1.15
#: What is unseen counts from so many linear half-widths on.
_FARTHER = 1.5
#: So many times what a response is told to move C, it may: its shape between its lags is not known.
_RESPONSE = 2.0
#: What is let to make up for a shift of all u, beside the base.
_MADE_UP = (CENTRE, PITCH, ROUNDING)
#: Common shifts of all u that are tried, a side.
_SHIFTS = 60


@dataclass(frozen=True)
class Bounds:
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Spread:
    """What a fit leaves open, 95 %.

    Attributes
    ----------
    fill, curvature
        the mean u, and C [1/mm]
    slope, likely_slope
        the least and the largest slope of the walls, and the likeliest
    log_pitch
        half-width of ln(pitch)
    shape
        half-widths of wetting, roundness and flatness
    response
        the instrument's, as far as the residual tells it; the intervals hold it
    """

    fill: Bounds
    curvature: Bounds
    slope: tuple[float, float]
    likely_slope: float
    log_pitch: float
    shape: tuple[float, float, float]
    response: Response


def spread_of(fit: Fitted, *, scaled: bool = False) -> Spread:
    """Return what a fit leaves open. scaled: the heights' scale may be off, the walls are not.

    Noise: the larger of two. The scatter of the grooves' own u, by Student's t, holds noise of any
    correlation, waviness and grooves that differ; the residual's variance times the sum of its
    autocorrelation, propagated, holds what all grooves share. Of the two `SHARE` is taken. What the
    priors of pitch and slope leave open is added. Where the walls are hardly in sight, fits at all
    slopes that the trace allows take the place of derivatives (`held_fits`). A tip that does not
    reach the resin leaves it unseen. A response of the instrument that the residual tells
    (`response_of`) goes on top, to its side.
    """
    residual = fit.model.residual(fit.value)
    correlation = correlation_sum(residual)
    width = len(fit.value) + fit.model.base.shape[1]
    left = max(len(residual) - width, 1)
    noise = max(float(np.sqrt(np.sum(residual**2) / left)), fit.noise) * np.sqrt(correlation)
    freedom = max(len(residual) / correlation - width, 2.0)
    design = design_of(fit, noise)
    at_tips = (WETTING,) if fit.at_tips else ()
    below = below_tips(fit, noise) if at_tips else Below(0.0, 0.0)
    half = half_widths(fit, design, noise, freedom, at_tips)
    mean, measured = max(float(np.mean(fit.fills)), 1e-6), max(fit.curvature, 1e-9)
    slope, steep = float(fit.value[SLOPE]), float(half[3])
    sides = _sides(half, mean, below)
    fill = Bounds(mean, mean - sides[0, 0], mean + sides[0, 1])
    curvature = Bounds(measured, measured * (1 - sides[1, 0]), measured * (1 + sides[1, 1]))
    slopes = (slope * float(np.exp(-steep)), slope * float(np.exp(steep)))
    if steep > _IN_SIGHT or mean < _COVERED:
        fits = held_fits(fit, noise, scaled=scaled)
        held = _sides(half_widths(fit, design, noise, freedom, (*at_tips, SLOPE)), mean, below)
        fill = _over(fits, [f.fill for f in fits], held[0])
        curvature = _over(fits, [f.curvature for f in fits], measured * held[1])
        stated = fit.model.groove.wall_slope
        slopes = (stated * float(np.exp(fits[0].off)), stated * float(np.exp(fits[-1].off)))
        slope = stated * float(np.exp(min(fits, key=lambda held: held.cost).off))
    response = response_of(fit, design, noise, at_tips)
    late = _RESPONSE * np.array([response.u, measured * response.log_curvature])
    less, more = np.maximum(late, 0.0), np.maximum(-late, 0.0)
    far = [f if f > _FARTHER * float(half[0]) else 0.0 for f in _unseen(fit, design, noise)]
    if may_be_empty(fit, noise):
        far[1] = fit.model.top - mean
    return Spread(
        Bounds(
            fill.value,
            min(fill.low - float(less[0]), mean - far[0]),
            max(fill.high + float(more[0]), mean + far[1]),
        ),
        Bounds(
            curvature.value,
            min(curvature.low - float(less[1]), measured * (1 - far[0] / mean)),
            max(curvature.high + float(more[1]), measured * (1 + far[1] / mean)),
        ),
        slopes,
        slope,
        float(half[2]),
        (max(float(half[4]), -below.wetting), float(half[5]), float(half[6])),
        response,
    )


def _sides(half: NDArray[np.float64], mean: float, below: Below) -> NDArray[np.float64]:
    """Return how far down and up mean u and ln C go, (2, 2), resin below the tips as well."""
    sides = SHARE * np.stack([half[:2], half[:2]], axis=1)
    sides[:, int(below.u > 0)] = np.hypot(sides[:, int(below.u > 0)], [below.u, below.u / mean])
    return sides


def _over(fits: list[Held], values: list[float], half: NDArray[np.float64]) -> Bounds:
    """Return the likeliest value and how far all go, each with its half-widths at its slope."""
    part = [max(1 - held.cost / RISE, 0.0) ** 0.5 for held in fits]
    return Bounds(
        values[int(np.argmin([held.cost for held in fits]))],
        min(v - float(half[0]) * p for v, p in zip(values, part, strict=True)),
        max(v + float(half[1]) * p for v, p in zip(values, part, strict=True)),
    )


def _unseen(fit: Fitted, columns: NDArray[np.float64], noise: float) -> tuple[float, float]:
    """Return how far all u can be moved together, down and up, and not be told from the fit.

    Told is what changes the trace, less what pitch, centre, rounding and base make up for, by more
    than 95 % of noise does: a sum of squares above 3.84 of its variance.
    """
    model, value = fit.model, fit.value
    count = len(value)
    other = columns[:, [i for i in range(columns.shape[1]) if i in _MADE_UP or i >= count]]
    other = np.linalg.qr(other)[0]
    there, mean = model.surface(value), float(np.mean(fit.fills))
    found = []
    for sign in (-1.0, 1.0):
        reach = mean if sign < 0 else model.top - mean
        last = 0.0
        for step in np.linspace(0.0, 1.0, _SHIFTS + 1)[1:] ** 2 * max(reach, 0.0):
            moved = value.copy()
            moved[FILL:] = np.clip(value[FILL:] + sign * step, 0.0, model.top)
            change = model.surface(moved) - there
            change = change - other @ (other.T @ change)
            if float(np.sum(change**2)) > RISE * noise**2:
                break
            last = float(abs(np.mean(moved[FILL:][fit.whole]) - mean))
        found.append(last)
    return found[0], found[1]
