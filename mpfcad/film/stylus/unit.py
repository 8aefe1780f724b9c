"""Units of length as instruments write them, and where a text states one."""

import re

#: Name as printed -> [mm].
UNITS = {"m": 1e3, "mm": 1.0, "µm": 1e-3, "nm": 1e-6, "Å": 1e-7}
_SPELLING = {
    "µm": r"[µμ]m|um|microns?|micromet(?:er|re)s?|mikrometer",
    "nm": r"nm|nanomet(?:er|re)s?|nanometer",
    "mm": r"mm|millimet(?:er|re)s?|millimeter",
    "Å": r"Å|Å|angstr(?:o|ö)ms?",
    "m": r"m|met(?:er|re)s?",
}
#: A unit stands alone: neither a letter before it nor one behind it.
_PATTERN = re.compile(
    r"(?<![^\W_])(?:"
    + "|".join(f"(?P<u{i}>{spelling})" for i, spelling in enumerate(_SPELLING.values()))
    + r")(?![^\W_])",
    re.IGNORECASE,
)
_ANGSTROM = re.compile(r"[\[(]\s*A\s*[\])]|\sA\Z")
NUMBER = r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][-+]?\d+)?"


def find_unit(text: str) -> str | None:
    """Return the last unit of length that a text states, as a key of `UNITS`; None without one.

    >>> find_unit("Lateral um"), find_unit("Total Profile(Å)"), find_unit("Points")
    ('µm', 'Å', None)
    """
    found = [match.lastgroup for match in _PATTERN.finditer(text)]
    if found and found[-1] is not None:
        return list(_SPELLING)[int(found[-1][1:])]
    return "Å" if _ANGSTROM.search(text) else None


def parse_unit(text: str) -> str:
    """Return the key of `UNITS` that a user's word means.

    Raises
    ------
    ValueError
        when it is none.
    """
    word = text.strip()
    unit = "Å" if word in ("A", "a", "AA") else find_unit(word)
    if unit is None:
        raise ValueError(f"{word!r}: expected one of um, mm, nm, A, m")
    return unit


def parse_number(text: str) -> float:
    """Return a number with either decimal mark."""
    return float(text.replace(",", "."))
