"""Tables and numbers of the report as HTML."""

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any


def table(head: Sequence[str], rows: Iterable[Sequence[str]], numeric: Sequence[int] = ()) -> str:
    """Return an HTML table; cells are HTML, columns in `numeric` are set to the right.

    A cell may be a pair (class, content).
    """

    def cell(tag: str, column: int, content: str | tuple[str, str]) -> str:
        kind, inner = content if isinstance(content, tuple) else ("", content)
        classes = " ".join(filter(None, [kind, "n" if column in numeric else ""]))
        attribute = f' class="{classes}"' if classes else ""
        return f"<{tag}{attribute}>{inner}</{tag}>"

    lines = ["<tr>" + "".join(cell("th", i, name) for i, name in enumerate(head)) + "</tr>"]
    lines += [
        "<tr>" + "".join(cell("td", i, c) for i, c in enumerate(row)) + "</tr>" for row in rows
    ]
    return f'<div class="scroll"><table>{"".join(lines)}</table></div>'


def fact_table(facts: Iterable[tuple[str, str]]) -> str:
    """Return a table of two columns without a head."""
    rows = "".join(f"<tr><td>{name}</td><td>{value}</td></tr>" for name, value in facts)
    return f"<table>{rows}</table>"


def figure(content: str, caption: str) -> str:
    """Return a figure with its caption."""
    return f"<figure>{content}<figcaption>{caption}</figcaption></figure>"


def short(value: Any, digits: int = 4) -> str:
    """Return a number with so many significant digits, anything else as escaped text."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return escape(str(value))
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    shown = f"{value:.{digits}g}"
    if "e" not in shown:
        return shown
    mantissa, exponent = shown.split("e")
    return f"{mantissa} · 10<sup>{int(exponent)}</sup>".replace("-", "−")


def with_interval(estimate: dict[str, Any], decimals: int) -> str:
    """Return `value [low, high]` with so many decimals."""
    low, high = estimate["ci95"]
    return f"{estimate['value']:.{decimals}f} [{low:.{decimals}f}, {high:.{decimals}f}]"
