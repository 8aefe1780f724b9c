"""EULUMDAT files (`.ldt`): one number or word a line; of symmetric luminaires some planes only.

Layout: Stockmar, "EULUMDAT - ein Leuchtendatenformat für den europäischen Beleuchtungsplaner",
1990. photompy takes planes that are not stored for stored ones, and is not used for these.
"""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

#: Lines above the lamps, a set of lamps, and the direct ratios below them.
_HEAD, _LAMPS, _RATIOS = 26, 6, 10
#: Which line holds what, from 0.
_SYMMETRY, _PLANES, _ANGLES, _SETS = 2, 3, 5, 25
#: C planes [deg] that are stored, by symmetry: none, about the axis, to C0-C180, to C90-C270, both.
_STORED = {0: (0.0, 360.0), 2: (0.0, 180.0), 3: (90.0, 270.0), 4: (0.0, 90.0)}


def read_eulumdat(where: str, text: str) -> tuple[NDArray, NDArray, NDArray]:
    """Return (polar, azimuth [deg], (azimuth, polar) intensity) of a file's text.

    Raises
    ------
    InputError
        naming the line, what it holds, and what was expected.
    """
    lines = text.splitlines()
    symmetry, planes, angles, sets = (
        _whole(where, lines, at) for at in (_SYMMETRY, _PLANES, _ANGLES, _SETS)
    )
    for at, given, least, most in (
        (_SYMMETRY, symmetry, 0, 4), (_PLANES, planes, 1, 721), (_ANGLES, angles, 2, 1801),
        (_SETS, abs(sets), 1, 20),
    ):  # fmt: skip
        if not least <= given <= most:
            raise InputError(f"{where}: line {at + 1}: {given}: expected {least} … {most}")
    start = _HEAD + _LAMPS * abs(sets) + _RATIOS
    azimuth = _numbers(where, lines, start, planes)
    polar = _numbers(where, lines, start + planes, angles)
    stored = _stored(symmetry, azimuth)
    if len(stored) == 0:
        raise InputError(
            f"{where}: line {start + 1}: planes {azimuth[0]:g} … {azimuth[-1]:g}°: expected those "
            f"of symmetry {symmetry}"
        )
    count = len(stored) * angles
    value = _numbers(where, lines, start + planes + angles, count).reshape(-1, angles)
    return polar, *_expanded(symmetry, stored, value)


def _stored(symmetry: int, azimuth: NDArray) -> NDArray:
    """Return the planes [deg] that a file holds, in its order."""
    if symmetry == 1:
        return azimuth[:1]
    low, high = _STORED[symmetry]
    if symmetry != 3:
        return azimuth[(azimuth >= low) & (azimuth <= high)]
    # From C270 over C0 to C90.
    below, above = azimuth[azimuth <= low], azimuth[azimuth >= high]
    return np.concatenate([above, below])


def _expanded(symmetry: int, stored: NDArray, value: NDArray) -> tuple[NDArray, NDArray]:
    """Return planes all round [deg], rising, and their values, (planes, angles)."""
    mirrored = {
        0: (stored,), 1: (stored,), 2: (stored, -stored), 3: (stored, 180 - stored),
        4: (stored, -stored, 180 - stored, 180 + stored),
    }[symmetry]  # fmt: skip
    every = np.concatenate(mirrored) % 360
    found, first = np.unique(np.round(every, 6), return_index=True)
    return found, np.concatenate([value] * len(mirrored))[first]


def _whole(where: str, lines: list[str], at: int) -> int:
    found = _number(where, lines, at)
    if found != round(found):
        raise InputError(f"{where}: line {at + 1}: {found:g}: expected a whole number")
    return int(found)


def _numbers(where: str, lines: list[str], start: int, count: int) -> NDArray[np.float64]:
    return np.array([_number(where, lines, start + k) for k in range(count)])


def _number(where: str, lines: list[str], at: int) -> float:
    """Return the number of a line; the mark may be a comma."""
    if at >= len(lines):
        raise InputError(f"{where}: {len(lines)} lines: expected a number in line {at + 1}")
    text = lines[at].strip()
    try:
        number = float(text.replace(",", "."))
    except ValueError:
        number = np.nan
    if not np.isfinite(number):
        raise InputError(f"{where}: line {at + 1}: {text[:30]!r}: expected a number")
    return number
