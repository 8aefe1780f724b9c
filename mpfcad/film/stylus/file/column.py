"""Which columns of a table are position and height; what its header says of step and tip."""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.file.areal import ArealMap, cut_profile
from mpfcad.film.stylus.file.profile import RawProfile
from mpfcad.film.stylus.file.text import NumberTable
from mpfcad.film.stylus.file.unit import NUMBER, UNITS, find_strange_unit, find_unit, parse_number
from mpfcad.film.stylus.tip import USUAL_ANGLE, StylusTip
from mpfcad.units import deg

_NO_LENGTH = re.compile(
    r"(#|no\b|nr\b|num|idx|index|i\b|points?\b|samples?\b|row|line|valid|flag|mask|time|"
    r"zeit|t\b|force|kraft|intensity|counter)",
    re.IGNORECASE,
)
_POSITION = re.compile(
    r"(x\b|x[_ (\[]|lateral|pos|dist|scan|length|weg|strecke|abstand|l[äa]nge|displ|horiz)",
    re.IGNORECASE,
)
_ACROSS = re.compile(r"y\b|y[_ (\[]", re.IGNORECASE)
_STEP = re.compile(
    r"(?:resolution|spacing|step|interval|increment|\bd[xX]\b|pitch of samples|auflösung|schritt)"
    rf"[^\d\n]{{0,20}}?({NUMBER})\s*([^\s/,;]*)",
    re.IGNORECASE,
)
_LENGTH = re.compile(
    rf"(?:scan\s*length|^length|messstrecke|traverse)[^\d\n]{{0,20}}?({NUMBER})\s*([^\s/,;]*)",
    re.IGNORECASE,
)
_TIP = re.compile(
    rf"(?:stylus|tip|probe|tast)[^\n]{{0,30}}?(?:\br\b|radius)[^\d\n]{{0,12}}({NUMBER})\s*"
    rf"([^\s,;]*)|(?:stylus|tip|tast)\w*[^\d\n]{{0,20}}?({NUMBER})\s*(µm|μm|um|nm|mm)\b",
    re.IGNORECASE,
)
_ANGLE = re.compile(
    rf"(?:stylus|tip|cone|kegel|tast|angle|winkel)[^\n]{{0,40}}?({NUMBER})\s*(?:°|deg)",
    re.IGNORECASE,
)
#: Two height columns that differ by a line are one profile, levelled in one of them.
_SAME = 1e-3


def find_profile(path: Path, table: NumberTable, columns: tuple[int, int] | None) -> RawProfile:
    """Return the profile in a table; `columns` (from 1) overrule what its header says.

    Raises
    ------
    InputError
        when more than one reading is left, naming them.
    """
    tip = find_tip(table.header)
    values, count = table.values, table.values.shape[1]
    words = [f"{count} column{'s' * (count > 1)}", *table.words]
    if columns is not None:
        if max(columns) > count or min(columns) < 1:
            raise InputError(f"--columns: {columns[0]},{columns[1]}: expected of 1 … {count}")
        return _profile(table, columns[0] - 1, columns[1] - 1, words, tip)
    area = _matrix(table) or _raster(table)
    if area is not None:
        position, height, cut = cut_profile(path, area)
        words.append(cut)
        return RawProfile(position, height, area.unit, area.height_unit, None, words, tip)
    step = _find(_STEP, table.header)
    named = [i for i in range(count) if _POSITION.match(table.names[i])]
    useful = [i for i in range(count) if not _NO_LENGTH.match(table.names[i])]
    useful = [i for i in useful if np.isfinite(values[:, i]).mean() > 0.5]
    index = [i for i in useful if _is_index(values[:, i])]
    if step is not None and not named and (count == 1 or _is_index(values[:, 0])):
        heights = [i for i in useful if i not in index] or [count - 1]
        at = _one_height(path, table, heights)
        x: NDArray[np.float64] = np.arange(len(values), dtype=np.float64) * step[0]
        words.append(f"step {step[0]:g} from its header")
        name = table.names[at].replace("_", " ")
        return RawProfile(
            x, values[:, at], step[1], find_unit(name), table.lines, words, tip,
            _strange(table, at),
        )  # fmt: skip
    if count == 1:
        raise InputError(f"{path}: one column: expected two, or the step of x in the header")
    rising = [i for i in useful if _is_monotone(values[:, i])]
    if len(rising) > 1 and not named:
        rising = [i for i in rising if i not in index] or rising
    at = (named or rising or useful[:1] or [0])[0]
    z = _one_height(path, table, [i for i in useful if i != at and i not in set(index) - {at}]
                    or [i for i in range(count) if i != at])  # fmt: skip
    return _profile(table, at, z, words, tip)


def _profile(
    table: NumberTable, x: int, z: int, words: list[str], tip: StylusTip | None
) -> RawProfile:
    if (x, z) != (0, 1) or table.values.shape[1] > 2:
        name = f" ({table.names[z]})" if table.names[z] else ""
        words = [*words, f"x column {x + 1}, z column {z + 1}{name}"]
    names = [table.names[i].replace("_", " ") for i in (x, z)]
    units = [find_unit(name) for name in names]
    strange = _strange(table, x, z)
    if units == [None, None] and table.header:
        # One unit, said once above the columns.
        lines = [line for line in table.header if re.search(r"unit|einheit", line, re.I)]
        units = [find_unit(lines[-1])] * 2 if lines else units
        unknown = find_strange_unit(lines[-1]) if lines else None
        strange = strange or (f"{lines[-1]!r} states the unit {unknown!r}" if unknown else "")
        pair = [find_unit(part) for part in table.header[0].split()]
        if len(table.header) <= 2 and len(pair) == 2 and all(pair):
            units = pair
    return RawProfile(
        table.values[:, x], table.values[:, z], units[0], units[1], table.lines, words, tip, strange
    )


