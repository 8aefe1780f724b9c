"""Stripes in an image: their mean luminance across, and whether they run askew.

An image that was taken askew is not resampled: between pixels the noise of neighbours would be
mixed, and its scatter along the lamps would tell too small an error. Each pixel counts where its
middle lies across the lamps, in bins as wide as a pixel.
"""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.observed.curve import ObservedCurve
from mpfcad.measure.observed.image import LuminanceImage

#: Angles [rad] to each side that are tried, their step, and how often the step is halved.
_MOST, _STEP, _FINER = math.radians(12.0), math.radians(0.25), 5
#: Pixels that are looked at for the angle.
_SAMPLE = 200_000
#: A mean over rows that are askew loses contrast: said from a thousandth, refused from 2 %.
_SAID, _REFUSED = 1e-3, 0.02
#: Standard deviations of noise that a gain of variance must exceed.
_CERTAIN = 5.0


def curve_of_image(image: LuminanceImage) -> ObservedCurve:
    """Return the mean luminance over position across the lamps, its error from the scatter along.

    A slow gradient along the lamps is no noise: the scatter is that of second differences of
    neighbours along them. Positions count from the image's upper left corner.
    """
    position, mean, error = _means(image.straight, image.pixel, image.rotation)
    return ObservedCurve(position, mean, error, image.reading)


def askew_words(path: Path, image: LuminanceImage, curve: ObservedCurve) -> str:
    """Return what is to be said of stripes that run askew; "" where they run down the columns.

    Raises
    ------
    InputError
        when so much contrast is lost that the mean over the rows does not show it.
    """
    off = askew(image, curve)
    if off is None:
        return ""
    angle, loss = off
    turned = math.degrees(image.rotation)
    words = (
        f"the stripes run {math.degrees(angle):+.2f}° askew"
        f"{f' after --rotation-deg {turned:g}' if turned else ''}, which hides {loss:.1%} of the "
        f"contrast: expected --rotation-deg {math.degrees(image.rotation + angle):.2f}"
    )
    if loss > _REFUSED:
        raise InputError(f"{path}: {words}")
    return words


def askew(image: LuminanceImage, curve: ObservedCurve) -> tuple[float, float] | None:
    """Return by what angle [rad] the stripes are askew still, and the share of contrast it hides.

    The angle is that at which the means across vary most, beyond what noise may do; None without.
    """
    part = max(1, round(math.sqrt(image.straight.size / _SAMPLE)))
    rows = min(len(image.straight), image.straight.shape[1]) // part * part
    first = (len(image.straight) - rows) // 2
    # Means of a few rows keep what a step of rows would throw away of the noise.
    seen = image.straight[first : first + rows].reshape(-1, part, image.straight.shape[1])
    seen = seen.mean(axis=1)
    noise = float(np.mean(curve.error**2))
    steepest, width = _MOST + abs(image.rotation), image.straight.shape[1]
    half = (width * math.cos(steepest) - rows * math.sin(steepest)) / 2 * image.pixel
    if half <= 0:
        return None

    def variance(angle: float) -> float:
        turn = image.rotation + angle
        position, mean, _ = _means(seen, image.pixel, turn, float(part))
        centre = (width * math.cos(turn) - rows * math.sin(turn)) / 2 * image.pixel
        # The same stretch about the middle at every angle.
        near = np.abs(position - centre) <= half
        position, mean = position[near], mean[near]
        return float(np.var(mean - np.polyval(np.polyfit(position, mean, 2), position))) - noise

    here, step = variance(0.0), _STEP
    tried = np.arange(-_MOST, _MOST + step / 2, step)
    best = float(max(tried, key=variance))
    for _ in range(_FINER):
        step /= 2
        best = float(max((best - step, best, best + step), key=variance))
    most = variance(best)
    by_chance = noise * math.sqrt(2 / len(curve.position)) + 2 * math.sqrt(
        noise * max(most, 0.0) / len(curve.position)
    )
    if most - here < _CERTAIN * by_chance:
        return None
    loss = 1 - math.sqrt(max(here, 0.0) / most)
    return (best, loss) if loss > _SAID else None


def _means(
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
