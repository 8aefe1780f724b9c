"""Contrast and luminance against the film's curvature: a parabola through the traces' harmonics.

Harmonics are smooth in the curvature where the contrast, a maximum less a minimum, is not; and a
parabola through several traces averages the noise that each has.
"""

import numpy as np
from numpy.typing import NDArray

#: Cosines of an order above 2 are lost in the noise of the traces.
HARMONICS = 2
#: The published limit of the good range: the conventional stack's contrast.
LIMIT = 0.012
CURVATURE = np.arange(50.0, 81.5, 1.0)
_FINE = np.linspace(50, 81, 125)
_DRAWS = 400
_PHASE = np.arange(129) / 256
_COSINES = np.cos(2 * np.pi * np.arange(1, HARMONICS + 1) * _PHASE[:, None])


def contrast(amplitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (Lmax - Lmin)/(Lmax + Lmin) of 1 + Σ a_h cos 2πhu (Hsieh, MPF thesis, eq. 10).

    `amplitude`: (..., 2) float64; returns (...).
    """
    curve = 1 + amplitude @ _COSINES.T
    high, low = curve.max(-1), curve.min(-1)
    return (high - low) / (high + low)


def by_curvature(
    curvature: NDArray[np.float64],
    reading: NDArray[np.float64],
    error: NDArray[np.float64],
    seed: int = 3,
) -> dict:
    """Return contrast and relative luminance over `CURVATURE` with 95 % intervals, and the range.

    The range is where contrast is at most `LIMIT` within the traced 50 … 81 /mm; its ends are NaN
    where there is no such curvature. Intervals are the middle 95 % of parabolas drawn with their
    uncertainty.

    Parameters
    ----------
    curvature
        (n,) float64 of the traces [1/mm], four or more
    reading, error
        (n, 3) float64: ln of the mean luminance over the conventional stack's, and the cosines'
        amplitudes over the mean, with their standard errors
    """
    drawn = _parabolas(curvature, reading, error, seed)

    def band(of) -> dict[str, list]:
        values = of(_at(CURVATURE, drawn))
        low, high = np.percentile(values[1:], [2.5, 97.5], axis=0)
        return {"value": values[0].tolist(), "low": low.tolist(), "high": high.tolist()}

    places = _places(contrast(_at(_FINE, drawn)[..., 1:]))
    low, high = np.nanpercentile(places[1:], [2.5, 97.5], axis=0)
    names = ("range_low_per_mm", "range_high_per_mm", "best_per_mm")
    return {
        "curvature_per_mm": CURVATURE.tolist(),
        "contrast": band(lambda found: contrast(found[..., 1:])),
        "luminance": band(lambda found: np.exp(found[..., 0])),
        **{
            name: [float(v) for v in (places[0, i], low[i], high[i])]
            for i, name in enumerate(names)
        },
    }


def _parabolas(curvature, reading, error, seed: int) -> NDArray[np.float64]:
    """Return the coefficients of the best parabolas, and of those drawn, (1 + draws, 3, 3).

    Where the traces scatter by more than their noise, the errors are widened to it.
    """
    rng = np.random.Generator(np.random.Philox(seed))
    power = _powers(curvature)
    found = np.empty((1 + _DRAWS, power.shape[1], reading.shape[1]))
    for i, (values, sigma) in enumerate(zip(reading.T, error.T, strict=True)):
        weighted = power / sigma[:, None]
        inverse = np.linalg.inv(weighted.T @ weighted)
        best = inverse @ weighted.T @ (values / sigma)
        freedom = len(values) - len(best)
        chi2 = float((((values - power @ best) / sigma) ** 2).sum())
        root = np.linalg.cholesky(inverse * max(1.0, chi2 / max(1, freedom)))
        found[0, :, i] = best
        found[1:, :, i] = best + rng.standard_normal((_DRAWS, len(best))) @ root.T
    return found


def _powers(curvature: NDArray) -> NDArray[np.float64]:
    return ((curvature[:, None] - 65) / 15) ** np.arange(3)


def _at(curvature: NDArray, parabolas: NDArray) -> NDArray[np.float64]:
    """Return readings (draws, curvatures, 3)."""
    return np.einsum("cp,dpr->dcr", _powers(curvature), parabolas)


def _places(values: NDArray) -> NDArray[np.float64]:
    """Return (lower edge, upper edge, minimum) of each drawn contrast [1/mm], (draws, 3)."""
    good = values <= LIMIT
    some = good.any(1)
    low = np.where(some, _FINE[good.argmax(1)], np.nan)
    high = np.where(some, _FINE[::-1][good[:, ::-1].argmax(1)], np.nan)
    return np.stack([low, high, _FINE[values.argmin(1)]], axis=1)
