"""How well a fitted trace is known: from groove to groove, and from its residual's correlation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.model import FILL, PITCH, ROUNDING, SLOPE, Fitted
from mpfcad.film.stylus.residual import correlation_sum, shape_misfit
from mpfcad.film.stylus.slope import RISE, Held, held_fits

#: Grooves from which their own scatter gives the interval.
FEWEST_GROOVES = 4
_Z = 1.959964
#: The larger of two half-widths is too wide: this share of it holds 95 % of simulated truths.
SHARE = 0.8
#: Walls are in sight where ln(slope) is known to this, and the mean u is above that.
_IN_SIGHT, _COVERED = 0.01, 1.15
#: From groove to groove where they are too few to tell: relative standard deviation of u, assumed.
_DIFFER = 0.03
#: By how many ways to depart what the mean shape leaves is divided to be what it hides along one
#: that is sought. Circular menisci ask for so few.
_SHAPES = 3
#: A prior standard deviation of u that matters only where nothing depends on u.
_ANY_FILL = 1.0
#: What is unseen counts from so many linear half-widths on.
_FARTHER = 1.5
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
    """

    fill: Bounds
    curvature: Bounds
    slope: tuple[float, float]
    likely_slope: float
    log_pitch: float


def spread_of(fit: Fitted, *, scaled: bool = False) -> Spread:
    """Return what a fit leaves open. scaled: the heights' scale may be off, the walls are not.

    Noise: the larger of two. The scatter of the grooves' own u, by Student's t, holds noise of any
    correlation, waviness and grooves that differ; the residual's variance times the sum of its
    autocorrelation, propagated, holds what all grooves share. Of the two `SHARE` is taken. What the
    priors of pitch and slope leave open is added. Where the walls are hardly in sight, fits at all
    slopes that the trace allows take the place of derivatives (`held_fits`). A tip that does not
    reach the resin leaves it unseen.
    """
    residual = fit.model.residual(fit.value)
    correlation = correlation_sum(residual)
    width = len(fit.value) + fit.model.base.shape[1]
    left = max(len(residual) - width, 1)
    noise = max(float(np.sqrt(np.sum(residual**2) / left)), fit.noise) * np.sqrt(correlation)
    freedom = max(len(residual) / correlation - width, 2.0)
    half = _half_widths(fit, noise, freedom, held=False)
    mean, measured = max(float(np.mean(fit.fills)), 1e-6), max(fit.curvature, 1e-9)
    slope, steep = float(fit.value[SLOPE]), float(half[3])
    fill = _wide(mean, SHARE * float(half[0]))
    curvature = _wide(measured, measured * SHARE * float(half[1]))
    slopes = (slope * float(np.exp(-steep)), slope * float(np.exp(steep)))
    if steep > _IN_SIGHT or mean < _COVERED:
        fits = held_fits(fit, noise, scaled=scaled)
        held = SHARE * _half_widths(fit, noise, freedom, held=True)
        fill = _over(fits, [f.fill for f in fits], float(held[0]))
        curvature = _over(fits, [f.curvature for f in fits], measured * float(held[1]))
        stated = fit.model.groove.wall_slope
        slopes = (stated * float(np.exp(fits[0].off)), stated * float(np.exp(fits[-1].off)))
        slope = stated * float(np.exp(min(fits, key=lambda held: held.cost).off))
    far = [f if f > _FARTHER * float(half[0]) else 0.0 for f in _unseen(fit, noise)]
    return Spread(
        Bounds(fill.value, min(fill.low, mean - far[0]), max(fill.high, mean + far[1])),
        Bounds(
            curvature.value,
            min(curvature.low, measured * (1 - far[0] / mean)),
            max(curvature.high, measured * (1 + far[1] / mean)),
        ),
        slopes,
        slope,
        float(half[2]),
    )


def _wide(value: float, half: float) -> Bounds:
    return Bounds(value, value - half, value + half)


def _over(fits: list[Held], values: list[float], half: float) -> Bounds:
    """Return the likeliest value and how far all go, each with its half-width at its slope."""
    each = [half * max(1 - held.cost / RISE, 0.0) ** 0.5 for held in fits]
    return Bounds(
        values[int(np.argmin([held.cost for held in fits]))],
        min(v - h for v, h in zip(values, each, strict=True)),
        max(v + h for v, h in zip(values, each, strict=True)),
    )


