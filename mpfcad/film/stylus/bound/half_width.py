"""Half-widths of what a fit gives, by derivatives: noise, grooves that differ, priors, shape."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.model import (
    FILL,
    FLATNESS,
    PITCH,
    PRIORS,
    ROUNDING,
    ROUNDNESS,
    SLOPE,
    WETTING,
    WETTING_OFF,
)
from mpfcad.film.stylus.residual import shape_misfit
from mpfcad.film.stylus.solve import Fitted

_Z = 1.959964
#: Grooves from which their own scatter gives the interval.
FEWEST_GROOVES = 4
#: From groove to groove where they are too few to tell: relative standard deviation of u, assumed.
_DIFFER = 0.03
#: By how many ways to depart what the mean shape leaves is divided to be what it hides along one
#: that is sought. Circular menisci ask for so few.
_SHAPES = 3
#: A prior standard deviation of u that matters only where nothing depends on u.
_ANY_FILL = 1.0
#: Halvings of a change of wetting.
_STEPS = 10


def half_widths(
    fit: Fitted,
    columns: NDArray[np.float64],
    noise: float,
    freedom: float,
    known: tuple[int, ...] = (),
) -> NDArray[np.float64]:
    """Return half-widths, in the order of `derivatives_of`, (7,), by `design_of`'s columns.

    known: values that are.
    """
    from scipy.special import stdtrit

    free, design, prior = free_columns(fit, columns, known)
    normal = design.T @ design
    prior_normal = noise**2 * prior.T @ prior
    size = np.sqrt(np.diag(normal + prior_normal))
    inverse = np.linalg.pinv(
        (normal + prior_normal) / np.outer(size, size), rcond=1e-12, hermitian=True
    )
    wanted = derivatives_of(fit, free, design.shape[1]) / size @ inverse / size
    # As sums of squares: a difference of rounded products may fall below 0.
    by_noise = noise**2 * np.sum((wanted @ design.T) ** 2, axis=1)
    by_prior = noise**4 * np.sum((wanted @ prior[:PRIORS].T) ** 2, axis=1)
    half: NDArray[np.float64] = float(stdtrit(freedom, 0.975)) * np.sqrt(by_noise)
    count, mean = len(fit.fills), max(float(np.mean(fit.fills)), 1e-6)
    if count >= FEWEST_GROOVES:
        scatter = float(np.std(fit.fills, ddof=1) / np.sqrt(count) * stdtrit(count - 1.0, 0.975))
        half[:2] = np.maximum(half[:2], [scatter, scatter / mean])
    else:
        seen = max(round(float(np.ptp(fit.model.x) / fit.value[PITCH])), 1)
        scatter = _Z * _DIFFER / np.sqrt(seen)
        half[:2] = np.hypot(half[:2], [scatter * mean, scatter])
    # What a mean shape that is not the model's may hide along the values sought: its sum of squares
    # is as of a few ways to depart.
    shape = by_noise / noise**2 * len(design) * shape_misfit(fit) ** 2 / _SHAPES
    whole: NDArray[np.float64] = np.sqrt(half**2 + _Z**2 * (by_prior + shape))
    return whole


def design_of(fit: Fitted, noise: float) -> NDArray[np.float64]:
    """Return the columns of all values and of the base, (n, k).

    Resin that stands a little below the tips is told from more of it by the corner alone that it
    leaves bare, which grows as the square. So the wetting's column is the difference over what
    noise leaves open, one deviation, and no derivative.
    """
    model, value = fit.model, fit.value
    columns = np.column_stack([model.jacobian(value), model.base])
    if model.profile == "ideal":
        return columns
    there = model.surface(value)
    other = np.linalg.qr(np.delete(columns, WETTING, axis=1))[0]
    for part in 0.5 ** np.arange(_STEPS):
        moved = value.copy()
        moved[WETTING] -= part * WETTING_OFF
        change = there - model.surface(moved)
        left = change - other @ (other.T @ change)
        columns[:, WETTING] = change / (part * WETTING_OFF)
        if float(np.sum(left**2)) <= noise**2:
            break
    return columns


def free_columns(
    fit: Fitted, columns: NDArray[np.float64], known: tuple[int, ...]
) -> tuple[list[int], NDArray[np.float64], NDArray[np.float64]]:
    """Return the free values, their columns and the base's (n, k), and the priors' rows (…, k)."""
    model = fit.model
    count = len(fit.value)
    low, high = model.bounds()
    # A rounding at its bound moves to one side only: it is taken as known.
    inside = low[ROUNDING] + 1e-6 < fit.value[ROUNDING] < high[ROUNDING]
    free = [i for i in range(count) if (i != ROUNDING or inside) and i not in known]
    design = np.column_stack([columns[:, free], columns[:, count:]])
    prior = np.zeros((PRIORS + model.grooves, design.shape[1]))
    prior[:PRIORS, : len(free)] = model.prior_jacobian(fit.value)[:, free]
    for k in range(model.grooves):
        prior[PRIORS + k, free.index(FILL + k)] = 1 / _ANY_FILL
    return free, design, prior


def derivatives_of(fit: Fitted, free: list[int], width: int) -> NDArray[np.float64]:
    """Return the derivatives of what is wanted by the columns, (7, width).

    That is mean u, ln C, ln pitch, ln slope, wetting, roundness, flatness.
    """
    value, mean = fit.value, max(float(np.mean(fit.fills)), 1e-6)
    rows = np.zeros((7, width))
    for k in np.flatnonzero(fit.whole):
        rows[0, free.index(FILL + int(k))] = 1 / len(fit.fills)
    rows[1] = rows[0] / mean
    if SLOPE in free:
        rows[1, free.index(SLOPE)] = rows[3, free.index(SLOPE)] = 1 / value[SLOPE]
    rows[1, free.index(PITCH)] = -1 / value[PITCH]
    rows[2, free.index(PITCH)] = 1 / value[PITCH]
    if WETTING in free:
        rows[4, free.index(WETTING)] = 1.0
    rows[5, free.index(ROUNDNESS)] = 1.0
    rows[6, free.index(FLATNESS)] = 1.0
    return rows
