"""LightTools `.bsdf` files: values by angles around the normal, blocks in any order.

A block is `AOI` (angle of incidence, deg), `POI`, `Side Front|Back`, `ScatterType BRDF|BTDF`, `TIS`
and the values, azimuth by azimuth. The light comes from azimuth 90°, so what goes straight on or is
mirrored leaves at 270° (libbsdf, LightToolsBsdfReader, which reads isotropic files alone). `Front`
is light from above.
"""

from pathlib import Path

import numpy as np

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.format.csv import Grid, grid_table
from mpfcad.optics.bsdf.format.source import read_text
from mpfcad.optics.bsdf.missing import Matrices
from mpfcad.optics.bsdf.table import ABOVE, BELOW, REFLECT, TRANSMIT

_SIDES = {"front": ABOVE, "back": BELOW}
_WAYS = {"brdf": REFLECT, "btdf": TRANSMIT}
_STRAIGHT = 270.0


def is_lighttools(path: Path) -> bool:
    """Tell whether a `.bsdf` file is LightTools' and not Zemax's."""
    words = read_text(path)[0].lower().split()
    return "aoi" in words and "samplerotation" not in words


def read_lighttools(path: Path) -> tuple[AngleBasis, bool, Matrices, tuple[str, ...]]:
    """Return (basis, isotropic, matrices (i, o) [1/sr] by (way, side), notes).

    Raises
    ------
    InputError
        naming the block or key that is not as the format says.
    """
    text, notes = read_text(path)
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("#")]
    words = " ".join(lines).split()
    begin = [word.lower() for word in words].index("databegin") if _has(words) else 0
    if not begin:
        raise InputError(f"{path}: DataBegin: missing: expected after the header")
    head = words[:begin]
    azimuth, radial = (_angles(path, head, key) for key in ("ScatterAzimuth", "ScatterRadial"))
    spectral = _after(path, head, "SpectralContent").lower()
    if spectral not in ("monochrome", "xyz"):
        raise InputError(f"{path}: SpectralContent: {spectral}: expected Monochrome or XYZ")
    keys, angles, values = [], [], []
    turned = np.round((azimuth - _STRAIGHT) % 360, 9)
    keep = np.unique(turned, return_index=True)[1]
    for block, value in _blocks(path, words[begin + 1 :], len(azimuth) * len(radial)):
        if spectral == "xyz" and block.get("tristimulusvalue", "").lower() != "trisy":
            continue
        if float(block.get("poi", 0)) != 0:
            raise InputError(
                f"{path}: block AOI {block.get('aoi', '?')}, POI {block['poi']}: an anisotropic "
                "file: from which axis POI turns, and whether ScatterAzimuth turns with it, is not "
                "published: expected POI 0, or the sheet as Zemax .bsdf, Klems XML or CSV"
            )
        try:
            key = (_WAYS[block["scattertype"].lower()], _SIDES[block["side"].lower()])
            incidence = float(block["aoi"])
        except (KeyError, ValueError):
            raise InputError(
                f"{path}: block AOI {block.get('aoi', 'missing')}: expected AOI, Side Front or "
                "Back, and ScatterType BRDF or BTDF"
            ) from None
        value = value.reshape(len(azimuth), len(radial))[keep]
        a, r = np.meshgrid(turned[keep], radial, indexing="ij")
        angles.append(
            np.stack([np.full(a.size, incidence), 0 * a.ravel(), r.ravel(), a.ravel()], 1)
        )
        keys.append(np.tile(key, (a.size, 1)))
        values.append(value.ravel())
    if not keys:
        raise InputError(f"{path}: no block of luminous data: expected one or more")
    grid = Grid(np.concatenate(keys), np.concatenate(angles), np.concatenate(values))
    basis, isotropic, found, more = grid_table(path, grid)
    return basis, isotropic, found, (*notes, *more, "Front read as light from above")


def _has(words: list[str]) -> bool:
    return any(word.lower() == "databegin" for word in words)


def _after(path: Path, words: list[str], key: str) -> str:
    lower = [word.lower() for word in words]
    at = lower.index(key.lower()) if key.lower() in lower else len(words)
    if at + 1 >= len(words):
        raise InputError(f"{path}: {key}: missing: expected in the header")
    return words[at + 1]


def _angles(path: Path, words: list[str], key: str) -> np.ndarray:
    """Return the angles [deg] listed under a key."""
    try:
        count = int(_after(path, words, key))
        at = [word.lower() for word in words].index(key.lower()) + 2
        values = np.array(words[at : at + count], float)
        if len(values) != count or count < 1 or not (np.diff(values) > 0).all():
            raise ValueError
    except ValueError:
        raise InputError(f"{path}: {key}: expected a count, then as many rising angles") from None
    return values


def _blocks(path: Path, words: list[str], count: int):
    """Yield (keys, values) of each block."""
    block: dict[str, str] = {}
    at = 0
    while at < len(words) and words[at].lower() != "dataend":
        key = words[at].lower()
        block[key] = words[at + 1] if at + 1 < len(words) else ""
        at += 2
        if key != "tis":
            continue
        try:
            value = np.array(words[at : at + count], float)
        except ValueError:
            value = np.empty(0)
        if len(value) != count or not np.isfinite(value).all() or (value < 0).any():
            raise InputError(
                f"{path}: block AOI {block.get('aoi', '?')}: expected {count} numbers from 0 up "
                "after TIS"
            )
        yield block, value
        at += count
        block = {}
    if at >= len(words):
        raise InputError(f"{path}: DataEnd: missing: expected after the last block")