def _half_widths(fit: Fitted, noise: float, freedom: float, *, held: bool) -> NDArray[np.float64]:
    """Return half-widths of mean u, ln C, ln pitch and ln slope, (4,), by derivatives.

    held: the slope is known.
    """
    from scipy.special import stdtrit

    free, design, prior = _design(fit, held=held)
    normal = design.T @ design
    known = noise**2 * prior.T @ prior
    size = np.sqrt(np.diag(normal + known))
    inverse = np.linalg.pinv((normal + known) / np.outer(size, size), rcond=1e-12, hermitian=True)
    wanted = _wanted(fit, free, design.shape[1]) / size @ inverse / size
    # As sums of squares: a difference of rounded products may fall below 0.
    by_noise = noise**2 * np.sum((wanted @ design.T) ** 2, axis=1)
    by_prior = noise**4 * np.sum((wanted @ prior[:3].T) ** 2, axis=1)
    half: NDArray[np.float64] = float(stdtrit(freedom, 0.975)) * np.sqrt(by_noise)
    count, mean = len(fit.fills), max(float(np.mean(fit.fills)), 1e-6)
    if count >= FEWEST_GROOVES:
        scatter = float(np.std(fit.fills, ddof=1) / np.sqrt(count) * stdtrit(count - 1.0, 0.975))
        half[:2] = np.maximum(half[:2], [scatter, scatter / mean])
    else:
        seen = max(round(float(np.ptp(fit.model.x) / fit.value[PITCH])), 1)
        scatter = _Z * _DIFFER / np.sqrt(seen)
        half[:2] = np.hypot(half[:2], [scatter * mean, scatter])
    # What a mean shape that is not the model's may hide along the values sought: its sum of squares
    # is as of a few ways to depart.
    shape = by_noise / noise**2 * len(design) * shape_misfit(fit) ** 2 / _SHAPES
    return np.sqrt(half**2 + _Z**2 * (by_prior + shape))


def _design(
    fit: Fitted, *, held: bool
) -> tuple[list[int], NDArray[np.float64], NDArray[np.float64]]:
    """Return the free values, their columns and the base's (n, k), and the priors' rows (…, k).

    held: without the slope.
    """
    model = fit.model
    columns = model.jacobian(fit.value)
    low, high = model.bounds()
    # A rounding at its bound moves to one side only: it is taken as known.
    inside = low[ROUNDING] + 1e-6 < fit.value[ROUNDING] < high[ROUNDING]
    free = [i for i in range(columns.shape[1]) if (i != ROUNDING or inside)]
    free = [i for i in free if not (held and i == SLOPE)]
    design = np.column_stack([columns[:, free], model.base])
    prior = np.zeros((3 + model.grooves, design.shape[1]))
    prior[:3, : len(free)] = model.prior_jacobian()[:, free]
    for k in range(model.grooves):
        prior[3 + k, free.index(FILL + k)] = 1 / _ANY_FILL
    return free, design, prior


def _wanted(fit: Fitted, free: list[int], width: int) -> NDArray[np.float64]:
    """Return the derivatives of mean u, ln C, ln pitch and ln slope by the columns, (4, width)."""
    value, mean = fit.value, max(float(np.mean(fit.fills)), 1e-6)
    rows = np.zeros((4, width))
    for k in np.flatnonzero(fit.whole):
        rows[0, free.index(FILL + int(k))] = 1 / len(fit.fills)
    rows[1] = rows[0] / mean
    if SLOPE in free:
        rows[1, free.index(SLOPE)] = rows[3, free.index(SLOPE)] = 1 / value[SLOPE]
    rows[1, free.index(PITCH)] = -1 / value[PITCH]
    rows[2, free.index(PITCH)] = 1 / value[PITCH]
    return rows


def _unseen(fit: Fitted, noise: float) -> tuple[float, float]:
    """Return how far all u can be moved together, down and up, and not be told from the fit.

    Told is what changes the trace, less what pitch, centre, rounding and base make up for, by more
    than 95 % of noise does: a sum of squares above 3.84 of its variance.
    """
    model, value = fit.model, fit.value
    free, design, _ = _design(fit, held=True)
    other = design[:, [i for i in range(design.shape[1]) if i >= len(free) or free[i] < FILL]]
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
