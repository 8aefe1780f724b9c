"""Areal maps of a surface: the profile across their grooves."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

#: Angles tried about the one that the slopes give, and their spacing [rad].
_TURNS, _TURN = 81, 5e-4
#: Share of the squared slopes across the grooves that shows grooves; without them it is 0.5.
_ONE_WAY = 0.7
_LARGEST = 4_000_000


@dataclass(frozen=True, eq=False)
class ArealMap:
    """Heights on a regular raster.

    Attributes
    ----------
    height
        (rows, columns) float64, NaN where not measured, in `height_unit`
    step_x, step_y
        spacing of columns and rows, in `unit`
    """

    height: NDArray[np.float64]
    step_x: float
    step_y: float
    unit: str | None
    height_unit: str | None


def cut_profile(path: Path, area: ArealMap) -> tuple[NDArray[np.float64], NDArray[np.float64], str]:
    """Return position and mean height across a map's grooves, and how it was cut.

    The direction across is that of the largest mean squared slope, refined until the mean over the
    grooves' length varies most; then all heights of one position across are averaged, which leaves
    what a tip or a noise of each line does to the mean.

    Raises
    ------
    InputError
        when the slopes have no preferred direction.
    """
    z = area.height
    stride = int(np.ceil(np.sqrt(z.size / _LARGEST)))
    z = z[::stride, ::stride]
    if min(z.shape) < 3:
        flat = int(np.argmax(z.shape))
        line: NDArray[np.float64] = np.nanmean(z, axis=1 - flat)
        step = (area.step_y if flat == 0 else area.step_x) * stride
        return np.arange(len(line), dtype=np.float64) * step, line, "map of one line"
    steps: NDArray[np.float64] = np.array([area.step_x, area.step_y]) * stride
    filled = np.where(np.isfinite(z), z, np.nanmean(z))
    with np.errstate(all="ignore"):
        slope_y, slope_x = np.gradient(filled, steps[1], steps[0])
        xx, yy, xy = (float(np.mean(p)) for p in (slope_x**2, slope_y**2, slope_x * slope_y))
    if not np.isfinite([xx, yy, xy]).all():
        raise InputError(
            f"{path}: heights up to {np.abs(filled).max():.3g} at steps of {area.step_x:.3g} and "
            f"{area.step_y:.3g}: expected those of a surface"
        )
    spread = np.hypot(xx - yy, 2 * xy)
    if xx + yy == 0 or (1 + spread / (xx + yy)) / 2 < _ONE_WAY:
        raise InputError(
            f"{path}: map of {z.shape[1]} × {z.shape[0]} heights: no grooves: its slopes point "
            "everywhere: expected grooves of one direction"
        )
    angle = 0.5 * np.arctan2(2 * xy, xx - yy)
    level = _levelled(filled, steps)
    tried = angle + (np.arange(_TURNS) - _TURNS // 2) * _TURN
    quarter = np.round(angle / (np.pi / 2)) * np.pi / 2
    tried = np.append(tried[np.abs(tried - quarter) > _TURN / 2], quarter)
    sample = max(1, int(np.sqrt(z.size / 250_000)))
    angle = max(tried, key=lambda a: _variance(level, steps, float(a), sample))
    position, height = _binned(z, steps, float(angle), 1)
    degrees = np.degrees(angle)
    return position, height, (
        f"map of {area.height.shape[1]} × {area.height.shape[0]}, cut across its grooves at "
        f"{degrees:.2f}° from x"
    )  # fmt: skip


def _levelled(height: NDArray[np.float64], step: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return heights without their mean plane."""
    rows, columns = height.shape
    y, x = np.mgrid[:rows, :columns]
    plane = np.stack([np.ones(height.size), x.ravel(), y.ravel()], axis=1)
    part = slice(None, None, max(1, height.size // 100_000))
    found = np.linalg.lstsq(plane[part], height.ravel()[part], rcond=None)[0]
    return height - (plane @ found).reshape(height.shape)


def _binned(
    height: NDArray[np.float64], step: NDArray[np.float64], angle: float, stride: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the mean height in bins of the position across, as wide as a step there."""
    rows, columns = height.shape
    y, x = np.mgrid[:rows:stride, :columns:stride]
    across = x * step[0] * np.cos(angle) + y * step[1] * np.sin(angle)
    width = float(np.hypot(step[0] * np.cos(angle), step[1] * np.sin(angle))) * stride
    z = height[::stride, ::stride].ravel()
    kept = np.isfinite(z)
    across, z = across.ravel()[kept], z[kept]
    bins = np.floor((across - across.min()) / width * (1 + 1e-12) + 1e-9).astype(int)
    count = np.bincount(bins)
    mean = np.bincount(bins, z) / np.maximum(count, 1)
    place = np.bincount(bins, across) / np.maximum(count, 1)
    # The corners of a turned map hold a few heights each.
    full = count >= max(1, 0.2 * np.median(count))
    return place[full] - place[full][0], mean[full]


def _variance(
    height: NDArray[np.float64], step: NDArray[np.float64], angle: float, stride: int
) -> float:
    return float(np.var(_binned(height, step, angle, stride)[1]))
