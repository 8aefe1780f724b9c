"""The curve that noisy luminances stand for, with a smoothness that the points themselves tell.

A curve is a level and waves with independent normal values, whose variance falls with frequency: a
Gaussian process (Rasmussen and Williams, "Gaussian processes for machine learning", 2006). How it
falls is chosen by the likelihood of the points, so the curve is as smooth as they allow and no
smoother. Where they need a value each, the curve is the points: nothing is smoothed.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.basis import SPECTRA, Basis, Choice, build_basis
from mpfcad.measure.estimate import Estimate, estimate_sum

#: Variances of the waves are tried from a quarter of the noise's in a curve of eight values a pitch
#: up by factors of 4, or as far as the points' own.
_STEPS, _FACTOR = 13, 4.0
#: Steps further down that what pitches do not share is tried.
_ALIKE = 4
#: Points, 32 a pitch, are not smoothed from so many values a pitch, where more than such a share of
#: the curve's variance lies above such a frequency [1/pitch].
_SHARP, _SHARE, _FREQUENCY = 16.0, 0.003, 8.0
#: Readings from one point to the next.
_BETWEEN = 4
#: The smoothest of the priors is taken that are as likely as the best within this of ln L.
_AS_LIKELY = 3.0
#: Priors that plausible curves are drawn from; relative error that is below any trace's.
_MOST_PRIORS, _LEAST_ERROR = 10, 1e-5


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
    is_sharp
        whether the curve is the points, not smoothed
    basis, priors
        the waves; (variances (p,), probability) of each plausible prior
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
    is_sharp: bool
    basis: Basis
    priors: tuple[tuple[NDArray[np.float64], float], ...]

    @property
    def curve(self) -> NDArray[np.float64]:
        """The luminance [cd/m²] at `reading`, (k,)."""
        return self.gain @ self.luminance

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
        shares = np.cumsum([share for _, share in self.priors])
        number = np.searchsorted(shares, (np.arange(draws) + 0.5) / draws * shares[-1])
        found = np.empty((draws, len(self.reading)))
        points, reading = self.basis.at_points, self.basis.at_reading
        for i in np.unique(number):
            variance, rows = self.priors[i][0], number == i
            gain = _gain(self.basis, variance, self.error**2)
            wave = rng.standard_normal((rows.sum(), len(variance))) * np.sqrt(variance)
            noise = rng.standard_normal((rows.sum(), len(self.error))) * self.error
            off = self.luminance - wave @ points.T - noise
            found[rows] = wave @ reading.T + off @ gain.T
        return found


def fit_curve(
    position: NDArray[np.float64],
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
    *,
    periodic: bool = True,
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
    """
    error = np.maximum(error, _LEAST_ERROR * np.abs(luminance).max() + 1e-300)
    pitches = max(1, round(float(np.ptp(position))))
    # Over many pitches the points are as close as is needed.
    finer = _BETWEEN if pitches == 1 else 1
    reading = np.linspace(position[0], position[-1], (len(position) - 1) * finer + 1)
    basis = build_basis(position, reading, periodic=periodic)
    noise = float(np.mean(error**2)) * 8 * pitches / len(position) * 2
    found = _likelihoods(basis, luminance, error**2, noise)
    best = _smoothest(basis, found, float(np.mean(error**2)), noise, len(position))
    variance = basis.variance(best, noise)
    values = _values(variance, float(np.mean(error**2)), len(position))
    fine = variance[basis.frequency > _FREQUENCY].sum() > _SHARE * variance.sum()
    is_sharp = bool(fine and values > _SHARP * pitches)
    if is_sharp:
        reading, basis = position, build_basis(position, position, periodic=periodic)
        gain = at_points = np.eye(len(position))
    else:
        gain = _gain(basis, variance, error**2)
        at_points = gain[::finer]
    return CurveFit(
        position, luminance, error, blocks, reading, gain, _windows(len(reading), pitches),
        float(np.trace(at_points)), _misfit(at_points, luminance, error, blocks), is_sharp, basis,
        _plausible(basis, found, noise),
    )  # fmt: skip


def _windows(readings: int, pitches: int) -> NDArray[np.int64]:
    step = (readings - 1) // pitches
    return np.arange(pitches)[:, None] * step + np.arange(step + 1)


_Likelihoods = dict[tuple[Choice, ...], float]


