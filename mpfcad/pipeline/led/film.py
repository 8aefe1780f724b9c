"""The films of a design for LEDs as files: 3MF libraries, and the stack that holds them."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.backlight.layer import OWN_VALUES
from mpfcad.errors import InputError
from mpfcad.film import Groove, PieceLibrary, build_library
from mpfcad.job import CadTable
from mpfcad.job.led_design import LedDesign
from mpfcad.pipeline.kind import kind_of

if TYPE_CHECKING:
    from mpfcad.report.page.led_page import ShownFilm

FILM, CROSSED, STACK = "film.3mf", "film-crossed.3mf", "stack.toml"
#: How far a cell may be from whole grooves [mm].
_ROOM = 1e-6
#: Facets within half a degree, the standard of a job's `[cad]`.
_CAD = CadTable()


@dataclass(frozen=True, eq=False)
class CellMap:
    """C(x, y) over a cell as a series of cosines, the LED at x = y = 0.

    Attributes
    ----------
    coefficient
        (h+1, h+1) float64 [1/mm], of cos 2πi x/Px · cos 2πj y/Py
    """

    coefficient: NDArray[np.float64]

    def at(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return C [1/mm] at all of u by all of v in periods, (n, m)."""
        order = np.arange(len(self.coefficient))
        across, along = (np.cos(2 * np.pi * np.outer(place, order)) for place in (u, v))
        return np.asarray(across @ self.coefficient @ along.T)

    @property
    def turned(self) -> "CellMap":
        """The same map as a film sees it that lies across."""
        return CellMap(self.coefficient.T.copy())


def library_of(design: LedDesign, field: CellMap, size: tuple[float, float]) -> PieceLibrary:
    """Return the film of a map over a cell of `size` [mm] along and across its own axes.

    Raises
    ------
    InputError
        when the cell is no whole number of grooves, or a curvature cannot be had.
    """
    groove = Groove(design.film.pitch, design.film.depth)
    count = round(size[0] / groove.pitch)
    if abs(count * groove.pitch - size[0]) > _ROOM:
        raise InputError(
            f"{design.name}: film.pitch_um: {groove.pitch * 1e3:g}: the LEDs' cell is "
            f"{size[0]:g} mm: expected a whole number of grooves"
        )
    pieces = max(1, round(size[1] / design.constraint.piece_mm))
    wanted = field.at((np.arange(count) + 0.5) / count, (np.arange(pieces) + 0.5) / pieces)
    return build_library(
        groove, design.film.base, size[1] / pieces, wanted, design.constraint.levels
    )


def write_films(
    design: LedDesign, stack: Stack, base: str, field: CellMap, folder: Path
) -> list[PieceLibrary]:
    """Write the films and the stack that holds them; return the films.

    `base` is what the stack file extends: a preset, or a file's path from `folder`.

    Raises
    ------
    InputError
        when two films are asked and the stack has none that is turned by 90°.
    """
    across, along = stack.period
    films = [library_of(design, field, (across, along))]
    kind_of(films[0], _CAD).write(folder / FILM, design.name)
    crossed = None
    if design.films == 2:
        crossed = _crossed_layer(design, stack)
        films.append(library_of(design, field.turned, (along, across)))
        kind_of(films[1], _CAD).write(folder / CROSSED, f"{design.name} crossed")
    (folder / STACK).write_bytes(_stack_text(stack, base, crossed).encode())
    return films


def check_films(films: list[PieceLibrary], folder: Path) -> None:
    """Read the written films back and compare them with what they should hold.

    Raises
    ------
    ExportError
        when one is not the film that was found.
    """
    for film, name in zip(films, (FILM, CROSSED), strict=False):
        kind_of(film, _CAD).check(folder / name)


def shown_films(films: list[PieceLibrary], folder: Path) -> "list[ShownFilm]":
    """Return what a page shows of the written films."""
    from mpfcad.report.page.led_page import ShownFilm

    return [
        ShownFilm(kind_of(film, _CAD), folder / name, film.piece(int(film.chosen[0, 0])))
        for film, name in zip(films, (FILM, CROSSED), strict=False)
    ]


def _crossed_layer(design: LedDesign, stack: Stack) -> str:
    for name, layer in stack.own.items():
        turned = stack.kind_of(name) == "film" and layer.file is None and not stack.is_slot(name)
        if turned and abs(abs(stack[f"{name}.rotation_deg"]) - 90) < 1e-9:
            return name
    raise InputError(
        f"{design.name}: films: 2: stack {stack.name} has no film across: expected a layer of kind "
        "bef with rotation_deg 90"
    )


def _stack_text(stack: Stack, base: str, crossed: str | None) -> str:
    """Return the TOML of the stack with the crossed film from its file."""
    lines = [f'extends = "{base}"', f'title = "{stack.title}"', "layers = ["]
    for name in stack.layers:
        lines.append(f"    {_entry(stack, name, name == crossed)},")
    given = {
        name: q.value
        for name, q in stack.quantity.items()
        if q.tag == "given" and q.source == "given by the user" and "." not in name
    }
    lines += ["]", "[value]", *(f"{name} = {value!r}" for name, value in given.items())]
    return "\n".join(lines) + "\n"


def _entry(stack: Stack, name: str, crossed: bool) -> str:
    """Return a layer as it stands in `layers`."""
    if name not in stack.own:
        return f'"{name}"'
    layer = stack.own[name]
    if crossed:
        kind, values = "film", {key: stack[f"{name}.{key}"] for key in ("index", "rotation_deg")}
        text = [f'kind = "{kind}"', f'name = "{name}"', f'file = "{CROSSED}"']
    else:
        values = {key: stack[f"{name}.{key}"] for key in OWN_VALUES[layer.kind]}
        text = [f'kind = "{layer.kind}"', f'name = "{name}"']
        text += [f'file = "{Path(layer.file).resolve()}"'] if layer.file else []
        text += ["flipped = true"] if layer.flipped else []
    text += [f"{key} = {value!r}" for key, value in values.items()]
    return "{ " + ", ".join(text) + " }"
