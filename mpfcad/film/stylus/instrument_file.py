"""Binary files of instruments, read by SurfaceTopography (MIT; the extra `instruments`)."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.areal import ArealMap, cut_profile
from mpfcad.film.stylus.profile import RawProfile
from mpfcad.film.stylus.unit import UNITS, find_unit

#: Endings of the files that are no text, and what writes them.
ENDINGS = {
    ".opdx": "Dektak/Vision64 OPDx",
    ".opd": "Wyko OPD",
    ".gwy": "Gwyddion",
    ".sur": "Digital Surf",
    ".pro": "Digital Surf",
    ".x3p": "ISO 5436-2 x3p",
    ".sdf": "ISO 25178-71 sdf",
    ".bcrf": "BCR-STM",
    ".plu": "Sensofar",
    ".plux": "Sensofar",
    ".vk4": "Keyence",
    ".vk6": "Keyence",
    ".al3d": "Alicona",
    ".mnt": "Digital Surf Mountains",
}
_PLACES = (b"DCD", b"GWYP", b"PK\x03\x04", b"aBCR", b"bBCR", b"DIGITAL SURF", b"DSCOMPRESSED")


def is_instrument_file(path: Path, start: bytes) -> bool:
    """Return whether a file is one of an instrument's, by its ending or its first bytes."""
    return path.suffix.lower() in ENDINGS or start.startswith(_PLACES)


def read_instrument_file(path: Path) -> RawProfile:
    """Return the profile in an instrument's file; of a map, the one across its grooves.

    Raises
    ------
    InputError
        when the reader is not installed, does not know the file, or it holds several channels of
        heights that differ.
    """
    try:
        from SurfaceTopography.IO import open_topography
    except ImportError:
        raise InputError(
            f"{path}: a file of {ENDINGS.get(path.suffix.lower(), 'an instrument')}: expected the "
            "extra that reads it: pip install 'mpfcad[instruments]'; or export it as text"
        ) from None
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with open_topography(str(path)) as reader:
                channels = [c for c in reader.channels if c.unit is None or find_unit(str(c.unit))]
                if not channels:
                    raise InputError(f"{path}: no channel of heights: expected one in µm, nm …")
                names = [str(channel.name) for channel in channels]
                index = reader.channels.index(channels[0])
                surface = reader.topography(channel_index=index)
        except InputError:
            raise
        except Exception as error:  # the reader raises whatever its format's code raises
            raise InputError(
                f"{path}: not read as {ENDINGS.get(path.suffix.lower(), 'an instrument file')}: "
                f"{' '.join(str(error).split())[:160] or type(error).__name__}: expected such a "
                "file, or an export as text"
            ) from None
    words = [f"by SurfaceTopography ({reader.format()})"]
    if len(names) > 1:
        words.append(f"channel {names[0]!r} of {len(names)}")
    unit = find_unit(str(surface.unit)) if surface.unit is not None else None
    height: NDArray[np.float64] = np.ma.filled(np.ma.asarray(surface.heights(), float), np.nan)
    if surface.dim == 1:
        position = np.asarray(surface.positions(), float)
        return RawProfile(position, height, unit, unit, None, words)
    size = surface.physical_sizes
    if size is None or unit not in UNITS:
        raise InputError(f"{path}: no size of a pixel in it: expected one, or an export as text")
    # The first index of its arrays runs along x.
    step = [float(s) / n for s, n in zip(size, height.shape, strict=True)]
    position, mean, cut = cut_profile(path, ArealMap(height.T, step[0], step[1], unit, unit))
    return RawProfile(position, mean, unit, unit, None, [*words, cut])
