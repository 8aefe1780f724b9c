"""The least-squares fit of a trace by Levenberg and Marquardt's method, spikes left out."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import (
    FILL,
    FLATNESS,
    LIKELY_ROUND,
    PITCH,
    ROUNDNESS,
    SLOPE,
    WETTING,
    TraceModel,
)
from mpfcad.units import nm, um

#: The least noise assumed: that of heights printed to a nanometre or two.
LEAST_NOISE = 0.5 * nm
#: 95 % of χ² with one degree of freedom.
RISE = 3.841459
#: Mean u up to which resin may reach the tips, and a wetting that is no more than theirs.
_COVERED, _WET = 1.1, 1e-3
#: Share of the walls' slope at which resin is level, or along the walls.
_END = 1e-3
#: Curvatures and wettings tried before the fit.
_GRID, _WETTINGS = 21, (0.3, 0.0, -0.3, -0.6)
#: Steps of a fit at most.
_STEPS = 40
#: A height this many robust standard deviations off is a spike, unless it is less than 0.1 µm.
_SPIKE, _SPIKE_LEAST, _SPIKE_SHARE = 6.0, 0.1 * um, 0.2


@dataclass(frozen=True, eq=False)
class Fitted:
    """The values that fit best, the heights they were fitted to, and the noise [mm] assumed.

    `every` is the model of all heights, those left out as spikes too, and `misfit` is the mean
    absolute residual [mm] of them: a tip that is too large leaves its misfit at the prism tips,
    where it looks like spikes.
    """

    model: TraceModel
    value: NDArray[np.float64]
    noise: float
    misfit: float
    every: TraceModel

    @property
    def fills(self) -> NDArray[np.float64]:
        """The u of each groove that is seen whole enough to tell it, (k,)."""
        return self.value[FILL:][self.whole]

    @property
    def whole(self) -> NDArray[np.bool_]:
        """Which grooves have at least half of the heights of a typical one, (grooves,)."""
        count = np.bincount(self.model.number(self.value), minlength=self.model.grooves)
        kept: NDArray[np.bool_] = count >= 0.5 * np.median(count)
        return kept

    @property
    def curvature_of_each(self) -> NDArray[np.float64]:
        """C [1/mm] of the fill of each groove that is seen whole enough, (k,)."""
        each: NDArray[np.float64] = self.fills * self.value[SLOPE] / (self.value[PITCH] / 2)
        return each

    @property
    def curvature(self) -> float:
        """Mean C [1/mm] of the fills."""
        return float(np.mean(self.curvature_of_each))

    @property
    def at_tips(self) -> bool:
        """Whether resin is taken to reach the tips."""
        return self.model.wettings[0] == 0 and float(self.value[WETTING]) < _WET

    @property
    def rms(self) -> float:
        """Root mean square of the residual [mm]."""
        return float(np.sqrt(np.mean(self.model.residual(self.value) ** 2)))


def fit_model(whole: TraceModel) -> Fitted:
    """Return the least-squares fit of a model, spikes left out."""
    # At the stated slope first: walls that are steeper than the tip's cone show nothing of theirs.
    model, value = replace(whole, held_slope=whole.groove.wall_slope), _start(whole)
    noise = 50 * nm
    for robust, close in ((True, 1e-4), (False, 1e-4), (False, 1e-6)):
        value = solve(model, value, noise, robust=robust, close=close)
        residual = whole.residual(value)
        spread = 1.4826 * float(np.median(np.abs(residual - np.median(residual))))
        off = np.abs(residual) > max(_SPIKE * spread, _SPIKE_LEAST)
        off = np.convolve(off, np.ones(3), "same") > 0
        model = whole.at(~off) if 0 < np.mean(off) < _SPIKE_SHARE else whole
        noise = max(float(np.std(model.residual(value))), LEAST_NOISE)
    value = _off_the_ends(model, value, noise)
    model, value = _up_to_the_tips(model, value, noise)
    misfit = float(np.mean(np.abs(whole.residual(value))))
    return Fitted(model, value, noise, max(misfit, LEAST_NOISE), whole)


def _off_the_ends(
    model: TraceModel, value: NDArray[np.float64], noise: float
) -> NDArray[np.float64]:
    """Return the better of a fit and one begun at a parabola, where all resin is level or along.

    There less wetting, or more, changes nothing: a fit that came there stays.
    """
    steep, slope = float(value[SLOPE]), model.menisci(value).slope
    if model.profile == "ideal" or np.any((slope > _END * steep) & (slope < (1 - _END) * steep)):
        return value
    start = value.copy()
    start[[WETTING, ROUNDNESS, FLATNESS]] = 0.0, LIKELY_ROUND, 0.0
    found = solve(model, start, noise, close=1e-6)
    costs = [_weighted(model, each, noise, False)[2] for each in (value, found)]
    return found if costs[1] < costs[0] else value


def _up_to_the_tips(
    model: TraceModel, value: NDArray[np.float64], noise: float
) -> tuple[TraceModel, NDArray[np.float64]]:
    """Return the fit with resin up to the tips where it covers the walls and the trace allows that.

    Resin cannot stand above the tips: a fit that is free to put it below errs to one side.
    """
    if not (value[WETTING] < _WET and np.mean(value[FILL:]) < _COVERED):
        return model, value
    held = replace(model, wettings=(0.0, 1.0))
    start = value.copy()
    start[WETTING] = 0.0
    found = solve(held, start, noise, close=1e-6)
    free, residual = model.residual(value), held.residual(found)
    noise *= np.sqrt(correlation_sum(free))
    worse = (np.sum(residual**2) - np.sum(free**2)) / noise**2
    worse += np.sum(held.prior(found) ** 2) - np.sum(model.prior(value) ** 2)
    return (held, found) if worse < RISE else (model, value)


def solve(
    model: TraceModel,
    value: NDArray[np.float64],
    noise: float,
    *,
    robust: bool = False,
    close: float,
) -> NDArray[np.float64]:
    """Return the least-squares values within their bounds, for a noise [mm].

    Levenberg and Marquardt's method over the values that are not held at a bound; steps are clipped
    to the bounds. A step is one of slope and u·slope: a covered groove shows that product alone, so
    that u and slope by themselves would be stiff. `robust`: heights count as √(1 + r²) from three
    deviations on. `close`: the share of the sum that a last step gains.
    """
    low, high = model.bounds()
    value, damping = np.clip(value, low, high), 1e-3
    left, residual, cost = _weighted(model, value, noise, robust)
    for _ in range(_STEPS):
        slope = model.jacobian(value, central=False)
        slope = slope - model.base @ (model.base.T @ slope)
        weight = _weight(left / noise, robust)
        rows = np.concatenate([slope * (-weight / noise)[:, None], model.prior_jacobian(value)])
        rows[:, FILL:] /= value[SLOPE]
        rows[:, SLOPE] -= rows[:, FILL:] @ value[FILL:]
        gradient, normal = rows.T @ residual, rows.T @ rows
        held = ((value <= low) & (gradient > 0)) | ((value >= high) & (gradient < 0))
        free = np.flatnonzero(~held)
        inner = normal[np.ix_(free, free)]
        size = np.maximum(np.diag(inner), 1e-12 * np.diag(normal).max())
        moved = False
        while damping < 1e8 and not moved:
            step = np.zeros_like(value)
            step[free] = -np.linalg.solve(inner + damping * np.diag(size), gradient[free])
            moved_to = value + step
            steepness = np.clip(moved_to[SLOPE], low[SLOPE], high[SLOPE])
            moved_to[FILL:] = (value[FILL:] * value[SLOPE] + step[FILL:]) / steepness
            tried = np.clip(moved_to, low, high)
            tried_left, found, lower = _weighted(model, tried, noise, robust)
            moved = lower < cost
            damping *= 0.2 if moved else 5.0
        if not moved:
            break
        done = cost - lower < close * lower
        value, left, residual, cost = tried, tried_left, found, lower
        if done:
            break
        damping = max(damping, 1e-9)
    return value


def _weight(residual: NDArray[np.float64], robust: bool) -> NDArray[np.float64]:
    """Return the square roots of the weights that the robust sum gives residuals, (n,)."""
    if not robust:
        return np.ones_like(residual)
    weight: NDArray[np.float64] = (1 + (residual / 3.0) ** 2) ** -0.25
    return weight


def _weighted(
    model: TraceModel, value: NDArray[np.float64], noise: float, robust: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the residuals, weighted ones with the priors, and the sum that is made least."""
    left = model.residual(value)
    residual = left / noise
    prior = model.prior(value)
    cost = np.sum(18 * (np.sqrt(1 + (residual / 3) ** 2) - 1)) if robust else np.sum(residual**2)
    weighted = np.concatenate([residual * _weight(residual, robust), prior])
    return left, weighted, float(cost + np.sum(prior**2))


