"""Lamp-Mura contrast from noisy luminances: of a fitted curve's pitches, or of single points.

Contrast is (Lmax - Lmin)/(Lmax + Lmin) over one lamp pitch (Hsieh, MPF thesis, eq. 10). Maximum and
minimum of 33 noisy points overstate it by about two standard errors. Here the curve is one fitted
to all points (`curve`), and the interval that of all curves that the points allow (`draws`). Of
several pitches the worst counts.
"""

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.curve import CurveFit
from mpfcad.measure.contrast.draws import contrast_of_draws, contrasts
from mpfcad.measure.estimate import TAIL, Estimate, wobble

_DRAWS, _LEAST_ERROR = 1000, 1e-12
#: A curve of more values than that share of its points is the points.
_NEARLY_ALL = 0.9


def contrast_of_curve(fit: CurveFit, seed: int = 0, *, points: int | None = None) -> Estimate:
    """Return the lamp-Mura contrast of a fitted curve, median-unbiased, with its 95 % interval.

    Of a curve over several pitches it is that of the worst one. `points`: the curve is read at so
    many a pitch, from one lamp to the next, both included; None for all readings. The draws are
    fixed by `seed`; the result is deterministic.
    """
    window = fit.window
    if points is not None:
        window = window[:, :: (window.shape[1] - 1) // (points - 1)]
    return _Draws(fit, seed).contrast(window)


def contrasts_of_pitches(fit: CurveFit, seed: int = 0) -> list[Estimate]:
    """Return the contrast of each pitch of a curve on its own."""
    draws = _Draws(fit, seed)
    return [draws.contrast(window[None]) for window in fit.window]


class _Draws:
    """Curves that a fit's points may stand for, and what it reads of their noise alone."""

    def __init__(self, fit: CurveFit, seed: int) -> None:
        rng = np.random.Generator(np.random.Philox(seed))
        draws = _DRAWS if len(fit.window) == 1 else _DRAWS // 2
        self._fit, self._curve, self._seed = fit, fit.curve, seed
        off = fit.draw(rng, draws)
        self._off = off - off.mean(axis=0)
        self._noise = rng.standard_normal((draws, len(fit.error))) * fit.error @ fit.gain.T

    def contrast(self, window: NDArray[np.int64]) -> Estimate:
        """Return the contrast of the worst of some pitches (w, m)."""
        fit, curve = self._fit, self._curve
        # What the reading's error is known to: that of the difference of its two ends.
        worst = window[np.argmax(contrasts(curve[window]))]
        high, low = worst[np.argmax(curve[worst])], worst[np.argmin(curve[worst])]
        freedom = fit.freedom(fit.gain[high] - fit.gain[low])
        rng = np.random.Generator(np.random.Philox([self._seed, 1]))
        wider = fit.misfit * wobble(rng, len(self._off), freedom)
        return contrast_of_draws(
            curve[window], (wider * self._off)[:, window], (wider * self._noise)[:, window],
            fit.read_again[window], may_be_flat=fit.plausible.may_be_flat,
            is_smoothed=fit.values < _NEARLY_ALL * len(fit.position),
            has_kinks=any(prior.is_rough for prior in fit.plausible.priors),
        )  # fmt: skip


def contrast_of_points(
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
    seed: int = 0,
) -> Estimate:
    """Return the contrast of single noisy points, median-unbiased, with its 95 % interval.

    luminance, error: (n,) float64 [cd/m²], value and standard error, this from so many blocks.
    """
    from scipy.special import fdtrc

    from mpfcad.optics.base.recorder import freedom_of_sum

    if luminance.max() == luminance.min():
        return Estimate(0.0, 0.0, 0.0, 0.0)
    rng = np.random.Generator(np.random.Philox(seed))
    ends = np.zeros(len(luminance))
    ends[[np.argmax(luminance), np.argmin(luminance)]] = 1, -1
    wider = wobble(rng, _DRAWS, freedom_of_sum(ends, error, blocks))
    off, noise = (wider * rng.standard_normal((_DRAWS, len(error))) * error for _ in range(2))
    weight = 1 / np.maximum(error, _LEAST_ERROR * luminance.max()) ** 2
    left = len(luminance) - 1
    share = float(weight @ (luminance - np.average(luminance, weights=weight)) ** 2) / left
    of_errors = min(freedom_of_sum(np.sqrt(weight), error, blocks), 1e9)
    return contrast_of_draws(
        luminance[None], off[:, None], noise[:, None], luminance[None],
        may_be_flat=bool(fdtrc(left, of_errors, share) > TAIL), is_smoothed=False,
    )  # fmt: skip
