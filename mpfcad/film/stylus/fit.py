"""The groove's shape from a stylus trace: levelled, centred, both curvatures with their intervals.

The trace is z = offset + tilt·x + h(x - centre, C) + noise with h the profile of the groove,
repeated with its pitch. Offset, tilt, centre and C come from least squares of that model: C is the
curvature *through the tips*. `fitted_curvature` is what a profiler reports: the least-squares
parabola over whole prism widths of the levelled and centred trace (Hsieh, MPF thesis: two).

Intervals are 95 % and take the residuals as they are: their variance is multiplied by the sum of
their autocorrelation, so waviness and a meniscus that is no parabola widen them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import um

#: Curvatures tried before the fit, and the largest tried for an `ideal` profile over 2 s/w.
GRID, STEEPEST = 65, 4.0
#: Heights that must lie on resin for C to be told from them.
RESIN_POINTS = 5
#: A trace whose residual exceeds this share of its own standard deviation shows no such groove.
UNEXPLAINED = 0.5


@dataclass(frozen=True)
class Interval:
    """A value and its 95 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class StylusFit:
    """What a trace says about the groove; lengths in mm.

    Attributes
    ----------
    curvature
        C through the tips [1/mm]
    fitted_curvature
        of the least-squares parabola over the whole prism widths [1/mm]
    residual_rms, fitted_residual_rms
        of the groove's profile, and of the parabola
    tilt
        slope of the trace's base line
    centre
        position of a groove's centre
    position, height
        (n,) float64, the prism widths used: x from the nearest groove's centre, -w … w, and the
        levelled height above the bare groove's valley
    """

    curvature: Interval
    fitted_curvature: Interval
    residual_rms: float
    fitted_residual_rms: float
    tilt: float
    centre: float
    position: NDArray[np.float64]
    height: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Model:
    """The trace as a function of (offset, tilt, centre, C)."""

    groove: Groove
    profile: Profile
    x: NDArray[np.float64]
    z: NDArray[np.float64]
    share: NDArray[np.float64]

    def local(self, centre: float) -> NDArray[np.float64]:
        """Return x from the nearest groove's centre, -w … w."""
        w = self.groove.half_width
        return (self.x - centre + w) % self.groove.pitch - w

    def levelled(self, parameter: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.z - parameter[0] - parameter[1] * self.x

    def residual(self, parameter: NDArray[np.float64]) -> NDArray[np.float64]:
        surface = self.groove.height(self.local(parameter[2]), parameter[3], self.profile)
        return self.levelled(parameter) - surface

    def jacobian(self, parameter: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return d(residual)/d(parameter), (n, 4)."""
        local, curvature = self.local(parameter[2]), parameter[3]
        drop = (local**2 - self.groove.half_width**2) / 2
        if self.profile == "filled":
            drop = np.where(np.abs(local) > self.groove.contact_position(curvature), 0.0, drop)
        slope = self.groove.slope(local, curvature, self.profile)
        return np.stack([-np.ones_like(local), -self.x, slope, -drop], axis=1)


def fit_stylus_trace(
    trace: StylusTrace, groove: Groove, profile: Profile = "filled", prism_widths: int = 2
) -> StylusFit:
    """Fit the middle `prism_widths` prism widths of a trace.

    Raises
    ------
    InputError
        when the trace does not show grooves of this pitch and depth.
    """
    from scipy.optimize import least_squares
    from scipy.special import stdtrit

    used = trace.middle(prism_widths * groove.pitch)
    origin = float(np.mean(used.position))
    width = prism_widths * groove.pitch
    share = _shares(used.position, (trace.position[0] + trace.position[-1]) / 2, width)
    model = _Model(groove, profile, used.position - origin, used.height, share)
    top = groove.curvature_empty * (1 if profile == "filled" else STEEPEST)
    start = _start(model, top)
    found = least_squares(
        model.residual,
        start,
        model.jacobian,
        bounds=([-np.inf, -np.inf, -np.inf, 0.0], [np.inf, np.inf, np.inf, top]),
        x_scale=[groove.depth, 1.0, groove.pitch, groove.curvature_empty],
        xtol=1e-12,
        ftol=1e-14,
        gtol=1e-14,
    ).x
    residual, jacobian = model.residual(found), model.jacobian(_sensitive(model, found))
    levelled = model.levelled(found)
    rms = float(np.sqrt(np.mean(residual**2)))
    if not rms <= UNEXPLAINED * float(np.std(levelled)):
        raise InputError(
            f"{trace.name}: z_um: residual {rms / um:.3g} µm rms of {np.std(levelled) / um:.3g} µm "
            f"of relief: allowed a trace that shows grooves of pitch {groove.pitch / um:g} µm and "
            f"depth {groove.depth / um:g} µm"
        )
    free = len(residual) - 4
    correlation = _correlation_sum(residual)
    noise = np.sqrt(np.sum(residual**2) / free * correlation)
    quantile = float(stdtrit(max(len(residual) / correlation - 4, 1.0), 0.975))
    # What each height weighs in each parameter, -(JᵀJ)⁻¹Jᵀ transposed: (n, 4).
    orthonormal, triangle = np.linalg.qr(jacobian)
    gain = -np.linalg.solve(triangle, orthonormal.T).T
    parabola = _parabola(model, found)
    moved = _parabola_gain(model, found) @ gain.T
    half = [
        quantile * noise * float(np.linalg.norm(g)) for g in (gain[:, 3], parabola.weight + moved)
    ]
    return StylusFit(
        _interval(float(found[3]), half[0], top),
        _interval(parabola.curvature, half[1], np.inf),
        rms,
        parabola.residual_rms,
        float(found[1]),
        float(found[2]) + origin,
        model.local(found[2]),
        levelled,
    )


def _shares(x: NDArray[np.float64], middle: float, width: float) -> NDArray[np.float64]:
    """Return the share, (n,), of the window around `middle` that is nearest to each position."""
    bounds = [middle - width / 2, *((x[1:] + x[:-1]) / 2), middle + width / 2]
    return np.diff(bounds) / width


def _interval(value: float, half: float, top: float) -> Interval:
    return Interval(value, float(max(value - half, 0.0)), float(min(value + half, top)))


def _start(model: _Model, top: float) -> NDArray[np.float64]:
    """Return (offset, tilt, centre, C): the centre from the first harmonic, C from a grid."""
    x, pitch = model.x, model.groove.pitch
    angle = 2 * np.pi * x / pitch
    basis = np.stack([np.ones_like(x), x, np.cos(angle), np.sin(angle)], axis=1)
    wave = np.linalg.lstsq(basis, model.z, rcond=None)[0]
    # Highest at the tips, half a pitch from the centre.
    centre = (np.arctan2(wave[3], wave[2]) / (2 * np.pi) + 0.5) * pitch
    line = basis[:, :2]
    best, start = np.inf, np.zeros(4)
    for curvature in np.linspace(0.0, top, GRID):
        bare = model.z - model.groove.height(model.local(centre), curvature, model.profile)
        level = np.linalg.lstsq(line, bare, rcond=None)[0]
        error = float(np.sum((bare - line @ level) ** 2))
        if error < best:
            best, start = error, np.array([*level, centre, curvature])
    # Strictly between the bounds, as the solver asks.
    start[3] = np.clip(start[3], 1e-6 * top, (1 - 1e-6) * top)
    return start


def _sensitive(model: _Model, parameter: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the parameters with C lowered until `RESIN_POINTS` heights lie on resin.

    An (almost) empty groove shows no resin, so that no height depends on C: its interval is what
    those few heights next to the valley would tell.
    """
    if model.profile == "ideal":
        return parameter
    reach = np.sort(np.abs(model.local(parameter[2])))[RESIN_POINTS - 1]
    groove = model.groove
    steepest = 2 * groove.wall_slope / (groove.half_width + reach)
    return np.array([*parameter[:3], min(parameter[3], steepest)])


def _correlation_sum(residual: NDArray[np.float64]) -> float:
    """Return 1 + 2 Σ ρ_k up to the first ρ_k ≤ 0: by how much correlation widens a variance."""
    n = len(residual)
    spectrum = np.abs(np.fft.rfft(residual - residual.mean(), 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[:n]
    if not covariance[0] > 0:
        return 1.0
    rho = covariance[1:] / covariance[0]
    end = int(np.argmax(rho <= 0)) if np.any(rho <= 0) else len(rho)
    return float(min(1 + 2 * np.sum(rho[:end]), n / 5))


@dataclass(frozen=True, eq=False)
class _Parabola:
    """A least-squares parabola: its curvature, what each height weighs in it, what it leaves."""

    curvature: float
    weight: NDArray[np.float64]
    residual_rms: float


def _parabola(model: _Model, parameter: NDArray[np.float64]) -> _Parabola:
    """Return the parabola through all levelled heights, each weighted by its share of x."""
    share = model.share
    half_square = model.local(parameter[2]) ** 2 / 2
    bend = half_square - np.sum(share * half_square)
    weight = share * bend / np.sum(share * bend**2)
    height = model.levelled(parameter)
    curvature = float(np.sum(weight * height))
    left = height - np.sum(share * height) - curvature * bend
    return _Parabola(curvature, weight, float(np.sqrt(np.sum(share * left**2))))


def _parabola_gain(model: _Model, parameter: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return d(fitted curvature)/d(parameter), (4,), by central differences."""
    gain = np.zeros(4)
    for i, step in enumerate((1e-6, 1e-6, 1e-5)):
        move = np.eye(4)[i] * step
        ahead = _parabola(model, parameter + move).curvature
        gain[i] = (ahead - _parabola(model, parameter - move).curvature) / (2 * step)
    return gain