def _start(model: TraceModel) -> NDArray[np.float64]:
    """Return values near the best: pitch and centre from the first harmonic, u from a grid."""
    groove = model.groove
    found = (np.inf, groove.pitch, 0.0)
    turns = np.ptp(model.x) / groove.pitch
    for share in np.linspace(-0.06, 0.06, 2 * int(4 * 0.06 * turns) + 3):
        pitch = groove.pitch * (1 + share)
        angle = 2 * np.pi * model.x / pitch
        waves = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        flat = model.z - model.base @ (model.base.T @ model.z)
        waves_flat = waves - model.base @ (model.base.T @ waves)
        wave = np.linalg.lstsq(waves_flat, flat, rcond=None)[0]
        error = float(np.sum((flat - waves_flat @ wave) ** 2))
        # Highest at the tips, half a pitch from the centre.
        centre = (np.arctan2(wave[1], wave[0]) / (2 * np.pi) + 0.5) * pitch
        if error < found[0] * (1 - 1e-3):
            found = (error, pitch, float(centre))
    _, pitch, centre = found
    value = np.array(
        [centre, pitch, groove.wall_slope, 0.0, 0.0, LIKELY_ROUND, 0.0] + [0.0] * model.grooves
    )
    best = (np.inf, value)
    for above in _WETTINGS if model.profile == "filled" else (0.0,):
        for u in (np.arange(_GRID) + 0.5) / _GRID * model.top:  # at a bound nothing would move
            tried = value.copy()
            tried[WETTING], tried[FILL:] = above, u
            error = float(np.sum(np.abs(model.residual(tried))))
            best = min(best, (error, tried), key=lambda each: each[0])
    return best[1]
