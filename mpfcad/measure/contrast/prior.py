"""How smooth a curve may be: what noisy points say about the variance of its waves.

The points' restricted likelihood (whatever the level is) weighs some hundred priors, each a
spectrum and a variance. No single one is chosen: curves are drawn from all of them.
"""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.basis import SPECTRA, Basis, Choice

#: Variances are tried from the noise's in a curve of eight values a pitch up by factors of 4, or as
#: far as the points' own.
_STEPS, _FACTOR = 12, 4.0
#: Steps further down that what pitches do not share is tried.
_ALIKE = 5
#: A prior of kinks holds them everywhere. A curve may have one alone, which is then so many times
#: as strong; curves that nothing blurs have any the likelier, by such a difference of ln L.
_ONE_KINK, _OFTEN = 8.0, 1.0
#: Shares that are left out; priors that are kept at most.
_LEAST, _MOST = 1e-3, 24
#: A flat curve is read as one whose likelihood is larger by so much of ln L in 1 of 40.
_FLAT = 2.0


class Prior(NamedTuple):
    """What curves are drawn from.

    variance: (p,) of each wave; share: probability; is_rough: whether it has kinks, `values`: how
    many values its curves have, about.
    """

    variance: NDArray[np.float64]
    share: float
    is_rough: bool
    values: float


@dataclass(frozen=True, eq=False)
class Plausible:
    """The priors that points allow, the likeliest first, and whether they allow a flat curve."""

    priors: tuple[Prior, ...]
    may_be_flat: bool


_Likelihoods = dict[tuple[Choice, ...], float]


def plausible_priors(
    basis: Basis,
    luminance: NDArray[np.float64],
    noise: NDArray[np.float64],
    unit: float,
    *,
    blurred: bool,
) -> Plausible:
    """Return the priors that points allow; noise: (n,), their variances; unit: of the waves'.

    `blurred`: the curve has no kinks.
    """
    found = _likelihoods(basis, luminance, noise, unit, blurred)
    kept = sorted(found, key=lambda k: (-found[k], k))[:_MOST]
    share = np.exp([found[k] - found[kept[0]] for k in kept])
    share /= share.sum()
    points, mean = len(noise), float(np.mean(noise))
    priors = tuple(
        Prior(variance, float(s), any(map(_is_rough, k)), _values(variance, mean, points))
        for k, s in zip(kept, share, strict=True)
        if s >= _LEAST
        for variance in [basis.variance(k, unit, _ONE_KINK)]
    )
    flat = _likelihood(basis, np.zeros(len(basis.frequency)), luminance, noise)
    return Plausible(priors, found[kept[0]] - flat < _FLAT)


def _is_rough(choice: Choice) -> bool:
    return SPECTRA[choice.spectrum].is_rough


def _likelihoods(
    basis: Basis,
    luminance: NDArray[np.float64],
    noise: NDArray[np.float64],
    unit: float,
    blurred: bool,
) -> _Likelihoods:
    """Return ln L of priors."""
    found: _Likelihoods = {}
    spectra = [i for i, one in enumerate(SPECTRA) if not (blurred and one.is_rough)]

    def likelihood(choices: tuple[Choice, ...]) -> float:
        if choices not in found:
            like = _likelihood(basis, basis.variance(choices, unit), luminance, noise)
            found[choices] = like + _OFTEN * any(map(_is_rough, choices))
        return found[choices]

    most = max(_FACTOR ** (_STEPS - 1), _FACTOR * float(np.var(luminance)) / unit)
    sizes = [float(v) for v in np.geomspace(1, most, _STEPS)]
    every = [Choice(s, v) for s, v in product(spectra, sizes)]
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
        take_best(group, [best[group]._replace(spectrum=i) for i in spectra])
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
