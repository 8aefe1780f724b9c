"""Units of length as instruments write them, and where a text states one."""

import re

#: Name as printed -> [mm].
UNITS = {
    "m": 1e3, "mm": 1.0, "µm": 1e-3, "nm": 1e-6, "Å": 1e-7,
    "cm": 10.0, "in": 25.4, "mil": 0.0254, "µin": 2.54e-5,
}  # fmt: skip
#: Those that are looked for where a file states none.
USUAL = ("m", "mm", "µm", "nm", "Å")
#: What a user may write.
WORDS = "um, mm, nm, A, m, cm, in, mil or uin"
_SPELLING = {
    "µm": r"[µμ]m|um|microns?|micromet(?:er|re)s?|mikrometer",
    "nm": r"nm|nanomet(?:er|re)s?|nanometer",
    "mm": r"mm|millimet(?:er|re)s?|millimeter",
    "Å": r"Å|Å|angstr(?:o|ö)ms?",
    "m": r"m|met(?:er|re)s?",
    "cm": r"cm|centimet(?:er|re)s?|zentimeter",
    "in": r"inch(?:es)?",
    "mil": r"mils?|thou",
    "µin": r"(?:[µμu]|micro-?)in(?:ch(?:es)?)?",
}
#: A unit stands alone: neither a letter before it nor one behind it.
_PATTERN = re.compile(
    r"(?<![^\W_])(?:"
    + "|".join(f"(?P<u{i}>{spelling})" for i, spelling in enumerate(_SPELLING.values()))
    + r")(?![^\W_])",
    re.IGNORECASE,
)
_ANGSTROM = re.compile(r"[\[(]\s*A\s*[\])]|\sA\Z")
#: `in` is a word, too: a unit in brackets, behind a stroke, or at the end.
_INCH = re.compile(r"[\[(]\s*in\.?\s*[\])]|/\s*in\b|(?:\A|\s)in\.?\Z", re.IGNORECASE)
_UNIT_PLACE = re.compile(
    r"[\[(]\s*(?P<a>[^\W\d_]{1,12}|%|°)\s*[\])]\s*\Z|\bin\s+(?P<b>[^\W\d_]+)\Z"
    r"|/\s*(?P<c>[^\W\d_]+)\Z"
    r"|\A(?:[xyz]|pos(?:ition)?|dist(?:ance)?|lateral|height|depth|profile|units?[\s:=,;])\W*"
    r"[\s_](?P<d>[^\W\d_]+)\Z",
    re.IGNORECASE,
)
_NO_UNIT = re.compile(
    r"raw|pos\w*|profile|height|depth|le?vell?ed|filt\w*|smooth\w*|data|axis|values?|scan|mean|avg|"
    r"average|corr\w*|re?trace|trace|forward|backward|left|right|coord\w*|total|form|rough\w*|wav\w*|"
    r"primary|signal|dir\w*|length|dist\w*|points?|surface|topo\w*|lateral|axis|col\w*|default|[xyz]",
    re.IGNORECASE,
)
NUMBER = r"[-+]?(?:\d++[.,]?\d*+|[.,]\d++)(?:[eE][-+]?\d++)?"


def find_unit(text: str) -> str | None:
    """Return the last unit of length that a text states, as a key of `UNITS`; None without one.

    >>> find_unit("Lateral um"), find_unit("Total Profile(Å)"), find_unit("Points")
    ('µm', 'Å', None)
    """
    found = [match.lastgroup for match in _PATTERN.finditer(text)]
    if found and found[-1] is not None:
        return list(_SPELLING)[int(found[-1][1:])]
    if _INCH.search(text):
        return "in"
    return "Å" if _ANGSTROM.search(text) else None


def find_strange_unit(text: str) -> str | None:
    """Return the word that stands where a column's name states its unit, and is none of length.

    >>> find_strange_unit("x furlong"), find_strange_unit("z (V)"), find_strange_unit("Raw um")
    ('furlong', 'V', None)
    """
    found = _UNIT_PLACE.search(text.strip())
    if found is None or find_unit(text) is not None:
        return None
    word = next(group for group in found.groups() if group)
    return None if _NO_UNIT.fullmatch(word) else word


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
        raise ValueError(f"{word!r}: expected one of {WORDS}")
    return unit


def parse_number(text: str) -> float:
    """Return a number with either decimal mark."""
    return float(text.replace(",", "."))