def _strange(table: NumberTable, *columns: int) -> str:
    """Return which columns name a unit that is none of length, in words; "" where none does."""
    found = [
        f"column {i + 1} ({table.names[i]}) states the unit {word!r}"
        for i in columns
        if (word := find_strange_unit(table.names[i].replace("_", " ")))
    ]
    return " and ".join(found)


def _one_height(path: Path, table: NumberTable, candidates: list[int]) -> int:
    """Return the one column of heights; those that differ by a line are the same."""
    first = table.values[:, candidates[0]]
    row = np.arange(len(first))
    for other in candidates[1:]:
        both = np.isfinite(first) & np.isfinite(table.values[:, other])
        if np.count_nonzero(both) < 3:
            continue
        gap = (table.values[:, other] - first)[both]
        left = gap - np.polyval(np.polyfit(row[both], gap, 1), row[both])
        if np.std(left) > _SAME * np.std(first[both]):
            names = [f"{i + 1} ({table.names[i] or 'unnamed'})" for i in candidates]
            more = f" … {len(names)} columns" if len(names) > 4 else ""
            raise InputError(
                f"{path}: heights in column {', or in '.join(names[:4])}{more}: expected one: "
                "say which with --columns X,Z"
            )
    return candidates[0]


def _matrix(table: NumberTable) -> ArealMap | None:
    """Return the map that a header with width and height, or with a step, makes of a matrix."""
    values = table.values
    if values.shape[1] < 3:
        return None
    size = [
        _find(re.compile(rf"(?:{word})\s*[:=]?\s*({NUMBER})\s*(\S*)", re.IGNORECASE), table.header)
        for word in ("width|breite", "height|h[öo]he")
    ]
    if size[0] and size[1] and size[0][1] and size[1][1]:
        to_mm = [part[0] * UNITS[part[1] or "mm"] for part in size if part]
        unit = [find_unit(line) for line in table.header if re.search(r"value unit", line, re.I)]
        step = to_mm[0] / values.shape[1], to_mm[1] / values.shape[0]
        return ArealMap(values, *step, "mm", unit[-1] if unit else None)
    steps = [
        _find(re.compile(rf"{axis}-resolution\s*[:=]?\s*({NUMBER})\s*(\S*)", re.I), table.header)
        for axis in "xy"
    ]
    if steps[0] and steps[1] and values.shape[1] > 20:
        rows = values[:, 1:] if _is_index(values[:, 0]) else values
        return ArealMap(rows, steps[0][0], steps[1][0], steps[0][1], None)
    return None


def _raster(table: NumberTable) -> ArealMap | None:
    """Return the map in rows x, y, z of a regular raster."""
    if table.values.shape[1] != 3 or (table.names[1] and not _ACROSS.match(table.names[1])):
        return None
    x, y, z = table.values.T
    (across, column), (along, row) = (np.unique(v, return_inverse=True) for v in (x, y))
    cells = len(across) * len(along)
    if min(len(across), len(along)) < 2 or not 0.5 * cells <= len(z) <= cells:
        return None
    height = np.full((len(along), len(across)), np.nan)
    height[row, column] = z
    step = [float((v[-1] - v[0]) / (len(v) - 1)) for v in (across, along)]
    unit = find_unit(table.names[0]), find_unit(table.names[2])
    return ArealMap(height, step[0], step[1], *unit)


def find_tip(header: list[str]) -> StylusTip | None:
    """Return the tip that a header states, or None.

    >>> find_tip(["Stylus,Radius: 2.5 µm"]).radius
    0.0025
    """
    for line in header:
        found = _TIP.search(line)
        if found is None:
            continue
        number, unit = (found[1], found[2]) if found[1] else (found[3], found[4])
        factor = UNITS[find_unit(unit or "") or find_unit(line) or "µm"]
        radius = parse_number(number) * factor
        angles = [match for match in map(_ANGLE.search, header) if match]
        angle = parse_number(angles[0][1]) * deg if angles else USUAL_ANGLE
        if 0 < radius < 0.1 and 0 < angle < 3:
            return StylusTip(radius, angle)
    return None


def _find(pattern: re.Pattern[str], header: list[str]) -> tuple[float, str | None] | None:
    """Return the number, and the unit behind it, of the first line that a pattern finds."""
    for line in header:
        found = pattern.search(line)
        if found and parse_number(found[1]) > 0:
            return parse_number(found[1]), find_unit(found[2])
    return None


def _is_index(column: NDArray[np.float64]) -> bool:
    """Return whether a column counts its rows from 0 or 1."""
    return bool(
        len(column) > 2
        and column[0] in (0, 1)
        and np.all(np.diff(column[np.isfinite(column)]) == 1)
    )


def _is_monotone(column: NDArray[np.float64]) -> bool:
    step = np.diff(column[np.isfinite(column)])
    return (
        len(step) > 0 and bool(np.all(step >= 0) or np.all(step <= 0)) and bool(np.any(step != 0))
    )
