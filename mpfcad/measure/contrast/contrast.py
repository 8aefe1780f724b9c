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
#: Errors of a difference within which two places, or two pitches, may be alike, and the largest
#: share of a pitch's range.
_ALIKE, _MOST = 2.0, 0.45


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
    curve = fit.curve
    high, low = _worst_places(curve, window)
    noise *= wobble(rng, draws, fit.freedom(fit.gain[high] - fit.gain[low]))
    smoothed = shape[:, at] @ fit.gain.T
    reader = _Reader(float(curve.mean()), curve[window], (noise @ fit.gain.T)[:, window])
    found = reader.unbiased(shape[:, window], smoothed[:, window])
    level = _level(reader.seen, reader.noise)
    if np.allclose(level, reader.seen, rtol=1e-9):
        return found
    level = level[None] - reader.mean
    least = reader.unbiased(level, level)
    return Estimate.within(found.value, min(least.low, found.low), found.high)


def _level(seen: NDArray[np.float64], noise: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return curves (w, m) in which all places are alike that may be so; noise: (draws, w, m).

    Where several places of the truth are nearly as high, the noise makes one of them the highest,
    in the points and in each shape drawn from them. Read again, such a shape gains less than the
    truth did. The least contrast that may have been read as the one seen is that of curves whose
    likely rivals, places with an error of their own, are as high as the highest, and whose pitches
    are as uneven as the worst (Andrews and Soares, "Inference for parameters defined by moment
    inequalities using generalized moment selection", 2010).
    """
    found, most = seen.copy(), _MOST * np.ptp(seen, axis=1, keepdims=True)
    for sign in (1, -1):
        place = np.argmax(sign * seen, axis=1)[:, None]
        end, error = np.take_along_axis(seen, place, 1), np.take_along_axis(noise, place[None], 2)
        below, apart = sign * (end - seen), (error - noise).std(axis=0)
        alike = (below < np.minimum(_ALIKE * apart, most)) & (apart > error.std(axis=0))
        found = np.where(alike, end, found)
    read, each = _contrast(seen), _contrast(seen + noise)
    worst = int(np.argmax(read))
    alike = read[worst] - read < _ALIKE * (each[:, [worst]] - each).std(axis=0)
    size = np.divide(read[worst], read, out=np.ones_like(read), where=alike & (read > 0))
    middle = found.mean(axis=1, keepdims=True)
    return middle + size[:, None] * (found - middle)


def _worst_places(curve: NDArray[np.float64], window: NDArray[np.int64]) -> tuple[int, int]:
    """Return where a curve is highest and lowest in the pitch of most contrast."""
    worst = window[int(np.argmax(_contrast(curve[window])))]
    return worst[np.argmax(curve[worst])], worst[np.argmin(curve[worst])]


@dataclass(frozen=True, eq=False)
class _Reader:
    """Reads the worst contrast of pitches.

    Attributes
    ----------
    mean
        of the whole curve [cd/m²]
    seen
        (w, m), what is read
    noise
        (draws, w, m), what the fit reads of noise alone
    """

    mean: float
    seen: NDArray[np.float64]
    noise: NDArray[np.float64]

    def unbiased(self, shape: NDArray[np.float64], smoothed: NDArray[np.float64]) -> Estimate:
        """Return the true contrasts of which, with noise, that of what is seen is read.

        shape: (draws, w, m) less the mean; smoothed: the same as the fit would read them.
        """
        top, bottom = shape.max(axis=2), shape.min(axis=2)

        def readings(contrast: float) -> NDArray[np.float64]:
            size = scale(contrast, self.mean, top, bottom).min(axis=1)
            return _contrast(size[:, None, None] * smoothed + self.noise + self.mean).max(axis=1)

        return invert(float(_contrast(self.seen).max()), readings)


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
