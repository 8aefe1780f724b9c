"""The camera image as files: what the eye sees, its contour, and the luminance itself."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Files of a picture, in the order they are written.
PICTURES = ("camera.png", "camera-contour.png", "camera.tif")
#: Pixels of the PNG files for one of the picture.
_ZOOM = 3
#: Widths of a contour band, as shares of the mean: the least that is two standard errors is taken.
_BANDS = (0.005, 0.01, 0.02, 0.05, 0.1)
_MOST_COUNTS = 60_000
#: Bands below, at and above the mean.
LOW, MEAN, HIGH = (np.array(c, float) for c in ((8, 48, 107), (244, 244, 240), (140, 45, 4)))
_BANDS_TO_FULL = 5


def camera_picture(camera: dict[str, Any], lamps_level: bool) -> NDArray[np.float64]:
    """Return the picture [cd/m²], (n, n) float64, as it lies on the screen.

    `lamps_level`: the lamps lie level on the screen, so x runs down the picture.
    """
    lines = np.asarray(camera["luminance_cd_m2"])
    if "cells" in camera:
        picture = np.tile(lines, camera["cells"])
    else:
        picture = np.repeat(lines, len(lines) // lines.shape[1], axis=1)
    return picture if lamps_level else picture.T


def band_width(camera: dict[str, Any]) -> float:
    """Return the width of a contour band, as a share of the mean."""
    error = np.mean(camera["standard_error_cd_m2"]) / np.mean(camera["luminance_cd_m2"])
    return next((band for band in _BANDS if band >= 2 * error), _BANDS[-1])


def write_pictures(folder: Path, camera: dict[str, Any], lamps_level: bool) -> None:
    """Write `PICTURES` into a folder; the same figures give the same bytes."""
    from PIL import Image

    picture = camera_picture(camera, lamps_level)
    big = np.kron(picture, np.ones((_ZOOM, _ZOOM)))
    grey = np.clip(np.round(big / (1.1 * picture.mean()) * 255), 0, 255).astype(np.uint8)
    Image.fromarray(grey).save(folder / PICTURES[0], compress_level=9)
    bands = contour(np.asarray(big, np.float64), band_width(camera))
    Image.fromarray(bands).save(folder / PICTURES[1], compress_level=9)
    across = camera["pixel_mm"]
    along = camera.get("pixel_along_mm", across)
    pixel = (across, along) if lamps_level else (along, across)
    _write_tiff(folder / PICTURES[2], picture, pixel)


def contour(picture: NDArray[np.float64], width: float) -> NDArray[np.uint8]:
    """Return a picture's bands in colour with their borders, (n, m, 3) uint8.

    `width`: of a band, as a share of the mean.
    """
    band = np.round((picture / picture.mean() - 1) / width)
    share = np.clip(np.abs(band) / _BANDS_TO_FULL, 0, 1)[..., None]
    colour = MEAN + share * (np.where(band[..., None] < 0, LOW, HIGH) - MEAN)
    border = np.zeros(band.shape, bool)
    border[1:] |= band[1:] != band[:-1]
    border[:, 1:] |= band[:, 1:] != band[:, :-1]
    colour[border] *= 0.55
    return np.round(colour).astype(np.uint8)


def _write_tiff(path: Path, picture: NDArray[np.float64], pixel: tuple[float, float]) -> None:
    """Write 16-bit counts; the description says how many cd/m² one count is.

    `pixel` [mm] is down and to the right.
    """
    from tifffile import imwrite

    exact = picture.max() / _MOST_COUNTS
    digits = 2 - math.floor(math.log10(exact))
    step = math.ceil(exact * 10**digits) / 10**digits
    says = {"luminance_cd_m2_per_count": step, "axes": "down, right"}
    says["pixel_mm"] = pixel[0] if pixel[0] == pixel[1] else list(pixel)
    imwrite(
        path,
        np.round(picture / step).astype("<u2"),
        photometric="minisblack",
        description=json.dumps(says),
        resolution=(10 / pixel[1], 10 / pixel[0]),
        resolutionunit="CENTIMETER",
        software="mpfcad",
        metadata=None,
    )
