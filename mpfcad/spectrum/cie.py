"""The CIE 1931 standard colorimetric observer (2°) and the chromaticities that it gives.

`cie1931.csv` holds its colour-matching functions, 360 … 830 nm in steps of 1 nm (ISO/CIE
11664-1:2019, "Colorimetry, Part 1: CIE standard colorimetric observers", table 1), as
colour-science (BSD-3-Clause) distributes them; a test compares them with that package.
"""

from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: The wavelengths [nm] of every spectrum here.
FIRST_NM, LAST_NM = 360, 830
#: Lumens a watt of light of 555 nm (SI).
LUMENS_PER_WATT = 683.0


@cache
def _table() -> NDArray[np.float64]:
    text = (files("mpfcad.spectrum") / "cie1931.csv").read_text("utf-8")
    return np.array([[float(v) for v in line.split(",")] for line in text.splitlines()[1:]])


def wavelengths() -> NDArray[np.float64]:
    """Return the wavelengths [nm] of the table, (471,) float64."""
    return _table()[:, 0]


def matching_functions() -> NDArray[np.float64]:
    """Return the colour-matching functions x, y, z at `wavelengths`, (471, 3) float64."""
    return _table()[:, 1:]


def chromaticity(xyz: ArrayLike) -> NDArray[np.float64]:
    """Return x, y = X/S, Y/S with S = X + Y + Z (ISO/CIE 11664-3); (…, 3) float64 gives (…, 2).

    Examples
    --------
    >>> [round(float(v), 4) for v in chromaticity([0.95047, 1.0, 1.08883])]
    [0.3127, 0.329]
    """
    xyz = np.asarray(xyz, np.float64)
    return xyz[..., :2] / xyz.sum(axis=-1, keepdims=True)


def uniform_chromaticity(xyz: ArrayLike) -> NDArray[np.float64]:
    """Return u', v' = 4X/D, 9Y/D with D = X + 15Y + 3Z (ISO/CIE 11664-5); (…, 3) gives (…, 2).

    Examples
    --------
    >>> [round(float(v), 4) for v in uniform_chromaticity([0.95047, 1.0, 1.08883])]
    [0.1978, 0.4683]
    """
    xyz = np.asarray(xyz, np.float64)
    denominator = xyz @ (1.0, 15.0, 3.0)
    return xyz[..., :2] * (4.0, 9.0) / denominator[..., None]
