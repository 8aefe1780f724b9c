"""Pages come from templates: what a job says is text, never HTML."""

import re
from pathlib import Path

import pytest
from jinja2 import UndefinedError
from markupsafe import Markup

import mpfcad.report
from mpfcad.report.page.environment import _environment, render
from mpfcad.report.page.number import formula, number

REPORT = Path(mpfcad.report.__file__).parent
HOSTILE = '<script>alert("x")</script>'


def test_names_are_escaped():
    page = render("figures.html.j2", name=HOSTILE, kind="k", head=HOSTILE)
    assert HOSTILE not in page
    assert page.count("&lt;script&gt;") == 3
    assert HOSTILE not in formula(HOSTILE)
    assert HOSTILE not in number(HOSTILE)


def test_a_value_that_is_not_given_is_an_error():
    with pytest.raises(UndefinedError):
        render("figures.html.j2", name="x", kind="k")


def test_an_entry_of_a_dict_comes_before_its_methods():
    """`values`, `items` and the like are names of figures too."""
    assert _environment().from_string("{{ x.values }}").render(x={"values": 3}) == "3"


def test_formula_lowers_and_raises():
    assert formula("L_{max} < 10^{3}, min_web_um") == Markup(
        "L<sub>max</sub> &lt; 10<sup>3</sup>, min_web_um"
    )


@pytest.mark.parametrize(
    ("value", "shown"),
    [(12345, "12 345"), (0.5, "0.5"), (1.5e-7, "1.5 · 10<sup>−7</sup>"), (True, "True")],
)
def test_numbers(value, shown):
    assert number(value, 3) == shown


def test_html_stands_in_templates_only():
    """Modules of pages gather values; number.py alone makes `<sub>` and `<sup>`."""
    for path in sorted((REPORT / "page").glob("*.py")):
        tags = set(re.findall(r"</?([a-z]+[1-6]?)>", path.read_text("utf-8")))
        assert tags <= ({"sub", "sup"} if path.name == "number.py" else set()), path.name
