"""The contrast of curves that are known with noise: its interval from draws of them.

Curves drawn from what the data allow have contrasts of their own, and these are the interval where
one place is the highest and one the lowest. Where several places are nearly as high, the noise
makes one of them the highest, in the curve read and in each curve drawn. The least contrast that
may have been read as the one seen is then that of a curve whose rivals are as high as they may be
(Romano, Shaikh and Wolf, "A practical two-step method for testing moment inequalities", 2014). The
most is that of the pair of places that may differ most
(Chernozhukov, Lee and Rosen, "Intersection bounds", 2013): the maximum of noise adds nothing to it.
"""

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.estimate import TAIL, Estimate, reach

#: Errors of a difference by which two places, or two pitches, may be more alike than they are read;
#: the largest share of a pitch's range.
_ALIKE, _MOST = 2.0, 0.45


def contrasts(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (max - min)/(max + min) over the last axis."""
    high, low = curve.max(axis=-1), curve.min(axis=-1)
    return (high - low) / (high + low)


def contrast_of_draws(
    curve: NDArray[np.float64],
    off: NDArray[np.float64],
    noise: NDArray[np.float64],
    again: NDArray[np.float64],
    *,
    may_be_flat: bool = False,
    is_smoothed: bool = True,
    has_kinks: bool = True,
) -> Estimate:
    """Return the largest contrast of pitches, median-unbiased, with its 95 % interval.

    Parameters
    ----------
    curve
        (w, m) float64 [cd/m²], the curve over each pitch
    off
        (draws, w, m), how far off it may be
    noise
        (draws, w, m), what of that is read of noise alone
    again
        (w, m), what is read of `curve` itself: as much flatter as it is flatter than the truth
    may_be_flat
        whether the data allow no contrast at all
    is_smoothed
        whether the curve is another than the points themselves
    has_kinks
        whether the truth may be pointed: a smoothed curve is lower there
    """
    seen = float(contrasts(curve).max())
    drawn = contrasts(curve + off).max(axis=1)
    low, middle, high = (float(q) for q in np.quantile(drawn, (TAIL, 0.5, 1 - TAIL)))
    # Noise makes the highest place higher, smoothing lower: both once more in what is read again.
    bias = float(np.median(contrasts(again + noise).max(axis=1))) - seen
    value = min(max(seen - bias, 0.0), middle)
    most = max(_widest_pair(one, off[:, i], seen) for i, one in enumerate(curve))
    is_known = len(curve) > 1 or not has_kinks
    if not may_be_flat and (is_known or not is_smoothed):
        # Noise makes one pitch or point the worst: once in what is seen, twice in the draws.
        most = min(most, seen - bias + high - middle)
    high = min(high, most)
    level = _level(curve, off)
    added = contrasts(level + noise).max(axis=1) - float(contrasts(level).max())
    # Where places are alike the high end hardly misses, and the low end may as much oftener.
    spare = max(TAIL - float(np.mean(added < seen - high)), 0.0) if is_known else 0.0
    low = min(low, seen - float(np.quantile(added, 1 - TAIL - spare)))
    if may_be_flat:
        flat = float(np.median(contrasts(curve.mean() + noise).max(axis=1)))
        value, low = min(value, np.sqrt(max(seen**2 - flat**2, 0.0))), 0.0
    return Estimate.within(value, min(max(low, 0.0), value), min(max(high, value), 1.0))


def _level(curve: NDArray[np.float64], off: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return curves (w, m) in which all places are as alike as they may be.

    A place is raised by two errors of its difference from the highest, as far as that is high;
    likewise low places, and the contrasts of pitches that are less uneven than the worst.
    """
    found, most = curve.copy(), _MOST * np.ptp(curve, axis=1, keepdims=True)
    for sign in (1, -1):
        place = np.argmax(sign * curve, axis=1)[:, None]
        end, error = np.take_along_axis(curve, place, 1), np.take_along_axis(off, place[None], 2)
        below, apart = sign * (end - curve), (error - off).std(axis=0)
        found += sign * np.where(below < most, np.minimum(below, _ALIKE * apart), 0.0)
    read, each = contrasts(curve), contrasts(curve + off)
    worst = int(np.argmax(read))
    apart = (each[:, [worst]] - each).std(axis=0)
    raised = np.minimum(read[worst], read + _ALIKE * apart)
    size = np.divide(raised, read, out=np.ones_like(read), where=read > 0)
    middle = found.mean(axis=1, keepdims=True)
    return middle + size[:, None] * (found - middle)


def _widest_pair(curve: NDArray[np.float64], off: NDArray[np.float64], seen: float) -> float:
    """Return the largest contrast that any pair of places of a pitch has at its upper end.

    curve: (m,); off: (draws, m). With c = `seen`, (1-c)·L1 - (1+c)·L2 has the sign of their
    contrast less c.
    """
    top, bottom = 1 - seen, 1 + seen
    covariance = off.T @ off / len(off)
    variance = np.diag(covariance)
    spread = top**2 * variance[:, None] + bottom**2 * variance - 2 * top * bottom * covariance
    above = top * curve[:, None] - bottom * curve + reach() * np.sqrt(np.maximum(spread, 0.0))
    return seen + float(above.max()) / float(curve.max() + curve.min())
