"""Luminance of films whose resin scatters, against the share of the groove that it fills."""

from collections.abc import Callable, Sequence

from thesis.figure import Figure, Figures
from thesis.fill_case import (
    ASYMMETRY,
    DENSITY_PER_MM3,
    FILLS,
    FILLS_OF,
    INDEX,
    RADIUS_UM,
    SCATTERING_PER_MM,
    SERIES,
)
from thesis.table import table

_STACK = {"mpf": "MPF", "mpf-no-top": "MPF without top sheet"}
_RESIN = {"filled": "clear", "mie": "Mie", "g": f"g = {ASYMMETRY:g}"}


def fill_section(figures: Sequence[Figures], names: Sequence[str]) -> str:
    """Return the tables of luminance over fill, with verdicts."""
    level, darker = [], []
    for of, name in zip(figures, names, strict=True):
        for stack, resins in SERIES.items():
            for resin in resins:
                head = [f"`{name}`", _STACK[stack], _RESIN[resin]]
                level.append([*head, *_level(of, name, stack, resin)])
                if resin != "filled":
                    darker.append([*head, *_darker(of, name, stack, resin)])
    columns = ["set", "stack", "resin", *(f"{100 * fill:.0f} %" for fill in FILLS)]
    return f"""Published: luminance falls as the fill rises; particles in the resin, 10⁵ /mm³,
reproduce it. The thesis's text leaves out their radius and index. *Mie*: {DENSITY_PER_MM3:,.0f}
spheres /mm³ of {RADIUS_UM:g} µm radius and index {INDEX:g}; they scatter almost straight on.
*g = {ASYMMETRY:g}*: as much scattering, {SCATTERING_PER_MM:g} /mm (twice the cross-section of as
many such spheres), but wide. How to give them: [stack.md](stack.md).

Mean luminance over that of the conventional stack, by fill:

{table([*columns, "100 % over 10 %", "falls"], level)}
A clear fill, too, is the flatter the more there is of it, so this holds shape and particles
together. Over the luminance of the same film with a clear resin, so what the particles alone do:

{table([*columns, "darker at 100 %"], darker)}"""


def _level(of: Figures, name: str, stack: str, resin: str) -> list[str]:
    """Return luminance at each fill over the conventional stack's, and whether it falls."""
    case = {fill: f"{stack} {resin} {c:g}" for fill, c in FILLS.items()}
    fall = of.relative(case[1.0], case[0.10])
    cells = _cells(name, lambda fill: of.relative(case[fill]))
    return [*cells, fall.show(4), fall.beyond(1, above=False)]


def _darker(of: Figures, name: str, stack: str, resin: str) -> list[str]:
    """Return luminance at each fill over that with a clear resin, and whether it is less."""

    def ratio(fill: float) -> Figure:
        return of.fill_ratio(stack, resin, FILLS[fill])

    return [*_cells(name, ratio), ratio(1.0).beyond(1, above=False)]


def _cells(name: str, of: Callable[[float], Figure]) -> list[str]:
    """Return value ± half of the 95 % interval at each fill that is traced."""
    return [_show(of(fill)) if fill in FILLS_OF[name] else "–" for fill in FILLS]


def _show(figure: Figure) -> str:
    return f"{figure.value:.4f} ± {(figure.high - figure.low) / 2:.4f}"
