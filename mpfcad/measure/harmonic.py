"""How uneven the luminance over a lamp pitch is, from its Fourier series: robust to noise."""

import numpy as np

from mpfcad.measure.estimate import Estimate, reach
from mpfcad.measure.harmonic_fit import HarmonicFit


def harmonic_amplitude(fit: HarmonicFit, order: int) -> Estimate:
    """Return the amplitude of one harmonic over the mean, √(a² + b²)/c0.

    The power that the noise alone gives, tr V, is taken off; the interval ends at 0.
    """
    return _root_power(fit, slice(2 * order - 1, 2 * order + 1), 1.0)


def relative_spread(fit: HarmonicFit) -> Estimate:
    """Return σ/mean of the luminance over the pitch, √(½ Σ (a² + b²))/c0 (Parseval)."""
    return _root_power(fit, slice(1, None), np.sqrt(0.5))


def _root_power(fit: HarmonicFit, columns: slice, scale: float) -> Estimate:
    """Return scale · √(|c|² - tr V)/mean with its interval; Var |c|² = 4 c'Vc + 2 tr V²."""
    part, covariance = fit.coefficient[columns], fit.covariance[columns, columns]
    weight = np.zeros_like(fit.coefficient)
    weight[columns] = part
    wide = reach(fit.freedom(weight))
    noise = np.trace(covariance)
    power = part @ part - noise
    # |c|² of the truth is nearer to `power` than to what was read.
    spread = np.sqrt(
        4 * max(part @ covariance @ part - np.trace(covariance @ covariance), 0.0)
        + 2 * np.trace(covariance @ covariance)
    )
    value, low, high = (
        float(scale * np.sqrt(max(0.0, p)) / fit.coefficient[0])
        for p in (power, power - wide * spread, power + wide * spread)
    )
    return Estimate.within(value, low, high)
