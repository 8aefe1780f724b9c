"""The waves of an image: their power, and which way they run."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.observed.image import LuminanceImage

#: Blocks along an image's longer side whose spectrum is taken.
_SPECTRUM = 256
#: Fewer waves over an image are a trend; a window blurs by as many.
BLUR = 2.0


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Power of the waves of an image about its trend, (rows, columns/2 + 1) float64.

    Attributes
    ----------
    across, along
        waves over the image along x and along y, of the same shape
    pixels
        of the image over `across` and `along`: a wave's length in pixels is 1 / hypot(across /
        pixels[0], along / pixels[1])
    """

    power: NDArray[np.float64]
    across: NDArray[np.float64]
    along: NDArray[np.float64]
    pixels: tuple[int, int]

    @property
    def angle(self) -> NDArray[np.float64]:
        """Which way the waves run, from x counter-clockwise as the image is stored, ±π/2 [rad]."""
        rise = np.arctan2(-self.along / self.pixels[1], self.across / self.pixels[0])
        turned: NDArray[np.float64] = (rise + np.pi / 2) % np.pi - np.pi / 2
        return turned

    @property
    def noise(self) -> float:
        """Power that noise has all over: the median of an exponential distribution is ln 2."""
        return float(np.median(self.power) / np.log(2))

    def length(self, place: int) -> float:
        """Return the length of the wave at a place of the flat arrays [pixels]."""
        u, v = self.across.flat[place] / self.pixels[0], self.along.flat[place] / self.pixels[1]
        return float(1 / np.hypot(u, v))


def spectrum_of(image: LuminanceImage, finer: int = 1) -> Spectrum:
    """Return the waves of an image before it is turned, slow trends taken off.

    finer: places between whole numbers of waves, by zeros beside the image.
    """
    light = image.straight
    part = max(1, round(max(light.shape) / _SPECTRUM))
    rows, columns = (size // part for size in light.shape)
    light = light[: rows * part, : columns * part]
    light = light.reshape(rows, part, columns, part).mean(axis=(1, 3))
    y, x = (grid.ravel() for grid in np.mgrid[-1 : 1 : rows * 1j, -1 : 1 : columns * 1j])
    trend = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    flat = light.ravel() - trend @ np.linalg.lstsq(trend, light.ravel(), rcond=None)[0]
    window = np.hanning(rows)[:, None] * np.hanning(columns)[None]
    shape = rows * finer, columns * finer
    power = np.abs(np.fft.rfft2(flat.reshape(rows, columns) * window, shape)) ** 2
    along, across = np.meshgrid(
        np.fft.fftfreq(shape[0]) * rows, np.fft.rfftfreq(shape[1]) * columns, indexing="ij"
    )
    power[np.hypot(across, along) < BLUR] = 0
    return Spectrum(power, across, along, (columns * part, rows * part))
