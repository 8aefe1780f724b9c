"""A stylus trace as a function of its grooves, and its least-squares fit.

The trace is base + t(x - centre), t what the tip traces of grooves (`DilatedGroove`) in a row. The
base is offset, tilt and, over four prism widths or more, cosines of half-waves down to about a
prism width: waviness. It is linear and projected out, so that what is sought is: centre, pitch,
slope of the walls, rounding of the prism tips, and u = C·w/slope, over four prism widths or more of
each groove its own. Pitch, slope and rounding have priors, for a covered groove shows no wall and
few points no rounding.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.dilated import DilatedGroove
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.units import nm, um

CENTRE, PITCH, SLOPE, ROUNDING, FILL = range(5)
#: Prior standard deviations: of pitch and of slope, as shares; of the rounding [mm].
PITCH_OFF, SLOPE_OFF, ROUND = 0.02, 0.03, 1.0 * um
#: Prism widths from which each groove has its own fill.
OWN_FILL = 4
#: Largest departures of pitch and slope, as shares, and largest rounding [mm].
MOST_OFF, MOST_ROUND = 0.12, 6.0 * um
#: The least noise assumed: that of heights printed to a nanometre or two.
LEAST_NOISE = 0.5 * nm
#: Curvatures tried before the fit, and the largest u of a profile that may dip below the walls.
_GRID, _STEEPEST = 33, 4.0
#: Steps of a fit at most.
_STEPS = 40
#: A height this many robust standard deviations off is a spike, unless it is less than 0.1 µm.
_SPIKE, _SPIKE_LEAST, _SPIKE_SHARE = 6.0, 0.1 * um, 0.2


@dataclass(frozen=True, eq=False)
class TraceModel:
    """A trace and the groove that it should show.

    Attributes
    ----------
    x, z
        (n,) float64 [mm], positions from the middle, heights
    base
        (n, k) float64, orthonormal columns of offset, tilt and waviness
    grooves
        how many have a u of their own
    held_slope
        the walls' slope, where it is not sought
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    groove: Groove
    profile: Profile
    tip: StylusTip | None
    base: NDArray[np.float64]
    grooves: int
    held_slope: float | None = None

    @classmethod
    def of(
        cls,
        x: NDArray[np.float64],
        z: NDArray[np.float64],
        groove: Groove,
        profile: Profile,
        tip: StylusTip | None,
        widths: int,
    ) -> "TraceModel":
        """Return the model of heights at positions from the middle."""
        span = np.ptp(x)
        columns = [np.ones_like(x), x / span]
        columns += [np.cos(np.pi * j * (x / span + 0.5)) for j in range(2, max(widths - 1, 2))]
        base = np.linalg.qr(np.column_stack(columns))[0]
        return cls(x, z, groove, profile, tip, base, widths + 1 if widths >= OWN_FILL else 1)

    def at(self, kept: NDArray[np.bool_]) -> "TraceModel":
        """Return the model of some of the heights."""
        base = np.linalg.qr(self.base[kept])[0]
        return replace(self, x=self.x[kept], z=self.z[kept], base=base)

    @property
    def top(self) -> float:
        """The largest u: an empty groove, or as steep as is tried."""
        return 2.0 if self.profile == "filled" else _STEEPEST

    def local(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return x from the nearest groove's centre, (n,) [mm]."""
        pitch = value[PITCH]
        return (self.x - value[CENTRE] + pitch / 2) % pitch - pitch / 2

    def number(self, value: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the groove of each height, (n,), from 0."""
        number = np.floor((self.x - value[CENTRE]) / value[PITCH] + 0.5).astype(np.int64)
        return np.clip(number - number.min(), 0, self.grooves - 1)

    def groove_of(self, value: NDArray[np.float64]) -> Groove:
        """Return the groove of fitted pitch and slope."""
        return Groove(float(value[PITCH]), float(value[SLOPE] * value[PITCH] / 2))

    def surface(self, value: NDArray[np.float64], *, traced: bool = True) -> NDArray[np.float64]:
        """Return the height above the bare groove's valley, (n,): traced, or of the film itself."""
        groove = self.groove_of(value)
        tip = self.tip if traced else None
        made = DilatedGroove(groove, self.profile, tip, float(value[ROUNDING]))
        curvature = value[FILL:] * value[SLOPE] / (value[PITCH] / 2)
        each = curvature if self.grooves == 1 else curvature[self.number(value)]
        return made.height(self.local(value), each)

    def residual(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what base and groove leave of the heights, (n,) [mm]."""
        left = self.z - self.surface(value)
        return left - self.base @ (self.base.T @ left)

    def levelled(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the heights without the base, (n,) [mm]."""
        left = self.z - self.surface(value)
        return self.z - self.base @ (self.base.T @ left)

    def jacobian(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return d(surface)/d(value), (n, 4 + grooves), by differences inside the bounds."""
        low, high = self.bounds()
        columns = []
        for part, step in (
            (slice(CENTRE, PITCH), 2 * nm), (slice(PITCH, SLOPE), 0.01 * nm),
            (slice(SLOPE, ROUNDING), 1e-6), (slice(ROUNDING, FILL), 1 * nm),
            (slice(FILL, None), 1e-5),
        ):  # fmt: skip
            ahead, back = value.copy(), value.copy()
            ahead[part] = np.minimum(value[part] + step, high[part])
            back[part] = np.maximum(value[part] - step, low[part])
            gap = ahead[part] - back[part]
            change = self.surface(ahead) - self.surface(back)
            gap = np.maximum(gap, 1e-300)  # a value that is held does not change
            columns.append(change / (gap[0] if self.grooves == 1 or part.start < FILL
                                     else gap[self.number(value)]))  # fmt: skip
        if self.grooves == 1:
            return np.column_stack(columns)
        own = np.zeros((len(self.x), self.grooves))
        own[np.arange(len(self.x)), self.number(value)] = columns.pop()
        return np.column_stack([*columns, own])

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the least and the largest value of each."""
        pitch, slope = self.groove.pitch, self.groove.wall_slope
        low = [-np.inf, pitch * (1 - MOST_OFF), slope * (1 - MOST_OFF), 0.0]
        high = [np.inf, pitch * (1 + MOST_OFF), slope * (1 + MOST_OFF), MOST_ROUND]
        if self.held_slope is not None:
            low[SLOPE] = high[SLOPE] = self.held_slope
        return np.array(low + [0.0] * self.grooves), np.array(high + [self.top] * self.grooves)

    def prior(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how many prior standard deviations pitch, slope and rounding are off, (3,)."""
        return np.array([
            (value[PITCH] / self.groove.pitch - 1) / PITCH_OFF,
            (value[SLOPE] / self.groove.wall_slope - 1) / SLOPE_OFF,
            value[ROUNDING] / ROUND,
        ])  # fmt: skip

    def prior_jacobian(self) -> NDArray[np.float64]:
        """Return d(prior)/d(value), (3, 4 + grooves)."""
        rows = np.zeros((3, FILL + self.grooves))
        rows[0, PITCH] = 1 / (PITCH_OFF * self.groove.pitch)
        rows[1, SLOPE] = 1 / (SLOPE_OFF * self.groove.wall_slope)
        rows[2, ROUNDING] = 1 / ROUND
        return rows


@dataclass(frozen=True, eq=False)
class Fitted:
    """The values that fit best, the heights they were fitted to, and the noise [mm] assumed.

    `misfit` is the mean absolute residual [mm] of all heights, those left out as spikes too: a tip
    that is too large leaves its misfit at the prism tips, where it looks like spikes.
    """

    model: TraceModel
    value: NDArray[np.float64]
    noise: float
    misfit: float

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
        """C [1/mm] through the tips of each groove that is seen whole enough, (k,)."""
        each: NDArray[np.float64] = self.fills * self.value[SLOPE] / (self.value[PITCH] / 2)
        return each

    @property
    def curvature(self) -> float:
        """Mean C [1/mm] through the tips."""
        return float(np.mean(self.curvature_of_each))

    @property
    def rms(self) -> float:
        """Root mean square of the residual [mm]."""
        return float(np.sqrt(np.mean(self.model.residual(self.value) ** 2)))


def fit_model(whole: TraceModel) -> Fitted:
    """Return the least-squares fit of a model, spikes left out."""
    model, value = whole, _start(whole)
    noise = 50 * nm
    for robust in (True, False, False):
        value = solve(model, value, noise, robust=robust)
        residual = whole.residual(value)
        spread = 1.4826 * float(np.median(np.abs(residual - np.median(residual))))
        off = np.abs(residual) > max(_SPIKE * spread, _SPIKE_LEAST)
        off = np.convolve(off, np.ones(3), "same") > 0
        model = whole.at(~off) if 0 < np.mean(off) < _SPIKE_SHARE else whole
        noise = max(float(np.std(model.residual(value))), LEAST_NOISE)
    misfit = float(np.mean(np.abs(whole.residual(value))))
    return Fitted(model, value, noise, max(misfit, LEAST_NOISE))


def solve(
    model: TraceModel,
    value: NDArray[np.float64],
    noise: float,
    *,
    robust: bool = False,
    close: float = 1e-9,
) -> NDArray[np.float64]:
    """Return the least-squares values within their bounds, for a noise [mm].

    Levenberg and Marquardt's method over the values that are not held at a bound; steps are clipped
    to the bounds. A step is one of slope and u·slope: a covered groove shows that product alone, so
    that u and slope by themselves would be stiff. `robust`: heights count as √(1 + r²) from three
    deviations on. `close`: the share of the sum that a last step gains.
    """
    low, high = model.bounds()
    value, damping = np.clip(value, low, high), 1e-3
    residual, cost = _weighted(model, value, noise, robust)
    for _ in range(_STEPS):
        slope = model.jacobian(value)
        slope = slope - model.base @ (model.base.T @ slope)
        weight = _weight(model.residual(value) / noise, robust)
        rows = np.concatenate([slope * (-weight / noise)[:, None], model.prior_jacobian()])
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
            found, lower = _weighted(model, tried, noise, robust)
            moved = lower < cost
            damping *= 0.2 if moved else 5.0
        if not moved:
            break
        done = cost - lower < close * lower
        value, residual, cost = tried, found, lower
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
) -> tuple[NDArray[np.float64], float]:
    """Return the weighted residuals and priors, and the sum that is made least."""
    residual = model.residual(value) / noise
    prior = model.prior(value)
    cost = np.sum(18 * (np.sqrt(1 + (residual / 3) ** 2) - 1)) if robust else np.sum(residual**2)
    weighted = np.concatenate([residual * _weight(residual, robust), prior])
    return weighted, float(cost + np.sum(prior**2))


def _start(model: TraceModel) -> NDArray[np.float64]:
    """Return values near the best: pitch and centre from the first harmonic, u from a grid."""
    groove = model.groove
    best = (np.inf, groove.pitch, 0.0)
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
        if error < best[0] * (1 - 1e-3):
            best = (error, pitch, float(centre))
    _, pitch, centre = best
    value = np.array([centre, pitch, groove.wall_slope, 0.0] + [0.0] * model.grooves)
    errors = []
    for u in np.linspace(0.0, model.top, _GRID):
        value[FILL:] = u
        errors.append(float(np.sum(np.abs(model.residual(value)))))
    value[FILL:] = np.linspace(0.0, model.top, _GRID)[int(np.argmin(errors))]
    return value
