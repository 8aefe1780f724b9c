"""How well a fitted trace is known: from groove to groove, and from its residual's correlation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.model import FILL, PITCH, ROUNDING, SLOPE, Fitted

#: Grooves from which their own scatter gives the interval.
FEWEST_GROOVES = 4
_Z = 1.959964
#: A prior standard deviation of u that matters only where nothing depends on u.
_ANY_FILL = 1.0
#: What is unseen counts from so many linear half-widths on.
_FARTHER = 1.5
#: Common shifts of all u that are tried, a side.
_SHIFTS = 60


@dataclass(frozen=True)
class Spread:
    """95 % half-widths of a fit.

    Attributes
    ----------
    fill
        of the mean u
    log_curvature, log_pitch, log_slope
        of the logarithms of C, pitch and slope
    unseen
        by how much the mean u can fall, and rise, before the trace changes by more than its noise;
        0 unless that is much more than `fill`
    """

    fill: float
    log_curvature: float
    log_pitch: float
    log_slope: float
    unseen: tuple[float, float]


def spread_of(fit: Fitted) -> Spread:
    """Return the half-widths of a fit.

    Noise: the larger of two. The scatter of the grooves' own u, by Student's t, holds noise of any
    correlation, waviness and grooves that differ; the residual's variance times the sum of its
    autocorrelation, propagated, holds what all grooves share. What the priors of pitch and slope
    leave open is added. A tip that does not reach the resin leaves it `unseen`.
    """
    from scipy.special import stdtrit

    model, value = fit.model, fit.value
    residual = model.residual(value)
    correlation = correlation_sum(residual)
    free, design, prior = _design(fit)
    left = max(len(residual) - design.shape[1], 1)
    noise = max(float(np.sqrt(np.sum(residual**2) / left)), fit.noise) * np.sqrt(correlation)
    normal = design.T @ design
    known = noise**2 * prior.T @ prior
    size = np.sqrt(np.diag(normal + known))
    inverse = np.linalg.pinv((normal + known) / np.outer(size, size), rcond=1e-12, hermitian=True)
    wanted = _wanted(fit, free, design.shape[1]) / size @ inverse / size
    by_noise = noise**2 * np.einsum("ij,jk,ik->i", wanted, normal, wanted)
    told = noise**2 * prior[:3].T @ prior[:3]
    by_prior = noise**2 * np.einsum("ij,jk,ik->i", wanted, told, wanted)
    count = len(fit.fills)
    freedom = max(len(residual) / correlation - design.shape[1], 2.0)
    half = float(stdtrit(freedom, 0.975)) * np.sqrt(by_noise)
    if count >= FEWEST_GROOVES:
        scatter = float(np.std(fit.fills, ddof=1) / np.sqrt(count) * stdtrit(count - 1.0, 0.975))
        half[0] = max(half[0], scatter)
        half[1] = max(half[1], scatter / max(float(np.mean(fit.fills)), 1e-6))
    half = np.sqrt(half**2 + _Z**2 * by_prior)
    unseen = _unseen(fit, design[:, [i for i, name in enumerate(free) if name < FILL]], noise)
    fill, log_curvature, log_pitch, log_slope = (float(h) for h in half)
    down, up = (far if far > _FARTHER * fill else 0.0 for far in unseen)
    return Spread(fill, log_curvature, log_pitch, log_slope, (down, up))


def _design(fit: Fitted) -> tuple[list[int], NDArray[np.float64], NDArray[np.float64]]:
    """Return the free values, their columns and the base's (n, k), and the priors' rows (…, k)."""
    model = fit.model
    columns = model.jacobian(fit.value)
    low, high = model.bounds()
    # A rounding at its bound moves to one side only: it is taken as known.
    inside = low[ROUNDING] + 1e-6 < fit.value[ROUNDING] < high[ROUNDING]
    free = [i for i in range(columns.shape[1]) if i != ROUNDING or inside]
    design = np.column_stack([columns[:, free], model.base])
    prior = np.zeros((3 + model.grooves, design.shape[1]))
    prior[:3, : len(free)] = model.prior_jacobian()[:, free]
    for k in range(model.grooves):
        prior[3 + k, free.index(FILL + k)] = 1 / _ANY_FILL
    return free, design, prior


def _wanted(fit: Fitted, free: list[int], width: int) -> NDArray[np.float64]:
    """Return the derivatives of mean u, ln C, ln pitch and ln slope by the columns, (4, width)."""
    value, mean = fit.value, max(float(np.mean(fit.fills)), 1e-6)
    rows = np.zeros((4, width))
    for k in np.flatnonzero(fit.whole):
        rows[0, free.index(FILL + int(k))] = 1 / len(fit.fills)
    rows[1] = rows[0] / mean
    rows[1, free.index(SLOPE)] = 1 / value[SLOPE]
    rows[1, free.index(PITCH)] = -1 / value[PITCH]
    rows[2, free.index(PITCH)] = 1 / value[PITCH]
    rows[3, free.index(SLOPE)] = 1 / value[SLOPE]
    return rows


def _unseen(fit: Fitted, shape: NDArray[np.float64], noise: float) -> tuple[float, float]:
    """Return how far all u can be moved together, down and up, and not be told from the fit.

    Told is what changes the trace, less what pitch, slope, centre, rounding and base make up for,
    by more than 95 % of noise does: a sum of squares above 3.84 of its variance.
    """
    model, value = fit.model, fit.value
    other = np.linalg.qr(np.column_stack([shape, model.base]))[0]
    there, mean = model.surface(value), float(np.mean(fit.fills))
    found = []
    for sign in (-1.0, 1.0):
        reach = mean if sign < 0 else model.top - mean
        last = 0.0
        for step in np.linspace(0.0, 1.0, _SHIFTS + 1)[1:] ** 2 * max(reach, 0.0):
            moved = value.copy()
            moved[FILL:] = np.clip(value[FILL:] + sign * step, 0.0, model.top)
            change = model.surface(moved) - there
            change = change - other @ (other.T @ change)
            if float(np.sum(change**2)) > _Z**2 * noise**2:
                break
            last = float(abs(np.mean(moved[FILL:][fit.whole]) - mean))
        found.append(last)
    return found[0], found[1]


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
