"""A camera's image as luminance: dark frame, flat field, crop and rotation taken into account."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.file.text import read_table
from mpfcad.measure.observed.clip import clipped

IMAGES = frozenset({".tif", ".tiff", ".fits", ".fit", ".fts", ".exr"})
_FEWEST = 16


@dataclass(frozen=True)
class Photo:
    """How an image becomes luminance.

    Attributes
    ----------
    pixel
        side of a pixel in the image's plane [mm]
    scale
        luminance of a count [cd/m²]
    dark, flat
        images taken off, and divided by (over its own mean)
    crop
        (left, top, right, bottom) in pixels, right and bottom excluded
    rotation
        [rad], -π … π, counter-clockwise, from the image's x to across the lamps
    """

    pixel: float
    scale: float = 1.0
    dark: Path | None = None
    flat: Path | None = None
    crop: tuple[int, int, int, int] | None = None
    rotation: float = 0.0


@dataclass(frozen=True, eq=False)
class LuminanceImage:
    """Luminance of pixels of a side [mm].

    Attributes
    ----------
    straight
        (rows, columns) float64 [cd/m²], as it was taken, or turned by right angles
    rotation
        [rad], -π/4 … π/4, counter-clockwise, from its x to across the lamps
    quarters
        right angles by which it was turned before, without resampling
    """

    straight: NDArray[np.float64]
    pixel: float
    reading: str
    rotation: float = 0.0
    quarters: int = 0

    @cached_property
    def luminance(self) -> NDArray[np.float64]:
        """The image turned so that columns run along the lamps, its corners cut off."""
        return _turned(self.straight, self.rotation) if self.rotation else self.straight


def is_image(path: Path) -> bool:
    """Return whether a file is an image, or a matrix of more than three columns."""
    if path.suffix.lower() in IMAGES:
        return True
    return path.is_file() and read_table(path).values.shape[1] > 3


def read_image(path: Path, photo: Photo) -> LuminanceImage:
    """Return the luminance in an image: TIFF, FITS, OpenEXR or a matrix in text.

    Raises
    ------
    InputError
        when a file cannot be read, frames differ in size, or counts are saturated.
    """
    counts, top = _read_counts(path)
    words = [f"{counts.shape[1]} × {counts.shape[0]} pixels of {photo.pixel:g} mm"]
    raw = counts
    dark = 0.0 if photo.dark is None else _read_counts(photo.dark)[0]
    for name, file in (("dark", photo.dark), ("flat", photo.flat)):
        if file is None:
            continue
        frame, most = _read_counts(file)
        if frame.shape != counts.shape:
            raise InputError(
                f"{file}: --{name}: {frame.shape[1]} × {frame.shape[0]} pixels: expected "
                f"{counts.shape[1]} × {counts.shape[0]}, as {path.name}"
            )
        if name == "dark":
            counts = counts - frame
        else:
            if np.ptp(frame) > 0 or frame.max() == most:
                _refuse_clipped(f"{file}: --flat", frame, most)
            frame = frame - dark
            if np.any(frame <= 0):
                raise InputError(f"{file}: --flat: {frame.min():g} counts: expected above 0")
            counts = counts * (frame.mean() / frame)
        words.append(f"{name} {file.name}")
    if photo.crop is not None:
        left, top_row, right, bottom = photo.crop
        rows, columns = counts.shape
        if not (0 <= left < right <= columns and 0 <= top_row < bottom <= rows):
            raise InputError(f"--crop: {photo.crop}: expected within {columns} × {rows} pixels")
        counts = counts[top_row:bottom, left:right]
        raw = raw[top_row:bottom, left:right]
    _refuse_clipped(str(path), raw, top)
    if photo.rotation:
        words.append(f"turned by {np.degrees(photo.rotation):g}°")
    if min(counts.shape) < _FEWEST or not np.all(np.isfinite(counts)) or counts.mean() <= 0:
        raise InputError(
            f"{path}: {counts.shape[1]} × {counts.shape[0]} pixels, mean {counts.mean():g}: "
            f"expected {_FEWEST} × {_FEWEST} or more finite counts of positive mean"
        )
    words.append(f"{photo.scale:g} cd/m² a count")
    reading = f"read {path.name}: {', '.join(words)}"
    quarters = round(photo.rotation / (np.pi / 2))
    rest = photo.rotation - quarters * np.pi / 2
    straight = np.rot90(counts * photo.scale, -quarters)
    return LuminanceImage(straight, photo.pixel, reading, rest, quarters)


def _refuse_clipped(name: str, counts: NDArray[np.float64], top: float | None) -> None:
    """Refuse pixels at the full scale of their type, or piled up at the highest count."""
    full = 0 if top is None else int(np.count_nonzero(counts >= top))
    number = full or clipped(counts)
    if number:
        where = "at full scale" if full else f"clipped at the highest count, {counts.max():g}"
        raise InputError(
            f"{name}: {number:,} pixels {where}: expected none saturated: expose less, or --crop"
        )


def _is_stack(file: Any) -> bool:
    """Tell whether a TIFF has a second page of the first one's size; a thumbnail has another."""
    try:
        return bool(file.pages[1].shape == file.pages.first.shape)
    except IndexError:
        return False


