"""Stripes in an image: their mean luminance across, whichever way they run.

An image that was taken askew is not resampled: between pixels the noise of neighbours would be
mixed, and its scatter along the lamps would tell too small an error. Each pixel counts where its
middle lies across the lamps, in bins as wide as a pixel.
"""

import math

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.observed.curve import ObservedCurve
from mpfcad.measure.observed.image import LuminanceImage

#: Bins across that a curve needs.
_FEWEST = 16


def curve_of_image(image: LuminanceImage) -> ObservedCurve:
    """Return the mean luminance over position across the lamps, its error from the scatter along.

    A slow gradient along the lamps is no noise: the scatter is that of second differences of
    neighbours along them. Positions count from the image's upper left corner.

    Raises
    ------
    InputError
        when the image is turned so far that hardly a bin reaches across it.
    """
    rows, columns = image.straight.shape
    seen = columns * math.cos(image.rotation) - rows * abs(math.sin(image.rotation))
    if seen < _FEWEST:
        raise InputError(
            f"{image.reading}: {columns} × {rows} pixels: {max(seen, 0):.0f} bins across that "
            f"reach from the first to the last row: expected {_FEWEST} or more: --crop fewer rows"
        )
    position, mean, error = means_across(image.straight, image.pixel, image.rotation)
    return ObservedCurve(position, mean, error, image.reading)


def means_across(
    light: NDArray[np.float64], pixel: float, angle: float, aspect: float = 1.0
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return position across [mm], mean and its standard error, of pixels of `aspect` times a side.

    Only where the image reaches from its first to its last row across the whole bin.
    """
    rows, columns = light.shape
    second = np.diff(light, 2, axis=0) ** 2 / 6
    if angle == 0:
        error = np.sqrt(second.mean(axis=0) / rows)
        position = (np.arange(columns, dtype=np.float64) + 0.5) * pixel
        return position, light.mean(axis=0), error
    sine, cosine = math.sin(angle), math.cos(angle)
    y = (np.arange(rows) + 0.5) * aspect
    across = (np.arange(columns) + 0.5)[None] * cosine - y[:, None] * sine
    height = rows * aspect
    first = math.ceil(max(0.0, -height * sine))
    last = math.floor(columns * cosine - max(0.0, height * sine))
    number = np.floor(across).astype(np.int64) - first
    inside = (number >= 0) & (number < last - first)
    bins = max(last - first, 1)
    count = np.maximum(np.bincount(number[inside], minlength=bins), 1)
    mean, place = (np.bincount(number[inside], v[inside], bins) / count for v in (light, across))
    kept = inside[1:-1]
    seen = np.maximum(np.bincount(number[1:-1][kept], minlength=bins), 1)
    square = np.bincount(number[1:-1][kept], second[kept], bins) / seen
    return place * pixel, mean, np.sqrt(square / count)
