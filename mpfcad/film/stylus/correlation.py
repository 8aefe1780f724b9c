"""How neighbours in a residual correlate."""

import numpy as np
from numpy.typing import NDArray


def correlation_sum(residual: NDArray[np.float64]) -> float:
    """Return 1 + 2 Σ ρ_k up to the first ρ_k ≤ 0: by how much correlation widens a variance."""
    n = len(residual)
    spectrum = np.abs(np.fft.rfft(residual - residual.mean(), 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[:n]
    if not covariance[0] > 0:
        return 1.0
    rho = covariance[1:] / covariance[0]
    end = int(np.argmax(rho <= 0)) if np.any(rho <= 0) else len(rho)
    return float(min(1 + 2 * np.sum(rho[:end]), n / 5))
