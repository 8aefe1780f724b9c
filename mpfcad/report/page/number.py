"""Numbers and formulas of the pages as HTML."""

import re
from typing import Any

from markupsafe import Markup, escape

#: How a formula marks what stands low or high: `L_{max}`, `10^{-3}`.
_RAISED = re.compile(r"([_^])\{([^{}]*)\}")


def number(value: Any, digits: int = 4) -> Markup:
    """Return a number with so many significant digits, anything else as escaped text.

    >>> number(0.000012345, 3)
    Markup('1.23 · 10<sup>−5</sup>')
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return escape(str(value))
    if isinstance(value, int):
        return Markup(f"{value:,}".replace(",", " "))
    shown = f"{value:.{digits}g}"
    if "e" not in shown:
        return Markup(shown)
    mantissa, exponent = shown.split("e")
    return Markup(f"{mantissa} · 10<sup>{int(exponent)}</sup>".replace("-", "−"))


def value_words(value: Any, digits: int = 6) -> str:
    """Return an input's value as text: tables and lists without marks, yes and no.

    >>> value_words({"name": "150-31", "release": None, "angle_deg": 22.5})
    'name 150-31, angle_deg 22.5'
    """
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, dict):
        return ", ".join(f"{k} {value_words(v)}" for k, v in value.items() if v is not None)
    if isinstance(value, list):
        return ", ".join(value_words(one) for one in value)
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    return str(value) or "none"


def with_interval(estimate: dict[str, Any], decimals: int) -> str:
    """Return `value [low, high]` with so many decimals."""
    low, high = estimate["ci95"]
    return f"{estimate['value']:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"


def with_error(estimate: dict[str, Any], digits: int) -> Markup:
    """Return `value ± standard error`, the value with so many significant digits."""
    value, error = number(estimate["value"], digits), number(estimate["standard_error"], 2)
    return Markup("{} ± {}").format(value, error)


def formula(text: str) -> Markup:
    """Return text in which `_{…}` is lowered and `^{…}` raised, all else escaped.

    >>> formula("L_{max} < 3")
    Markup('L<sub>max</sub> &lt; 3')
    """

    def shifted(found: re.Match[str]) -> str:
        tag = "sub" if found[1] == "_" else "sup"
        return f"<{tag}>{found[2]}</{tag}>"

    return Markup(_RAISED.sub(shifted, str(escape(text))))
