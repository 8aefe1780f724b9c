"""Plotly figures as data that a page draws when it is opened."""

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

if TYPE_CHECKING:
    import plotly.graph_objects as go

_CONFIG = {"displaylogo": False, "responsive": True, "displayModeBar": False}


@dataclass(frozen=True)
class Plot:
    """A figure within a page.

    Attributes
    ----------
    name
        its id, the only one of that name in the page
    words
        what it shows, for who cannot see it
    height
        in pixels
    content
        JSON of data, layout and config, safe between the tags of a script
    least_width
        in pixels; on a narrower page it scrolls sideways
    """

    name: str
    words: str
    height: int
    content: Markup
    least_width: int = 0


def plot(figure: "go.Figure", name: str, least_width: int = 0) -> Plot:
    """Return a figure as data; the same figure gives the same bytes."""
    content = json.loads(figure.to_json()) | {"config": _CONFIG}
    chosen = {key: content[key] for key in ("data", "layout", "config")}
    text = json.dumps(chosen, sort_keys=True, ensure_ascii=False).replace("<", r"\u003c")
    return Plot(name, _words(content), int(figure.layout.height), Markup(text), least_width)


def _words(content: dict[str, Any]) -> str:
    """Return titles, axes and names of the curves, each once."""
    layout = content["layout"]
    titles = [note.get("text", "") for note in layout.get("annotations", ())]
    axes = [axis.get("title", {}).get("text", "") for key, axis in layout.items() if "axis" in key]
    curves = [trace.get("name", "") for trace in content["data"]]
    return "Plot: " + "; ".join(dict.fromkeys(filter(None, [*titles, *axes, *curves])))
