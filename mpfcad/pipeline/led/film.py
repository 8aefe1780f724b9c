"""The films of a design for LEDs as files: 3MF libraries, and the stack that holds them."""

from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.backlight import Stack
from mpfcad.backlight.layer.stated import OWN_VALUES
from mpfcad.film import CurvatureSeries, PieceLibrary, build_library
from mpfcad.job import CadTable
from mpfcad.job.led_design import LedDesign
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.cell import CellFrame, crossed_layer, wanted_over

if TYPE_CHECKING:
    from mpfcad.report.page.led_page import ShownFilm

FILM, CROSSED, STACK = "film.3mf", "film-crossed.3mf", "stack.toml"
#: Facets within half a degree, the standard of a job's `[cad]`.
_CAD = CadTable()


def library_of(design: LedDesign, field: CurvatureSeries, frame: CellFrame) -> PieceLibrary:
    """Return the film of a map over the cells of a frame, by the film's own axes.

    Raises
    ------
    InputError
        when the cell is no whole number of grooves, or a curvature cannot be had.
    """
    groove, size = design.film.groove, frame.size
    wanted = wanted_over(field.at, frame, groove.pitch, design.constraint.piece_mm, design.name)
    length = size[1] / wanted.shape[1]
    cell = build_library(groove, design.film.base, length, wanted, design.constraint.levels)
    return cell.repeated(frame.repeat)


def write_films(
    design: LedDesign, stack: Stack, base: str, field: CurvatureSeries, folder: Path
) -> list[PieceLibrary]:
    """Write the films and the stack that holds them; return the films.

    `base` is what the stack file extends: a preset, or a file's path from `folder`.

    Raises
    ------
    InputError
        when two films are asked and the stack has none that is turned by 90°.
    """
    frame = CellFrame.of(stack)
    films = [library_of(design, field, frame)]
    kind_of(films[0], _CAD).write(folder / FILM, design.name)
    crossed = None
    if design.films == 2:
        crossed = crossed_layer(stack, f"{design.name}: films: 2")
        films.append(library_of(design, field.turned, frame.turned))
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
        there = [key for key in OWN_VALUES[layer.kind] if f"{name}.{key}" in stack.quantity]
        values = {key: stack[f"{name}.{key}"] for key in there}
        text = [f'kind = "{layer.kind}"', f'name = "{name}"']
        text += [f'file = "{Path(layer.file).resolve()}"'] if layer.file else []
        text += ["flipped = true"] if layer.flipped else []
    text += [f"{key} = {value!r}" for key, value in values.items()]
    return "{ " + ", ".join(text) + " }"
