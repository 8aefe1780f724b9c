"""How uneven the luminance over a lamp pitch is, from its Fourier series: robust to noise."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast import Estimate, HarmonicFit

_Z95 = 1.959963984540054


def harmonic_amplitude(fit: HarmonicFit, order: int) -> Estimate:
    """Return the amplitude of one harmonic over the mean, √(a² + b²)/c0.

    The power that the noise alone gives, tr V, is taken off; the interval ends at 0.
    """
    part = slice(2 * order - 1, 2 * order + 1)
    return _root_power(fit.coefficient[part], fit.covariance[part, part], fit.coefficient[0])


def relative_spread(fit: HarmonicFit) -> Estimate:
    """Return σ/mean of the luminance over the pitch, √(½ Σ (a² + b²))/c0 (Parseval)."""
    scale = np.sqrt(0.5)
    return _root_power(
        scale * fit.coefficient[1:], scale**2 * fit.covariance[1:, 1:], fit.coefficient[0]
    )


def _root_power(
    part: NDArray[np.float64], covariance: NDArray[np.float64], mean: float
) -> Estimate:
    """Return √(|c|² - tr V)/mean with its interval; Var |c|² = 4 c'Vc + 2 tr V²."""
    noise = np.trace(covariance)
    power = part @ part - noise
    # |c|² of the truth is nearer to `power` than to what was read.
    spread = np.sqrt(
        4 * max(part @ covariance @ part - np.trace(covariance @ covariance), 0.0)
        + 2 * np.trace(covariance @ covariance)
    )
    value, low, high = (
        float(np.sqrt(max(0.0, p)) / mean)
        for p in (power, power - _Z95 * spread, power + _Z95 * spread)
    )
    return Estimate(value, low, high, (high - low) / (2 * _Z95))
