"""A measured image of spots: the contrast over a cell, by the same series as a trace of LEDs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.measure.cell.series import CellSeries, fit_series
from mpfcad.measure.estimate import Estimate
from mpfcad.measure.observed.image import LuminanceImage
from mpfcad.measure.observed.lamp import find_phase

#: Terms along each axis: the mean and six harmonics.
_TERMS = 13
#: Share of the variance in cells that their mean must have; an amplitude too faint to tell.
_ALIKE, _FAINT = 0.5, 1e-3
#: Bins of the map that is shown, a side.
BINS = 32


@dataclass(frozen=True, eq=False)
class ObservedCell:
    """What a measured image says about one cell of the lamps.

    Attributes
    ----------
    size
        (across, along) [mm]
    series
        of the mean cell; its errors from cell to cell
    contrast
        over the mean cell
    luminance
        (32, 32) float64 [cd/m²], mean cell, the brightest place in the middle, along first
    cells
        whole cells that were averaged
    """

    size: tuple[float, float]
    series: CellSeries
    contrast: Estimate
    luminance: NDArray[np.float64]
    cells: int


def observe_cell(image: LuminanceImage, size: tuple[float, float], seed: int = 1) -> ObservedCell:
    """Return the figures of the whole cells of a size (across, along) [mm] in an image.

    Each cell gets its own Fourier coefficients; their mean is the series, and their scatter its
    covariance, so that cells that differ are in the interval.

    Raises
    ------
    InputError
        when the image holds fewer than four whole cells, pixels too coarse for them, or what varies
        within its cells is not the same in each.
    """
    start = [
        find_phase(*curve, period) - period / 2
        for curve, period in zip(means_of_sides(image), size, strict=True)
    ]
    start = [first % period for first, period in zip(start, size, strict=True)]
    rows, columns = image.luminance.shape
    length = columns * image.pixel, rows * image.pixel
    count = [int((whole - first) / p) for whole, first, p in zip(length, start, size, strict=True)]
    if count[0] * count[1] < 4 or min(size) < 2 * _TERMS * image.pixel:
        raise InputError(
            f"{image.reading}: {count[0]} × {count[1]} whole cells of {size[0]:.4g} × "
            f"{size[1]:.4g} mm: expected 4 or more, of {2 * _TERMS} pixels a side or more"
        )
    coefficients, shown = [], np.zeros((BINS, BINS))
    for i in range(count[0]):
        for j in range(count[1]):
            part, u, v = _cut(image, start, size, (i, j))
            coefficients.append(_coefficients(part, u, v))
            shown += _binned(part, u, v) / (count[0] * count[1])
    found = np.array(coefficients)
    alike = _alike(found)
    if alike < _ALIKE:
        raise InputError(
            f"{image.reading}: the mean of {len(found)} cells of {size[0]:.4g} × {size[1]:.4g} mm "
            f"has {alike:.0%} of the variation in them: expected half or more: --cell-mm, "
            "--rotation-deg"
        )
    covariance = _covariance(found)
    series = fit_series(found.mean(axis=0), covariance, len(found), _TERMS, False)
    return ObservedCell(size, series, series.contrast(seed), shown, len(found))


def _alike(found: NDArray[np.float64]) -> float:
    """Return the mean cell's share of the variance in cells, of two harmonics (cells, 13 · 13).

    What noise adds is told by the harmonics beyond; where there is little else it is 1.
    """
    waves = found.reshape(len(found), _TERMS, _TERMS)
    noise = float(np.median(waves[:, 7:, 7:] ** 2)) / 0.455
    low = waves[:, :5, :5].reshape(len(found), -1)[:, 1:]
    within = float(np.mean(np.sum(low**2, axis=1))) - low.shape[1] * noise
    mean = float(np.sum(low.mean(axis=0) ** 2)) - low.shape[1] * noise / len(found)
    certain = low.shape[1] * noise + (_FAINT * found[:, 0].mean()) ** 2
    return 1.0 if within < certain else mean / within


def means_of_sides(
    image: LuminanceImage,
) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]:
    """Return position [mm] and mean luminance of an upright image's columns, and of its rows."""
    light = image.luminance
    columns, rows = (
        ((np.arange(count, dtype=np.float64) + 0.5) * image.pixel, light.mean(axis=axis))
        for axis, count in ((0, light.shape[1]), (1, light.shape[0]))
    )
    return columns, rows


def _cut(
    image: LuminanceImage, start: list[float], size: tuple[float, float], number: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the pixels of a cell, and where they lie in periods from its middle, -½ … ½."""
    places, slices = [], []
    for axis, count in ((0, image.luminance.shape[1]), (1, image.luminance.shape[0])):
        centre = (np.arange(count, dtype=np.float64) + 0.5) * image.pixel
        place = (centre - start[axis]) / size[axis] - number[axis]
        inside = np.flatnonzero((place >= 0) & (place < 1))
        places.append(place[inside] - 0.5)
        slices.append(slice(int(inside[0]), int(inside[-1]) + 1))
    return image.luminance[slices[1], slices[0]], places[0], places[1]


def _coefficients(
    part: NDArray[np.float64], u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the terms i·13 + j of a cell (along, across), least squares along each axis."""
    across, along = (np.linalg.pinv(_terms(place)) for place in (u, v))
    found: NDArray[np.float64] = (across @ part.T @ along.T).ravel()
    return found


def _terms(place: NDArray[np.float64]) -> NDArray[np.float64]:
    columns = [np.ones_like(place)]
    for k in range(1, (_TERMS + 1) // 2):
        columns += [np.cos(2 * np.pi * k * place), np.sin(2 * np.pi * k * place)]
    return np.stack(columns, axis=1)


def _covariance(found: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance of the mean; off the diagonal nothing, as cells are too few for it."""
    variance = found.var(axis=0, ddof=1) / len(found)
    floor = (1e-6 * found[:, 0].mean()) ** 2
    return np.diag(np.maximum(variance, floor))


def _binned(
    part: NDArray[np.float64], u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return a cell's luminance at the middles of the bins, nearest pixel, (along, across)."""
    middle = (np.arange(BINS) + 0.5) / BINS - 0.5
    at = [np.argmin(np.abs(place[None] - middle[:, None]), axis=1) for place in (v, u)]
    return part[np.ix_(at[0], at[1])]
