"""The templates of the pages: jinja2 with autoescape, and how numbers stand in them.

Templates live in `report/template`. A page's module gathers plain values; what becomes HTML, and
all text of a page, stands in its template.
"""

from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from mpfcad.report.page.number import formula, number, value_words, with_error, with_interval


def render(template: str, /, **values: Any) -> str:
    """Return the page or part of the template named; the same values give the same text.

    Raises
    ------
    jinja2.UndefinedError
        when the template names a value that is not given.
    """
    return _environment().get_template(template).render(**values)


class _Environment(Environment):
    """Templates in which `table.key` is the entry of a dict, also of a key like `values`."""

    def getattr(self, obj: Any, attribute: str) -> Any:
        if isinstance(obj, dict) and attribute in obj:
            return obj[attribute]
        return super().getattr(obj, attribute)


@cache
def _environment() -> Environment:
    made = _Environment(
        loader=PackageLoader("mpfcad.report", "template"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters |= {
        "formula": formula,
        "number": number,
        "value_words": value_words,
        "with_error": with_error,
        "with_interval": with_interval,
    }
    made.globals["plotly_script"] = _plotly_script
    return made


def _plotly_script() -> Markup:
    """Return plotly.js, to be put into a page once; the page then needs no network."""
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs())
