"""Lamp-Mura contrast from noisy luminances, without the bias of a noisy maximum and minimum.

Contrast is (Lmax - Lmin)/(Lmax + Lmin) over one lamp pitch (Hsieh, MPF thesis, eq. 10). Maximum and
minimum of 33 noisy points overstate it by about two standard errors. Here the curve is one fitted
to all points (`curve`); what bias is left in its contrast is taken out by asking which true
contrast gives, with the points' noise, the contrast read as its median (estimate), 97.5th and
2.5th percentile (ends of the 95 % interval). The answer depends on the curve's shape, which is
known only as well as the fit: each draw has a shape of its own. Of several pitches the worst
counts.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.bias import invert, plausible, scale
from mpfcad.measure.contrast.curve import CurveFit
from mpfcad.measure.estimate import Estimate, wobble

_DRAWS = 1000
#: By how many of its errors a curve's top and bottom are cut off, smoothed or (points alone) not,
#: and the largest share of its range: what simulated curves with flat or equal tops ask for.
_BLUNT, _BLUNT_SHARP, _MOST_BLUNT = 0.6, 2.5, 0.45


def contrast_of_curve(fit: CurveFit, seed: int = 0, *, points: int | None = None) -> Estimate:
    """Return the lamp-Mura contrast of a fitted curve, median-unbiased, with its 95 % interval.

    Of a curve over several pitches it is that of the worst one. `points`: the curve is read at so
    many a pitch, from one lamp to the next, both included; None for all readings. The noise draws
    are fixed by `seed`; the result is deterministic.
    """
    window = fit.window
    if points is not None:
        window = window[:, :: (window.shape[1] - 1) // (points - 1)]
    return _contrast_within(fit, window, seed)


def contrasts_of_pitches(fit: CurveFit, seed: int = 0) -> list[Estimate]:
    """Return the contrast of each pitch of a curve on its own."""
    return [_contrast_within(fit, window[None], seed) for window in fit.window]


def _contrast_within(fit: CurveFit, window: NDArray[np.int64], seed: int) -> Estimate:
    rng = np.random.Generator(np.random.Philox(seed))
    draws = _DRAWS if len(fit.window) == 1 else _DRAWS // 2
    shape = fit.draw(rng, draws)
    shape -= shape.mean(axis=1, keepdims=True)
    at = np.searchsorted(fit.reading, fit.position - 1e-9)
    noise = rng.standard_normal((draws, len(fit.error))) * (fit.misfit * fit.error)
    # What the reading's error is known to: that of the difference of its two ends.
    high, low = _worst_places(fit.curve, window)
    noise *= wobble(rng, draws, fit.freedom(fit.gain[high] - fit.gain[low]))
    curve = fit.curve
    reader = _Windows(window, float(curve.mean()))
    of_noise = noise @ fit.gain.T
    found = reader.unbiased(curve, shape, shape[:, at] @ fit.gain.T, of_noise)
    by = (_BLUNT_SHARP if fit.is_sharp else _BLUNT) * fit.reading_error
    blunt = _blunt(curve, window, by)
    least = reader.unbiased(curve, blunt[None], (fit.gain @ blunt[at])[None], of_noise)
    return Estimate.within(found.value, min(least.low, found.low), found.high)


def _blunt(
    curve: NDArray[np.float64], window: NDArray[np.int64], by: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return a curve (k,), less its mean, whose top and bottom in each window are cut off.

    By so much (k,), and by 45 % of the range at most. Where several places of the truth are nearly
    as high, the noise makes one of them the highest, in the points and in each shape drawn from
    them. Read again, such a shape gains less than the truth did. The least contrast that may have
    been read as the one seen is that of a shape whose highest places are alike (Andrews and Soares,
    "Inference for parameters defined by moment inequalities using generalized moment selection",
    2010).
    """
    found = curve.copy()
    for one in window:
        within = curve[one]
        most = _MOST_BLUNT * np.ptp(within)
        top = within.max() - min(by[one][np.argmax(within)], most)
        bottom = within.min() + min(by[one][np.argmin(within)], most)
        found[one] = within.clip(bottom, top)
    return found - found.mean()


def _worst_places(curve: NDArray[np.float64], window: NDArray[np.int64]) -> tuple[int, int]:
    """Return where a curve is highest and lowest in the pitch of most contrast."""
    worst = window[int(np.argmax(_contrast(curve[window])))]
    return worst[np.argmax(curve[worst])], worst[np.argmin(curve[worst])]


@dataclass(frozen=True, eq=False)
class _Windows:
    """Reads the worst contrast of curves (n, k) over windows (w, m) of their readings."""

    window: NDArray[np.int64]
    mean: float

    def read(self, curve: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the contrast of the worst window of each curve, (n,)."""
        return _contrast(curve[:, self.window]).max(axis=1)

    def unbiased(
        self,
        seen: NDArray[np.float64],
        shape: NDArray[np.float64],
        smoothed: NDArray[np.float64],
        noise: NDArray[np.float64],
    ) -> Estimate:
        """Return the true contrasts of which, with noise, that of a curve `seen` (k,) is read.

        shape: (draws, k) without level; smoothed: the same as the fit would read them; noise: what
        the fit reads of noise alone.
        """
        within = shape[:, self.window]
        top, bottom = within.max(axis=2), within.min(axis=2)

        def readings(contrast: float) -> NDArray[np.float64]:
            size = scale(contrast, self.mean, top, bottom).min(axis=1)
            return self.read(size[:, None] * smoothed + noise + self.mean)

        return invert(float(self.read(seen[None])[0]), readings)


def contrast_of_points(
    luminance: NDArray[np.float64],
    error: NDArray[np.float64],
    blocks: float = np.inf,
    seed: int = 0,
) -> Estimate:
    """Return the contrast of single noisy points, median-unbiased, with its 95 % interval.

    luminance, error: (n,) float64 [cd/m²], value and standard error, this from so many blocks.
    """
    from mpfcad.optics.base.recorder import freedom_of_sum

    shape = luminance - luminance.mean()
    if shape.max() == shape.min():
        return Estimate(0.0, 0.0, 0.0, 0.0)
    rng = np.random.Generator(np.random.Philox(seed))
    noise, other = (rng.standard_normal((_DRAWS, len(luminance))) * error for _ in range(2))
    ends = np.zeros(len(luminance))
    ends[[np.argmax(luminance), np.argmin(luminance)]] = 1, -1
    noise *= wobble(rng, _DRAWS, freedom_of_sum(ends, error, blocks))
    power = float(np.sum((shape / np.maximum(error, 1e-12 * luminance.max())) ** 2))
    shapes = plausible(shape, power, other, rng)
    top, bottom, mean = shapes.max(axis=1), shapes.min(axis=1), float(luminance.mean())

    def readings(contrast: float) -> NDArray[np.float64]:
        return _contrast(scale(contrast, mean, top, bottom)[:, None] * shapes + noise + mean)

    return invert(float(_contrast(luminance)), readings)


def _contrast(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (max - min)/(max + min) over the last axis."""
    high, low = curve.max(axis=-1), curve.min(axis=-1)
    return (high - low) / (high + low)
