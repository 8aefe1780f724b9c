"""The documentation's site: `sphinx-build -W docs build/site`; nothing of it needs a network."""

from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

project = "mpfcad"
author = "mpfcad"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
#: The reference is made of the docstrings, in the order of the source.
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
napoleon_google_docstring = False
napoleon_use_ivar = True
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4
html_theme = "furo"
html_title = "mpfcad"
html_show_copyright = False
html_show_sphinx = False
exclude_patterns = ["picture"]
html_theme_options = {"footer_icons": []}
#: Dates would make every build another.
html_last_updated_fmt = None
html_math_renderer = "mathml"


def _inline(self: Any, node: nodes.Element) -> None:
    self.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _block(self: Any, node: nodes.Element) -> None:
    self.body.append(convert(node.astext(), display="block"))
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Write formulas as MathML, which browsers draw without a script from elsewhere."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
