"""The probability that the contrast meets its limit over what is not known of the inputs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence.factor import Factor
from mpfcad.confidence.response import Response
from mpfcad.measure import Estimate

_DRAWS, _RESPONSES = 4000, 200


@dataclass(frozen=True)
class Likely:
    """What contrast is likely.

    Attributes
    ----------
    probability
        that the contrast is at most the limit; its interval is that of the traces' noise
    contrast
        median, and the ends between which 95 % of the contrasts lie, traces' noise included
    """

    probability: Estimate
    contrast: Estimate


def draw_steps(
    factors: list[Factor], correlation: NDArray[np.float64], seed: int, draws: int = _DRAWS
) -> NDArray[np.float64]:
    """Return steps of the inputs in units of sigma, (draws, k), normal, cut off at their ends."""
    rng = np.random.Generator(np.random.Philox(seed))
    value, vector = np.linalg.eigh(correlation)
    root = vector * np.sqrt(np.maximum(value, 0))
    steps = rng.standard_normal((draws, len(factors))) @ root.T
    return np.stack([f.within(steps[:, i]) for i, f in enumerate(factors)], axis=1)


def likely_contrast(
    response: Response, steps: NDArray[np.float64], limit: float, seed: int
) -> Likely:
    """Return how likely the limit is met over steps (n, k) of the inputs."""
    best = response.shrunk()
    contrast = best.contrast(steps)
    rng = np.random.Generator(np.random.Philox(seed + 1))
    few = steps[: len(steps) // 4]
    drawn = np.stack([best.drawn(rng).contrast(few) for _ in range(_RESPONSES)])
    shares = np.mean(drawn <= limit, axis=1)
    # The share and the range below are of the same contrasts, so that they cannot contradict each
    # other. Noise in the response raises contrasts: what a second dose of it takes away, the first
    # may have taken too (the basic bootstrap: Davison and Hinkley, "Bootstrap methods", 1997), so
    # the interval holds the share without both and with both.
    once, share = float(np.mean(best.contrast(few) <= limit)), float(np.mean(contrast <= limit))
    lower, upper = (float(end) for end in np.quantile(shares, [0.025, 0.975]))
    low = float(np.clip(min(lower, share + once - upper), 0, share))
    high = float(np.clip(max(upper, share + once - lower), share, 1))
    interval = Estimate.within(share, low, high)
    return Likely(interval, _range(contrast, drawn))


def _range(contrast: NDArray[np.float64], drawn: NDArray[np.float64]) -> Estimate:
    """Return the median and 95 % range of contrasts (n,), with the doubt about the response.

    drawn: (responses, n), contrasts of responses that the traces may stand for. Their noise raises
    contrasts, and the first dose of it did, too: so much may be taken off the low end.
    """
    low, middle, high = (float(end) for end in np.quantile(contrast, [0.025, 0.5, 0.975]))
    raised = float(np.quantile(np.quantile(drawn, 0.025, axis=1), 0.975)) - low
    least, most = (float(end) for end in np.quantile(drawn, [0.025, 0.975]))
    least = min(low, least) - max(0.0, raised)
    return Estimate.within(middle, max(0.0, least), max(high, most))


def shares_of_variance(response: Response, correlation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each input's share of the curve's variance, (k,); correlated ones share in halves."""
    best = response.shrunk()
    # A bend's own variance is 2, that of z².
    own = best.slope @ best.basis.T
    part = np.sum(own * (correlation @ own), axis=1)
    part += 2 * np.sum((best.bend @ best.basis.T) ** 2, axis=1)
    return part / max(float(part.sum()), 1e-300)
