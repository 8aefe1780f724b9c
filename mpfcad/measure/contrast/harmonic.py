"""How uneven the luminance over a lamp pitch is, from its Fourier series: robust to noise."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.fit import HarmonicFit
from mpfcad.measure.estimate import TAIL, Estimate, reach

#: |c|² in units of noise from which |c| is normal to 0.3 % of an interval.
_LONG = 3000.0


def harmonic_amplitude(fit: HarmonicFit, order: int) -> Estimate:
    """Return the amplitude of one harmonic over the mean, √(a² + b²)/c0.

    The power that the noise alone gives, tr V, is taken off; the interval ends at 0.
    """
    return _root_power(fit, slice(2 * order - 1, 2 * order + 1), 1.0)


def relative_spread(fit: HarmonicFit) -> Estimate:
    """Return σ/mean of the luminance over the pitch, √(½ Σ (a² + b²))/c0 (Parseval)."""
    return _root_power(fit, slice(1, None), np.sqrt(0.5))


def vector_length(
    vector: NDArray[np.float64], covariance: NDArray[np.float64], freedom: float
) -> Estimate:
    """Return the length of a noisy vector, (n,) and (n, n), with its interval that ends at 0.

    Its noise is taken as alike in all directions, of the variance along the vector; the power that
    noise alone gives, tr V, is taken off.
    """
    power = float(vector @ vector)
    if power == 0.0 or np.trace(covariance) == 0.0:
        length = float(np.sqrt(power))
        return Estimate(length, length, length, 0.0)
    unit = float(np.sqrt(vector @ covariance @ vector / power))
    low, high = (unit * end for end in _length(power / unit**2, len(vector)))
    wider, read = reach(freedom) / reach(), float(np.sqrt(power))
    ends = (read - wider * (read - low) if low > 0 else 0.0, read + wider * (high - read))
    value = float(np.sqrt(max(power - np.trace(covariance), 0.0)))
    return Estimate.within(value, max(ends[0], 0.0), ends[1])


def _root_power(fit: HarmonicFit, columns: slice, scale: float) -> Estimate:
    """Return scale · √(|c|² - tr V)/mean with its interval, from that of |c| in units of noise."""
    part, covariance = fit.coefficient[columns], fit.covariance[columns, columns]
    weight = np.zeros_like(fit.coefficient)
    weight[columns] = part
    power, noise = part @ part, np.trace(covariance)
    unit = np.sqrt(noise / len(part))
    low, high = (unit * end for end in _length(power / unit**2, len(part)))
    # Uncertain errors widen it as they do any interval.
    wider, read = reach(fit.freedom(weight)) / reach(), np.sqrt(power)
    ends = (read - wider * (read - low) if low > 0 else 0.0, read + wider * (high - read))
    value, low, high = (
        float(scale * max(length, 0.0) / fit.coefficient[0])
        for length in (np.sqrt(max(power - noise, 0.0)), *ends)
    )
    return Estimate.within(value, low, high)


def _length(square: float, dimensions: int) -> tuple[float, float]:
    """Return the 95 % interval of a vector's length; read: its square with unit normal noise.

    |c|² is of the noncentral χ² distribution, whose noncentrality is the true |c|² (inverted by
    scipy). One shorter than most that are 0 gets the end of the median one, as a contrast does.
    """
    from scipy.special import chdtr, chdtri, chndtrinc

    if square > _LONG:
        middle = np.sqrt(square - (dimensions - 1))
        return float(middle - reach()), float(middle + reach())
    above = max(square, chdtri(dimensions, 0.5))
    low = 0.0
    if chdtr(dimensions, square) > 1 - TAIL:
        low = float(np.sqrt(chndtrinc(square, dimensions, 1 - TAIL)))
    return low, float(np.sqrt(chndtrinc(above, dimensions, TAIL)))
