"""Where the lamps' light goes, as a flow: bands as wide as their shares."""

from typing import Any

import numpy as np
from markupsafe import Markup

from mpfcad.report.drawing import svg

_WIDTH, _HEIGHT, _BAR = 720.0, 240.0, 16.0
#: Left edge of the bands' end, right of which the words stand; space between the ends.
_END, _GAP, _TOP = 470.0, 14.0, 12.0
_IN = 'fill="#c79a12"'
_OUT, _OUT_BAND = 'fill="#0b5fa5"', 'fill="#0b5fa5" fill-opacity="0.35"'
_LOSS, _LOSS_BAND = 'fill="#8a6d3b"', 'fill="#8a6d3b" fill-opacity="0.3"'
#: What a record calls the light sources of any kind.
SOURCES = "lamps"
#: A share below this is not drawn.
_LEAST = 1e-6


def draw_energy(energy: dict[str, Any], sources: str) -> Markup:
    """Return the flow from the sources (their word) to viewer and absorbers, as shares."""
    ends = [("to the viewer", energy["out"])]
    ends += [
        (f"absorbed by {sources if name == SOURCES else name}", share)
        for name, share in energy["absorbed_by"].items()
    ]
    ends.append(("lost", energy["lost"]))
    ends = [end for end in ends if end[1] > _LEAST]
    parts = [svg.rectangle(0, _TOP, _BAR, _HEIGHT, _IN)]
    parts.append(svg.text(_BAR + 8, _TOP + 20, f"light of the {sources}", 'font-size="13"'))
    start, place = _TOP, _TOP
    for number, (name, share) in enumerate(ends):
        high = share * _HEIGHT
        bar, band = (_LOSS, _LOSS_BAND) if number else (_OUT, _OUT_BAND)
        parts.append(_band(start, place, high, band))
        parts.append(svg.rectangle(_END, place, _BAR, max(high, 1.0), bar))
        words = f"{name}: {share:.1%}"
        parts.append(svg.text(_END + _BAR + 8, place + high / 2 + 4, words, 'font-size="13"'))
        start, place = start + high, place + max(high + 4, _GAP + 4)
    title = "Where the light goes: " + "; ".join(f"{name} {share:.1%}" for name, share in ends)
    return svg.picture(_WIDTH, max(place, _TOP + _HEIGHT) + 6, title, parts)


def _band(start: float, end: float, high: float, style: str) -> str:
    """Return a band of that height from the lamps' bar to an end, bent smoothly."""
    share = np.linspace(0.0, 1.0, 33)
    x = _BAR + share * (_END - _BAR)
    top = start + (end - start) * share**2 * (3 - 2 * share)
    upper = list(zip(x.tolist(), top.tolist(), strict=True))
    lower = [(a, b + high) for a, b in reversed(upper)]
    return svg.polygon([*upper, *lower], style + ' stroke="none"')
