"""Colour Mura: how far the colour over a pitch departs from its mean, at most.

The largest of noisy distances is too large. So the interval holds those sizes of the found pattern
that may give what was found: with the pattern s · d, d the found departures, and noise of their
covariance drawn on it, the largest distance is below the found one in all but 2.5 % of the draws
from the upper end of s on, and above it up to the lower (a test inverted; Neyman, "Outline of a
theory of statistical estimation", 1937). Noise that alone gives as much has a lower end of 0.
Several points that are truly as far off make the largest of them larger than one alone: so for the
lower end points that may be as far off are taken to be, and for the upper one none is.
"""

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.colour.chromaticity import scatter_of
from mpfcad.measure.estimate import TAIL, Estimate, wobble
from mpfcad.spectrum import uniform_chromaticity

_DRAWS = 1000
#: Sizes of the pattern that are tried, between none and three times what was found.
_SIZES = np.linspace(0.0, 3.0, 61)
#: Points within so many of their standard errors of the largest distance may be as far: for the
#: value, and for the lower end, which is to hold in any case.
_RIVAL, _SURE_RIVAL = 1.0, 3.0
#: Noise below this share of what was found is none.
_ROUNDING = 1e-9


def colour_mura(xyz: NDArray[np.float64], seed: int) -> Estimate:
    """Return the largest Δu'v' between a point and the mean over all, of (b, p, 3) float64.

    The mean is that of light, X, Y, Z. Draws are fixed by `seed`.
    """
    blocks = len(xyz)
    mean = xyz.mean(axis=1)
    apart = uniform_chromaticity(xyz.mean(axis=0)) - uniform_chromaticity(mean.mean(axis=0))
    scatter = scatter_of(xyz) - scatter_of(mean[:, None])
    return largest(apart, scatter / np.sqrt(blocks * (blocks - 1)), blocks - 1, seed)


def largest(
    apart: NDArray[np.float64], scatter: NDArray[np.float64], freedom: float, seed: int
) -> Estimate:
    """Return the largest length of noisy vectors `apart`, (p, 2), with its interval.

    scatter: (b, p, 2), rows whose sum of squares is the covariance of `apart`.
    """
    found = float(np.hypot(*apart.T).max())
    rng = np.random.Generator(np.random.Philox(seed))
    factor = rng.standard_normal((_DRAWS, len(scatter))) * wobble(rng, _DRAWS, freedom)
    noise = (factor @ scatter.reshape(len(scatter), -1)).reshape(_DRAWS, *apart.shape)
    if np.abs(noise).max() <= _ROUNDING * found:
        return Estimate(found, found, found, 0.0)
    length, spread = np.hypot(*apart.T), np.sqrt((scatter**2).sum(axis=(0, 2)) / 2)
    ends = {}
    for tail, reach_of_rivals in ((TAIL, 0.0), (0.5, _RIVAL), (1 - TAIL, _SURE_RIVAL)):
        rival = (length > 0) & (length >= found - reach_of_rivals * spread)
        pattern = apart * np.where(rival, found / np.where(rival, length, 1.0), 1.0)[:, None]
        # What is found is at least what the truly farthest point alone would give.
        part = [int(np.argmax(length))] if tail == TAIL else slice(None)
        ends[tail] = found * _size(pattern[part], noise[:, part], found, tail)
    return Estimate.within(ends[0.5], ends[1 - TAIL], ends[TAIL])


def _size(
    pattern: NDArray[np.float64], noise: NDArray[np.float64], found: float, share: float
) -> float:
    """Return the size of a pattern of which this share of the draws lies below what was found."""
    # |s d + e|² = s² |d|² + 2 s d·e + |e|².
    long, common = (pattern**2).sum(axis=1), (noise * pattern).sum(axis=2)
    noisy = (noise**2).sum(axis=2)
    curve = [
        np.sqrt(np.quantile((s * s * long + 2 * s * common + noisy).max(axis=1), share))
        for s in _SIZES
    ]
    return _crossing(np.array(curve), found)


def _crossing(curve: NDArray[np.float64], level: float) -> float:
    """Return the size from which on a rising curve lies above a level; 0 where it always does."""
    above = np.flatnonzero(curve > level)
    if not len(above):
        return float(_SIZES[-1])
    i = int(above[0])
    if i == 0:
        return 0.0
    share = (level - curve[i - 1]) / (curve[i] - curve[i - 1])
    return float(_SIZES[i - 1] + share * (_SIZES[i] - _SIZES[i - 1]))