def _likelihoods(
    basis: Basis, luminance: NDArray[np.float64], noise: NDArray[np.float64], unit: float
) -> _Likelihoods:
    """Return ln L of priors; `noise`: (n,), the points' variances."""
    found: _Likelihoods = {}

    def likelihood(choices: tuple[Choice, ...]) -> float:
        if choices not in found:
            variance = basis.variance(choices, unit)
            found[choices] = _likelihood(basis, variance, luminance, noise)
        return found[choices]

    most = max(_FACTOR ** (_STEPS - 2), _FACTOR * float(np.var(luminance)) / unit)
    sizes = [float(v) for v in np.geomspace(1 / _FACTOR, most, _STEPS)]
    every = [Choice(s, v) for s, v in product(range(len(SPECTRA)), sizes)]
    if len(basis.groups) == 1:
        for choice in every:
            likelihood((choice,))
        return found
    # Two groups: one part after the other, twice.
    best = [Choice(len(SPECTRA) - 2, sizes[_STEPS // 3])] * 2

    def rank(trial: tuple[Choice, ...]) -> tuple[float, tuple[Choice, ...]]:
        return likelihood(trial), trial

    def take_best(group: int, ways: list[Choice]) -> None:
        trials: list[tuple[Choice, ...]]
        trials = [(*best[:group], way, *best[group + 1 :]) for way in ways]
        chosen = max(trials, key=rank)
        best[:] = chosen

    # Pitches may be alike: what they have of their own may be nothing beside the noise.
    own = [sizes[0] / _FACTOR**step for step in range(_ALIKE, 0, -1)] + sizes
    for group in (0, 1, 0, 1):
        tried = sizes if group == 0 else own
        take_best(group, [best[group]._replace(variance=size) for size in tried])
        take_best(group, [best[group]._replace(spectrum=i) for i in range(len(SPECTRA))])
    return found


def _likelihood(basis: Basis, variance: NDArray, luminance: NDArray, noise: NDArray) -> float:
    """Return ln L of the points' differences, whatever the level (restricted likelihood)."""
    covariance = (basis.at_points * variance) @ basis.at_points.T
    covariance[np.diag_indices(len(noise))] += noise
    root = np.linalg.cholesky(covariance)
    one, value = np.linalg.solve(root, np.stack([np.ones_like(luminance), luminance], 1)).T
    rest = value - (one @ value) / (one @ one) * one
    return float(-np.log(np.diag(root)).sum() - np.log(one @ one) / 2 - rest @ rest / 2)


def _values(variance: NDArray[np.float64], noise: float, points: int) -> float:
    """Return how many values a curve of this prior has, about: waves that the noise leaves."""
    power = variance * points / (2 * noise)
    return float(np.sum(power / (1 + power)))


def _smoothest(
    basis: Basis, found: _Likelihoods, noise: float, unit: float, points: int
) -> tuple[Choice, ...]:
    """Return the smoothest prior as likely as the best, of those that let a curve be one.

    The likeliest follows the noise's own waves. A prior of a variance below the noise's would
    read any curve as flat.
    """
    able = {k: like for k, like in found.items() if any(c.variance >= 1 for c in k)}
    least = max(able.values()) - _AS_LIKELY
    alike = [k for k, like in able.items() if like >= least]
    return min(alike, key=lambda k: (_values(basis.variance(k, unit), noise, points), k))


def _plausible(
    basis: Basis, found: _Likelihoods, unit: float
) -> tuple[tuple[NDArray[np.float64], float], ...]:
    """Return variances and probability of the likeliest priors."""
    kept = sorted(found, key=lambda k: (-found[k], k))[:_MOST_PRIORS]
    share = np.exp([found[k] - found[kept[0]] for k in kept])
    return tuple(
        (basis.variance(k, unit), float(s)) for k, s in zip(kept, share / share.sum(), strict=True)
    )


def _gain(basis: Basis, variance: NDArray, noise: NDArray) -> NDArray[np.float64]:
    """Return what makes the posterior's mean at the readings of the points, (k, n)."""
    covariance = (basis.at_points * variance) @ basis.at_points.T
    covariance[np.diag_indices(len(noise))] += noise
    inverse = np.linalg.inv(covariance)
    level = inverse.sum(axis=1)
    rest = inverse - np.outer(level, level) / level.sum()
    return ((basis.at_reading * variance) @ basis.at_points.T) @ rest + level / level.sum()


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
