"""What is read off a trace, and the figures that a meter would state of it.

A view is one kind of trace of one case: over the pitch, over directions, or of the flux.
Its readings follow the backlight's values smoothly where a contrast, a maximum less a minimum, does
not.
"""

from collections.abc import Callable
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.angle.angular import peak, width
from mpfcad.measure.contrast.fit import basis

#: Kinds of view.
PITCH, DIRECTIONS, FLUX = "pitch", "directions", "flux"
#: Polar angles [rad] that are traced, along one side: tubes and films are their own mirror image.
HALF = np.radians(np.arange(0, 81, 5))
_WHOLE = np.concatenate([-HALF[:0:-1], HALF])
_FINE = 128
_DRAWS = 64

Readings = NDArray[np.float64]
#: Readings of a view (m,) and their covariance (m, m) -> figure (d,).
Figure = Callable[[Readings, NDArray[np.float64]], NDArray[np.float64]]


def pitch_gain(points: int, harmonics: int) -> NDArray[np.float64]:
    """Return what turns luminances (n,) over a pitch into mean and cosines, (1+h, n).

    Row of lamps and film are their own mirror image: sines are noise, or a misplaced film.
    """
    columns = cosine_columns(np.linspace(0, 1, points), harmonics)
    return np.asarray(np.linalg.pinv(columns), np.float64)


def cosine_columns(position: NDArray[np.float64], harmonics: int) -> NDArray[np.float64]:
    """Return 1, cos 2πu, cos 4πu … at u, (n, 1+h) float64."""
    even = [0, *range(1, 2 * harmonics + 1, 2)]
    found: NDArray[np.float64] = basis(position, harmonics)[:, even]
    return found


def read_pitch(
    luminance: NDArray[np.float64], error: NDArray[np.float64], harmonics: int
) -> tuple[Readings, NDArray[np.float64]]:
    """Return ln mean and the cosines over the mean of luminances (n,), and their covariance."""
    gain = pitch_gain(len(luminance), harmonics)
    found = gain @ luminance
    mean = float(found[0])
    relative = gain / mean
    relative[1:] -= np.outer(found[1:] / mean**2, gain[0])
    return np.r_[np.log(mean), found[1:] / mean], (relative * error**2) @ relative.T


def read_logarithm(
    value: NDArray[np.float64], error: NDArray[np.float64]
) -> tuple[Readings, NDArray[np.float64]]:
    """Return the logarithms of values (n,) with independent errors, and their covariance."""
    return np.log(value), np.diag((error / value) ** 2)


def luminance(reading: Readings, spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean normal luminance over the pitch [cd/m²]."""
    return np.exp(reading[:1])


def harmonics_of(count: int) -> Figure:
    """Return the figure of the first `count` cosines over the mean."""

    def cosines(reading: Readings, spread: NDArray[np.float64]) -> NDArray[np.float64]:
        found = np.zeros(count)
        part = reading[1 : 1 + count]
        found[: len(part)] = part
        return found

    return cosines


def contrast(reading: Readings, spread: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (Lmax - Lmin)/(Lmax + Lmin) of the cosines (Hsieh, MPF thesis, eq. 10).

    Noise of the readings raises it; by how much is found by adding it again, and taken off.
    """
    curve = 1 + _fine(len(reading) - 1) @ reading[1:]
    noisy = curve + _noise(np.ascontiguousarray(spread[1:, 1:]).tobytes(), len(reading) - 1)
    once = _contrast(curve)
    raised = float(np.mean(_contrast(noisy))) - once
    return np.atleast_1d(np.maximum(once - raised, 0.0))


def _contrast(curve: NDArray[np.float64]) -> NDArray[np.float64]:
    high, low = curve.max(axis=-1), curve.min(axis=-1)
    found: NDArray[np.float64] = (high - low) / (high + low)
    return found


@cache
def _fine(harmonics: int) -> NDArray[np.float64]:
    return cosine_columns(np.arange(_FINE // 2 + 1) / _FINE, harmonics)[:, 1:]


@lru_cache(maxsize=64)
def _noise(spread: bytes, harmonics: int) -> NDArray[np.float64]:
    """Return curves of what noise the cosines' covariance makes, each with its opposite."""
    value, vector = np.linalg.eigh(np.frombuffer(spread).reshape(harmonics, harmonics))
    root = vector * np.sqrt(np.maximum(value, 0))
    rng = np.random.Generator(np.random.Philox(0))
    found: NDArray[np.float64] = (
        rng.standard_normal((_DRAWS, harmonics)) @ root.T @ _fine(harmonics).T
    )
    return np.concatenate([found, -found])


def fwhm_of(side: int) -> Figure:
    """Return the full width at half of the peak [deg], `side` 0 across and 1 along the lamps.

    A curve that does not fall so far has the width of all that is traced.
    """

    def fwhm(reading: Readings, spread: NDArray[np.float64]) -> NDArray[np.float64]:
        curve = np.exp(_cut(reading, side))
        found = width(_WHOLE, curve, peak(_WHOLE, curve) / 2)
        whole = float(_WHOLE[-1] - _WHOLE[0])
        return np.degrees([whole if found is None else found])

    return fwhm


def cut_of(side: int, angle: NDArray[np.float64]) -> Figure:
    """Return the luminance at angles (d,) [rad] over its mean there."""
    from scipy.interpolate import PchipInterpolator

    def cut(reading: Readings, spread: NDArray[np.float64]) -> NDArray[np.float64]:
        found = np.exp(PchipInterpolator(_WHOLE, _cut(reading, side))(angle))
        return np.asarray(found / found.mean(), np.float64)

    return cut


def entry_of(number: int) -> Figure:
    """Return the figure whose logarithm is one of the readings."""
    return lambda reading, spread: np.exp(reading[number : number + 1])


def _cut(reading: Readings, side: int) -> NDArray[np.float64]:
    """Return the logarithm of a cut at `_WHOLE`: the normal, one side across, one along."""
    n = len(HALF) - 1
    part = reading[1 + side * n : 1 + (side + 1) * n]
    return np.concatenate([part[::-1], reading[:1], part])
