"""Binary files of instruments: x3p, and what SurfaceTopography (MIT; `instruments`) reads."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.file.areal import ArealMap, cut_profile
from mpfcad.film.stylus.file.profile import RawProfile
from mpfcad.film.stylus.file.text import is_binary
from mpfcad.film.stylus.file.unit import UNITS, find_unit
from mpfcad.film.stylus.file.x3p import read_x3p

#: Endings of the files that are no text, and what writes them.
ENDINGS = {
    ".opdx": "Dektak/Vision64 OPDx",
    ".opd": "Wyko OPD",
    ".gwy": "Gwyddion",
    ".sur": "Digital Surf",
    ".pro": "Digital Surf",
    ".sdf": "ISO 25178-71 sdf",
    ".bcrf": "BCR-STM",
    ".plu": "Sensofar",
    ".plux": "Sensofar",
    ".vk4": "Keyence",
    ".vk3": "Keyence",
    ".vk6": "Keyence",
    ".vk7": "Keyence",
    ".zon": "Keyence ZON",
    ".datx": "Zygo DATX",
    ".zmg": "KLA Zeta",
    ".tmd": "TrueMap",
    ".nms": "NanoFocus",
    ".frt": "FRT MicroProf",
    ".os3d": "OmniSurf3D",
    ".qep": "Mahr MarWin",
    ".lext": "Olympus LEXT",
    ".al3d": "Alicona",
    ".mnt": "Digital Surf Mountains",
}
_PLACES = (b"DCD", b"GWYP", b"PK\x03\x04", b"aBCR", b"bBCR", b"DIGITAL SURF", b"DSCOMPRESSED")
#: First bytes by which an ending that other programs use too is an instrument's.
_MARKS = {".sdf": (b"aISO", b"bISO", b"aBCR", b"bBCR")}


def is_instrument_file(path: Path, start: bytes) -> bool:
    """Return whether a file is one of an instrument's: by ending, first bytes, or as no text.

    Raises
    ------
    InputError
        when a file of an instrument's ending begins as none of them does.
    """
    ending = path.suffix.lower()
    if ending in _MARKS and not start.startswith(_MARKS[ending]):
        begins = " or ".join(repr(mark.decode()) for mark in _MARKS[ending])
        raise InputError(f"{path}: begins {start[:8]!r}: expected {ENDINGS[ending]}: {begins}")
    return ending in (*ENDINGS, ".x3p") or start.startswith(_PLACES) or is_binary(start)


def read_instrument_file(path: Path) -> RawProfile:
    """Return the profile in an instrument's file; of a map, the one across its grooves.

    Raises
    ------
    InputError
        when the reader is not installed, does not know the file, or it holds several channels of
        heights that differ.
    """
    if path.suffix.lower() == ".x3p":
        return read_x3p(path)
    try:
        from SurfaceTopography.Exceptions import CannotDetectFileFormat
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
        except CannotDetectFileFormat:
            known = ENDINGS.get(path.suffix.lower())
            raise InputError(
                f"{path}: not a text file, and no {known or 'instrument'} file that is known: "
                "expected columns of numbers, or an instrument's file"
            ) from None
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
