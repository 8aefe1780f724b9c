"""The curve that noisy luminances stand for, with a smoothness that the points themselves tell.

A curve is a level and waves with independent normal values, whose variance falls with frequency: a
Gaussian process (Rasmussen and Williams, "Gaussian processes for machine learning", 2006). How it
falls is weighed by the likelihood of the points (`prior`), so the curve is as smooth as they allow
and no smoother.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.basis import Basis, build_basis
from mpfcad.measure.contrast.prior import Plausible, Prior, plausible_priors
from mpfcad.measure.estimate import Estimate, estimate_sum

#: A curve of more values a pitch than that, with kinks, is sharp.
_SHARP = 16.0
#: Readings from one point to the next; relative error that is below any trace's.
_BETWEEN, _LEAST_ERROR = 4, 1e-5


@dataclass(frozen=True, eq=False)
class CurveFit:
    """A curve through luminances over one or more lamp pitches.

    Attributes
    ----------
    position, luminance, error
        (n,) float64, in pitches; [cd/m²]
    blocks
        of paths, that the errors come from; inf: they are known
    reading
        (k,) float64, positions in pitches where the curve is read
    gain
        (k, n) float64: the curve at `reading` is gain · luminance
    window
        (w, m) int64, numbers of the readings in each lamp pitch
    values
        how many values the curve has: the trace of its gain at the points
    misfit
        √(χ²/degrees of freedom) of the points about the curve, 1 where noise explains it
    basis, plausible
        the waves, and what may be their variances
    gains
        (q, k, n) float64, what `gain` is the mean of: that of each plausible prior
    """

    position: NDArray[np.float64]
    luminance: NDArray[np.float64]
    error: NDArray[np.float64]
    blocks: float
    reading: NDArray[np.float64]
    gain: NDArray[np.float64]
    window: NDArray[np.int64]
    values: float
    misfit: float
    basis: Basis
    plausible: Plausible
    gains: NDArray[np.float64]

    @property
    def curve(self) -> NDArray[np.float64]:
        """The luminance [cd/m²] at `reading`, (k,)."""
        return self.gain @ self.luminance

    @property
    def read_again(self) -> NDArray[np.float64]:
        """What is read of the curve itself, were it measured without noise, (k,) [cd/m²]."""
        step = (len(self.reading) - 1) // (len(self.position) - 1)
        return self.gain @ self.curve[::step]

    @property
    def is_sharp(self) -> bool:
        """Whether the points need nearly a value each: between them the curve is not known."""
        least, priors = _SHARP * round(float(np.ptp(self.position))), self.plausible.priors
        return sum(p.share for p in priors if p.is_rough and p.values > least) > 0.5

    @property
    def reading_error(self) -> NDArray[np.float64]:
        """Standard error [cd/m²] of the curve at `reading`, (k,)."""
        return self.misfit * np.sqrt(self.gain**2 @ self.error**2)

    def at(self, position: float) -> Estimate:
        """Return the luminance [cd/m²] at the reading nearest to a position in pitches."""
        return self._sum(self.gain[np.argmin(np.abs(self.reading - position))])

    def mean(self, pitch: int = 0) -> Estimate:
        """Return the mean luminance [cd/m²] over one of its pitches (trapezium rule)."""
        share = np.ones(self.window.shape[1])
        share[[0, -1]] = 0.5
        return self._sum(share / share.sum() @ self.gain[self.window[pitch]])

    def freedom(self, weight: NDArray[np.float64]) -> float:
        """Return the degrees of freedom of the error of Σ weight · luminance, weight (n,)."""
        from mpfcad.optics.base.recorder import freedom_of_sum

        return freedom_of_sum(weight, self.error, self.blocks)

    def _sum(self, weight: NDArray[np.float64]) -> Estimate:
        return estimate_sum(weight, self.luminance, self.misfit * self.error, self.blocks)

    def draw(self, rng: np.random.Generator, draws: int) -> NDArray[np.float64]:
        """Return curves that the points may stand for, (draws, k) [cd/m²].

        Each is drawn from the posterior of one of the plausible priors: a curve of the prior, and
        what the difference of the points from its own noisy points adds (Matheron's rule).
        """
        priors = self.plausible.priors
        shares = np.cumsum([prior.share for prior in priors])
        number = np.searchsorted(shares, (np.arange(draws) + 0.5) / draws * shares[-1])
        found = np.empty((draws, len(self.reading)))
        for i in np.unique(number):
            prior, rows = priors[i], number == i
            wave = rng.standard_normal((rows.sum(), len(prior.variance))) * np.sqrt(prior.variance)
            noise = rng.standard_normal((rows.sum(), len(self.error))) * self.error
            off = self.luminance - wave @ self.basis.at_points.T - noise
            found[rows] = wave @ _reading(self.basis, prior).T + off @ self.gains[i].T
        return found


def fit_curve(
    position: NDArray[np.float64],
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
    *,
    periodic: bool = True,
    blurred: bool = False,
) -> CurveFit:
    """Return the curve through luminances over whole lamp pitches.

    Parameters
    ----------
    position
        (n,) float64, in pitches, at equal steps over whole pitches
    luminance, error
        (n,) float64 [cd/m²], value and standard error
    blocks
        of paths, that the errors come from; inf: they are known
    periodic
        whether the scene repeats with the pitch
    blurred
        whether the light is spread so far that the curve has no kinks (`blur`)
    """
    error = np.maximum(error, _LEAST_ERROR * np.abs(luminance).max() + 1e-300)
    pitches = max(1, round(float(np.ptp(position))))
    # Over many pitches the points are as close as is needed.
    finer = _BETWEEN if pitches == 1 else 1
    reading = np.linspace(position[0], position[-1], (len(position) - 1) * finer + 1)
    basis = build_basis(position, reading, periodic=periodic)
    unit = float(np.mean(error**2)) * 8 * pitches / len(position) * 2
    found = plausible_priors(basis, luminance, error**2, unit, blurred=blurred)
    gains = np.array([_gain(basis, prior, error**2) for prior in found.priors])
    gain = np.average(gains, axis=0, weights=[prior.share for prior in found.priors])
    at_points = gain[::finer]
    return CurveFit(
        position, luminance, error, blocks, reading, gain, _windows(len(reading), pitches),
        float(np.trace(at_points)), _misfit(at_points, luminance, error, blocks), basis, found,
        gains,
    )  # fmt: skip


def _windows(readings: int, pitches: int) -> NDArray[np.int64]:
    step = (readings - 1) // pitches
    return np.arange(pitches)[:, None] * step + np.arange(step + 1)


def _reading(basis: Basis, prior: Prior) -> NDArray[np.float64]:
    """Return the waves where the curve is read: one with kinks is not known between points."""
    return basis.at_lines if prior.is_rough else basis.at_reading


def _gain(basis: Basis, prior: Prior, noise: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what makes the posterior's mean at the readings of the points, (k, n)."""
    covariance = (basis.at_points * prior.variance) @ basis.at_points.T
    covariance[np.diag_indices(len(noise))] += noise
    inverse = np.linalg.inv(covariance)
    level = inverse.sum(axis=1)
    rest = inverse - np.outer(level, level) / level.sum()
    read = (_reading(basis, prior) * prior.variance) @ basis.at_points.T
    return read @ rest + level / level.sum()


def _misfit(gain: NDArray, luminance: NDArray, error: NDArray, blocks: float) -> float:
    """Return √(χ²/degrees of freedom) where that is beyond noise (1 in 1000 of Fisher's F)."""
    from scipy.special import fdtrc

    from mpfcad.optics.base.recorder import freedom_of_sum

    left = len(luminance) - float(np.trace(gain))
    if left < 1:
        return 1.0
    share = float(np.sum(((luminance - gain @ luminance) / error) ** 2)) / left
    of_errors = min(freedom_of_sum(1 / error, error, blocks), 1e9)
    return float(np.sqrt(share)) if fdtrc(left, of_errors, share) < 1e-3 else 1.0
