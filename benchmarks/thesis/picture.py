"""Contrast and luminance against curvature as a static drawing."""

from collections.abc import Callable

from mpfcad.report.drawing.svg import circle, line, picture, polygon, polyline, rectangle, text
from thesis.figure import Figure, Figures

_WIDTH, _HEIGHT = 860, 400
_LEFT, _TOP, _WIDE, _TALL = (58, 492), 46, 350, 270
_LOW, _HIGH = 48.0, 83.0
_COLOUR = {"thesis-32in": "#1c5f9e", "thesis-fitted": "#b4541a"}
#: The sets' points stand side by side [1/mm].
_ASIDE = {"thesis-32in": -0.2, "thesis-fitted": 0.2}
_DASH = {"mpf": "", "plate": ' stroke-dasharray="6 4"'}
_FAMILY = {"mpf": "mpf ideal", "plate": "mpf-plate ideal"}
_INK, _SOFT = 'fill="#1d232a" font-size="13"', 'fill="#5a6570" font-size="12"'
_MIDDLE, _END = ' text-anchor="middle"', ' text-anchor="end"'


def draw_curvature(results: dict) -> str:
    """Return the SVG of contrast (left) and relative luminance (right) for both sets of values."""
    sets = {name: Figures(results, name) for name in _COLOUR}
    parts = [rectangle(0, 0, _WIDTH, _HEIGHT, 'fill="#ffffff"')]
    left = _Panel(_LEFT[0], 0.0, 0.032, 0.004, 3)
    right = _Panel(_LEFT[1], 1.01, 1.07, 0.01, 2)
    parts += left.frame("lamp-Mura contrast, ideal profile")
    parts += right.frame("mean luminance / conventional")
    limit = left.y(0.012)
    parts.append(line(left.x(57), limit, left.x(81), limit, 'stroke="#1d232a" stroke-width="5"'))
    label = "published: at most 0.012 in 57 … 81 /mm"
    parts.append(text(left.x(49), left.y(0.0302), "bar: " + label, _SOFT))
    for curvature, value in ((60, 7243 / 6875), (60, 7070 / 6875)):
        x, y = right.x(curvature), right.y(value)
        parts.append(polygon([(x - 6, y), (x, y - 6), (x + 6, y), (x, y + 6)], 'fill="#1d232a"'))
    for name, figures in sets.items():
        for family in _FAMILY:
            parts += left.curve(figures.curve[family], "contrast", name, family)
            parts += right.curve(figures.curve[family], "luminance", name, family)
            parts += left.points(figures, family, name, figures.contrast)
            parts += right.points(figures, family, name, figures.relative)
    parts += _legend()
    # A drawing that is looked at alone needs a font of its own.
    whole = str(picture(_WIDTH, _HEIGHT, "Contrast and luminance against curvature", parts))
    return (
        whole.replace("<svg ", '<svg font-family="system-ui, DejaVu Sans, sans-serif" ', 1) + "\n"
    )


class _Panel:
    """One diagram: curvature across, a figure up."""

    def __init__(self, left: float, low: float, high: float, step: float, digits: int):
        self.left, self.low, self.high, self.step, self.digits = left, low, high, step, digits

    def x(self, curvature: float) -> float:
        return self.left + (curvature - _LOW) / (_HIGH - _LOW) * _WIDE

    def y(self, value: float) -> float:
        inside = min(max(value, self.low), self.high)
        return _TOP + (self.high - inside) / (self.high - self.low) * _TALL

    def frame(self, title: str) -> list[str]:
        """Return title, grid and labels."""
        bottom = _TOP + _TALL
        parts = [text(self.left, _TOP - 16, title, _INK + ' font-weight="600"')]
        steps = round((self.high - self.low) / self.step - 0.3)
        for i in range(steps + 1):
            value = self.low + i * self.step
            y = self.y(value)
            parts.append(line(self.left, y, self.left + _WIDE, y, 'stroke="#d9dee3"'))
            parts.append(text(self.left - 6, y + 4, f"{value:.{self.digits}f}", _SOFT + _END))
        for curvature in range(50, 81, 10):
            x = self.x(curvature)
            parts.append(line(x, bottom, x, bottom + 5, 'stroke="#5a6570"'))
            parts.append(text(x, bottom + 19, f"{curvature}", _SOFT + _MIDDLE))
        middle = self.left + _WIDE / 2
        parts.append(text(middle, bottom + 38, "C through the tips [1/mm]", _SOFT + _MIDDLE))
        return parts

    def curve(self, curve: dict, what: str, name: str, family: str) -> list[str]:
        """Return a family's line over its band."""
        xs = [self.x(c) for c in curve["curvature_per_mm"]]
        low, high, value = (
            [(x, self.y(v)) for x, v in zip(xs, curve[what][key], strict=True)]
            for key in ("low", "high", "value")
        )
        colour = _COLOUR[name]
        style = f'stroke="{colour}" stroke-width="2"{_DASH[family]}'
        band = f'fill="{colour}" fill-opacity="0.13" stroke="none"'
        return [polygon([*low, *reversed(high)], band), polyline(value, style)]

    def points(
        self, figures: Figures, family: str, name: str, read: Callable[[str], Figure]
    ) -> list[str]:
        """Return the single traces with their intervals."""
        parts, colour = [], _COLOUR[name]
        for case in figures.case:
            if case.startswith(_FAMILY[family] + " "):
                x = self.x(float(case.split()[-1]) + _ASIDE[name])
                found = read(case)
                low, high = self.y(found.low), self.y(found.high)
                parts.append(line(x, low, x, high, f'stroke="{colour}"'))
                parts.append(circle(x, self.y(found.value), 3.5, f'fill="{colour}"'))
        return parts


def _legend() -> list[str]:
    parts, y, x = [], _HEIGHT - 16, 58.0
    for name, colour in _COLOUR.items():
        for family, label in (("mpf", "MPF"), ("plate", "MPF-Plate")):
            style = f'stroke="{colour}" stroke-width="2"{_DASH[family]}'
            parts.append(line(x, y - 4, x + 30, y - 4, style))
            parts.append(text(x + 36, y, f"{name} {label}", _SOFT))
            x += 176
    parts.append(polygon([(x, y - 4), (x + 6, y - 10), (x + 12, y - 4), (x + 6, y + 2)],
                         'fill="#1d232a"'))  # fmt: skip
    parts.append(text(x + 18, y, "published", _SOFT))
    return parts
