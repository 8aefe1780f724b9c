"""The few SVG elements that the report's drawings are made of."""

from collections.abc import Iterable
from html import escape

from markupsafe import Markup


def number(value: float) -> str:
    """Return a coordinate with two decimals at most."""
    shown = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if shown == "-0" else shown


def picture(width: float, height: float, title: str, parts: Iterable[str]) -> Markup:
    """Return a whole drawing that scales to the page's width."""
    return Markup(
        f'<svg viewBox="0 0 {number(width)} {number(height)}" role="img" '
        f'aria-label="{escape(title)}" xmlns="http://www.w3.org/2000/svg">'
        f"<title>{escape(title)}</title>{''.join(parts)}</svg>"
    )


def rectangle(x: float, y: float, width: float, height: float, style: str) -> str:
    """Return a rectangle; `style` holds SVG attributes."""
    return (
        f'<rect x="{number(x)}" y="{number(y)}" width="{number(width)}" '
        f'height="{number(height)}" {style}/>'
    )


def polygon(points: Iterable[tuple[float, float]], style: str) -> str:
    """Return a closed polygon."""
    return f'<polygon points="{_points(points)}" {style}/>'


def polyline(points: Iterable[tuple[float, float]], style: str) -> str:
    """Return an open polyline."""
    return f'<polyline points="{_points(points)}" fill="none" {style}/>'


def line(x1: float, y1: float, x2: float, y2: float, style: str) -> str:
    """Return a straight line."""
    return (
        f'<line x1="{number(x1)}" y1="{number(y1)}" x2="{number(x2)}" y2="{number(y2)}" {style}/>'
    )


def circle(x: float, y: float, radius: float, style: str) -> str:
    """Return a circle."""
    return f'<circle cx="{number(x)}" cy="{number(y)}" r="{number(radius)}" {style}/>'


def text(x: float, y: float, content: str, style: str = "") -> str:
    """Return a line of text."""
    return f'<text x="{number(x)}" y="{number(y)}" {style}>{escape(content)}</text>'


def _points(points: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{number(x)},{number(y)}" for x, y in points)