def _read_counts(path: Path) -> tuple[NDArray[np.float64], float | None]:
    """Return an image's counts, and the count of a saturated pixel where its type has one."""
    if not path.is_file():
        raise InputError(f"{path}: no such file: expected an image")
    kind = path.suffix.lower()
    try:
        if kind in (".tif", ".tiff"):
            import tifffile

            with tifffile.TiffFile(path) as file:
                # Asked for one by one: a chain of pages may have no end.
                if _is_stack(file):
                    raise InputError(f"{path}: pages of one size: expected one image")
                array: Any = file.pages.first.asarray()
        elif kind in (".fits", ".fit", ".fts"):
            from astropy.io import fits

            array = fits.getdata(path)
        elif kind == ".exr":
            import OpenEXR

            channels = OpenEXR.File(str(path), separate_channels=True).channels()
            array = channels["Y"].pixels if "Y" in channels else np.stack(
                [channels[name].pixels for name in "RGB"], axis=-1
            )  # fmt: skip
        else:
            array = read_table(path).values
    except ImportError as error:
        raise InputError(
            f"{path}: {error.name} is not installed: expected the extra that reads it: "
            "pip install 'mpfcad[instruments]'"
        ) from None
    except InputError:
        raise
    except Exception as error:  # whatever a damaged image makes its reader raise
        raise InputError(f"{path}: not read: {' '.join(str(error).split())[:120]}") from None
    found = np.asarray(array)
    if found.ndim == 3 and found.shape[-1] in (3, 4) and kind == ".exr":
        # Rec. 709 luminance of linear red, green and blue.
        found = found[..., :3] @ np.array([0.2126, 0.7152, 0.0722])
    if found.ndim != 2:
        shape = " × ".join(map(str, found.shape))
        raise InputError(f"{path}: array of {shape}: expected one grey image")
    top = float(np.iinfo(found.dtype).max) if found.dtype.kind in "ui" else None
    return found.astype(np.float64), top


def _turned(counts: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Return an image turned so that across the lamps is along its rows, its corners cut off."""
    from scipy.ndimage import rotate

    turned = rotate(counts, -np.degrees(angle), reshape=False, order=3, cval=np.nan)
    rows, columns = counts.shape
    sine, cosine = abs(np.sin(angle)), abs(np.cos(angle))
    # The largest upright rectangle of the same shape inside the turned one.
    share = 1 / (cosine + sine * max(rows, columns) / min(rows, columns))
    height, width = int(rows * share) - 2, int(columns * share) - 2
    top, left = (rows - height) // 2, (columns - width) // 2
    found: NDArray[np.float64] = turned[top : top + height, left : left + width]
    return found
