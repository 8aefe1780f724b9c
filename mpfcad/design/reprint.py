"""The map after a measurement of the print: the model corrected by what was seen, optimised again.

The measurement takes the place that a full trace has in the search (`design.search`): what its mean
and its first harmonics exceed the model's by, at the curvature that was printed, is carried over to
the next map (space mapping: Bandler et al. 1994). So it stands for all that backlight and print do
otherwise than assumed, as long as the next map is near the printed one.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import Constraint, cosine_basis, project, series_rows
from mpfcad.design.optimum import Correction, Goal, find_optimum, predict
from mpfcad.design.response import Response

_HARMONICS, _DRAWS, _SEED = 4, 400, 1


@dataclass(frozen=True, eq=False)
class Seen:
    """Cosines of a measured luminance over its mean, lamps at 0.

    Attributes
    ----------
    mean
        luminance [cd/m²]
    cosine, covariance
        (4,), (4, 4) float64, of harmonics 1 … 4
    """

    mean: float
    cosine: NDArray[np.float64]
    covariance: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reprint:
    """The next map.

    Attributes
    ----------
    position, curvature
        (rows,) float64: in pitches from a lamp, C [1/mm]
    contrast
        predicted lamp-Mura contrast with its 95 % interval: median and quantiles over the
        measurement's error. At the measurement itself the optimum is lower: it was searched there
    confidence
        share of the measurement's plausible truths with which the contrast is within the limit
    correction
        what the measurement says of the model
    before
        contrast that the model, not corrected, had for the printed map
    """

    position: NDArray[np.float64]
    curvature: NDArray[np.float64]
    contrast: tuple[float, float, float]
    confidence: float
    correction: Correction
    before: float


def find_reprint(
    place: NDArray[np.float64],
    printed: NDArray[np.float64],
    seen: Seen,
    response: Response,
    constraint: Constraint,
    goal: Goal,
    pitch: float,
    limit: float,
) -> Reprint:
    """Return the best map after a print of curvatures (n,) [1/mm] at places (n,) [pitch] was seen.

    The search starts from the printed map, brought within the constraints.
    """
    wide = Constraint(0.0, 2 * float(printed.max()) + 1, 1e6, max(constraint.harmonics, 8))
    made = project(place, printed, wide, pitch)
    centre = response.grid.centre
    # The model at the printed curvature itself, whatever the constraints of the next map.
    at = cosine_basis(centre, len(made) - 1) @ made
    model = response.luminance(at)
    basis = cosine_basis(centre, _HARMONICS)[:, 1:]
    known = 2 * (model / model.mean()) @ basis / len(centre)
    correction = Correction(seen.mean / float(model.mean()), seen.cosine - known)
    start = project(place, printed, constraint, pitch)
    series = find_optimum(start, response, correction, constraint, goal, pitch)
    rng = np.random.Generator(np.random.Philox(_SEED))
    root = np.linalg.cholesky(seen.covariance + 1e-16 * np.eye(_HARMONICS))
    off = rng.standard_normal((_DRAWS, _HARMONICS)) @ root.T
    best = predict(series, response, correction)
    drawn = np.array([_contrast(best.luminance, centre, each) for each in off])
    low, middle, high = (float(end) for end in np.quantile(drawn, (0.025, 0.5, 0.975)))
    position, rows = series_rows(series)
    return Reprint(
        position, rows, (middle, low, high), float(np.mean(drawn <= limit)),
        correction, _contrast(model, centre, np.zeros(_HARMONICS)),
    )  # fmt: skip


def _contrast(
    luminance: NDArray[np.float64], centre: NDArray[np.float64], off: NDArray[np.float64]
) -> float:
    """Return a curve's contrast when its harmonics are off by some parts of the mean."""
    curve = luminance / luminance.mean() + cosine_basis(centre, len(off))[:, 1:] @ off
    return float((curve.max() - curve.min()) / (curve.max() + curve.min()))
