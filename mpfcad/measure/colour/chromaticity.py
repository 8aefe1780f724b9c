"""Chromaticities of noisy X, Y, Z: ratios, with the error that the blocks of a trace tell."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.harmonic import vector_length
from mpfcad.measure.estimate import Estimate
from mpfcad.spectrum import chromaticity, uniform_chromaticity

#: x, y, u', v' are numerator over denominator of X, Y, Z.
_NUMERATOR = {"x": (1, 0, 0), "y": (0, 1, 0), "u": (4, 0, 0), "v": (0, 9, 0)}
_DENOMINATOR = {"x": (1, 1, 1), "y": (1, 1, 1), "u": (1, 15, 3), "v": (1, 15, 3)}


@dataclass(frozen=True)
class Colour:
    """The colour of one light.

    Attributes
    ----------
    luminance
        Y [cd/m²]
    x, y, u, v
        CIE 1931 x, y; CIE 1976 u', v'
    """

    luminance: Estimate
    x: Estimate
    y: Estimate
    u: Estimate
    v: Estimate


def colour_of(xyz: NDArray[np.float64]) -> Colour:
    """Return the colour of X, Y, Z of independent blocks, (b, 3) float64 [cd/m²].

    A chromaticity N/D has the error of the mean of (N - (N/D) D)/D over the blocks (the ratio
    estimator's; Cochran, "Sampling techniques", 1977).
    """
    freedom = len(xyz) - 1
    mean = xyz.mean(axis=0)
    found = [Estimate.student(float(mean[1]), _error(xyz[:, 1]), freedom)]
    for name, numerator in _NUMERATOR.items():
        top, bottom = xyz @ numerator, xyz @ _DENOMINATOR[name]
        value = float(top.mean() / bottom.mean())
        rest = (top - value * bottom) / bottom.mean()
        found.append(Estimate.student(value, _error(rest), freedom))
    return Colour(*found)


def scatter_of(xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how each block's u', v' departs from that of all, (b, …, 3) to (b, …, 2) float64.

    As the ratio estimator has it: the mean over the blocks is 0, and its error that of u', v'.
    """
    mean = xyz.mean(axis=0)
    uv = uniform_chromaticity(mean)
    top = xyz[..., :2] * (4.0, 9.0)
    bottom = (xyz @ (1.0, 15.0, 3.0))[..., None]
    return (top - uv * bottom) / (mean @ (1.0, 15.0, 3.0))[..., None]


def points_of(xyz: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return u', v' of each point and their standard errors, (p, 2) each, of (b, p, 3)."""
    error = scatter_of(xyz).std(axis=0, ddof=1) / np.sqrt(len(xyz))
    return uniform_chromaticity(xyz.mean(axis=0)), error


def difference(xyz: NDArray[np.float64], other: NDArray[np.float64]) -> Estimate:
    """Return Δu'v' of two lights, (b, 3) each, of the same blocks; its interval ends at 0."""
    apart = uniform_chromaticity(xyz.mean(axis=0)) - uniform_chromaticity(other.mean(axis=0))
    scatter = scatter_of(xyz) - scatter_of(other)
    covariance = np.cov(scatter, rowvar=False) / len(xyz)
    return vector_length(apart, covariance, len(xyz) - 1)


def xy_of(xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return x, y of the mean of blocks, (b, …, 3) to (…, 2)."""
    return chromaticity(xyz.mean(axis=0))


def _error(values: NDArray[np.float64]) -> float:
    return float(values.std(ddof=1) / np.sqrt(len(values)))
