"""A figure with its 95 % interval, and the small tables that a notebook shows."""

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any, NamedTuple


class Figure(NamedTuple):
    """A value and its 95 % interval, in the unit that its name states.

    Attributes
    ----------
    value
        the estimate
    low, high
        the ends of its 95 % interval; both `value` where the figure has no noise

    Examples
    --------
    >>> print(Figure(0.0052, 0.0031, 0.0068))
    0.0052 [0.0031, 0.0068]
    """

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, entry: Mapping[str, Any] | None) -> "Figure":
        """Return the figure of an entry `{value, ci95}` of a record; NaN where not traced."""
        if entry is None or entry["value"] is None:
            return cls(float("nan"), float("nan"), float("nan"))
        low, high = entry.get("ci95") or (entry["value"], entry["value"])
        return cls(float(entry["value"]), float(low), float(high))

    def __str__(self) -> str:
        if self.value != self.value:
            return "not measured"
        return f"{self.value:.4g} [{self.low:.4g}, {self.high:.4g}]"


def html_table(title: str, head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """Return a table of plain HTML; every cell is escaped."""
    first = "".join(f"<th>{escape(text)}</th>" for text in head)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows
    )
    table = f"<table><thead><tr>{first}</tr></thead><tbody>{body}</tbody></table>"
    return f"<div><b>{escape(title)}</b>{table}</div>"


def text_lines(title: str, rows: Iterable[tuple[str, object]]) -> str:
    """Return a title and a line a row, the values below each other.

    Examples
    --------
    >>> print(text_lines("wave: PASS", [("contrast", Figure(0.0052, 0.0031, 0.0068))]))
    wave: PASS
      contrast  0.0052 [0.0031, 0.0068]
    """
    rows = list(rows)
    width = max((len(name) for name, _ in rows), default=0)
    return "\n".join([title, *(f"  {name:<{width}}  {value}" for name, value in rows)])
