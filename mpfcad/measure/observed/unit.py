"""The unit of luminance that a column's name states."""

import re

#: Candela per square metre, as it is printed; a letter before it makes it another unit.
_CANDELA = re.compile(
    r"(?<![^\W_])(?:cd[\s_./*·]*(?:m|(?:sq|square)[\s_.]*m)[\s_^*]*(?:-?2|²|⁻²|\^-?2)?|nits?)(?![^\W_])",
    re.IGNORECASE,
)
#: What is none: other units of light, shares, logarithms, counts.
_OTHER = re.compile(
    r"(?<![^\W_])(?:f-?l|ft-?l\w*|foot\w*|\w*lamberts?|apostilbs?|asb|sb|stilbs?|lx|lux|lm|lumens?"
    r"|[mkµμu]?cd|[mkµμu]nits?|[mµμu]?w|watts?|sr|db|log\w*|lg|ln|lin|percent|rel\w*|norm\w*|counts?"
    r"|adu|dn|a\.?u|arb\w*|v|mv)(?![^\W_])|%",
    re.IGNORECASE,
)
_BRACKET = re.compile(r"[\[(]\s*([^\])]*?)\s*[\])]")


def strange_luminance(name: str) -> str | None:
    """Return the words of a column's name that state another unit than cd/m²; None without.

    >>> strange_luminance("luminance_fL"), strange_luminance("log_luminance")
    ('fL', 'log')
    >>> strange_luminance("Leuchtdichte [cd/m²]"), strange_luminance("luminance")
    (None, None)
    """
    left = _CANDELA.sub(" ", name)
    found = _OTHER.search(left)
    if found:
        return found[0]
    inside = _BRACKET.search(left)
    return inside[1] if inside and inside[1] else None
