"""The films of a design for LEDs as files: 3MF libraries, and the stack that holds them."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from mpfcad.backlight import Stack
from mpfcad.backlight.layer.stated import OWN_VALUES
from mpfcad.film import CurvatureSeries
from mpfcad.job import build_job
from mpfcad.job.led_design import LedDesign
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.kind.library import PieceGrooves
from mpfcad.pipeline.led.job import job_tables
from mpfcad.pipeline.plan.cell import crossed_layer
from mpfcad.pipeline.plan.cell_map import read_cell_film_map
from mpfcad.pipeline.plan.halftone import describe_halftone

if TYPE_CHECKING:
    from mpfcad.report.page.led_page import ShownFilm

FILM, CROSSED, STACK = "film.3mf", "film-crossed.3mf", "stack.toml"


def films_of(design: LedDesign, stack: Stack, field: CurvatureSeries) -> list[PieceGrooves]:
    """Return the films of a map as its job makes them, the first one first.

    Raises
    ------
    InputError
        when the job of such films is refused, or two are asked and the stack has none that is
        turned by 90°.
    """
    job = build_job(job_tables(design, field), design.name)
    found = read_cell_film_map(job, Path(design.name), stack)
    films = [found.library(job, design.name)]
    if found.crossed is not None:
        crossed_layer(stack, f"{design.name}: films: 2")
        films.append(found.crossed.library(job, design.name))
    return [cast(PieceGrooves, kind_of(film, job.cad)) for film in films]


def halftones_of(design: LedDesign, stack: Stack, field: CurvatureSeries) -> list[dict[str, Any]]:
    """Return the halftone of each film in outside names; none of a design without."""
    job = build_job(job_tables(design, field), design.name)
    found = read_cell_film_map(job, Path(design.name), stack)
    return [
        describe_halftone(job, film.halftone, film.piece, design.name)
        for film in (found, found.crossed)
        if film is not None and film.halftone is not None
    ]


def write_films(
    design: LedDesign, stack: Stack, base: str, field: CurvatureSeries, folder: Path
) -> list[PieceGrooves]:
    """Write the films and the stack that holds them; return the films.

    `base` is what the stack file extends: a preset, or a file's path from `folder`.

    Raises
    ------
    InputError
        as `films_of`.
    """
    films = films_of(design, stack, field)
    titles = design.name, f"{design.name}-crossed"  # those of the job
    for film, name, title in zip(films, (FILM, CROSSED), titles, strict=False):
        film.write(folder / name, title)
    crossed = crossed_layer(stack, design.name) if len(films) > 1 else None
    (folder / STACK).write_bytes(_stack_text(stack, base, crossed).encode())
    return films


def check_films(films: list[PieceGrooves], folder: Path) -> None:
    """Read the written films back and compare them with what they should hold.

    Raises
    ------
    ExportError
        when one is not the film that was found.
    """
    for film, name in zip(films, (FILM, CROSSED), strict=False):
        film.check(folder / name)


def shown_films(films: list[PieceGrooves], folder: Path) -> "list[ShownFilm]":
    """Return what a page shows of the written films."""
    from mpfcad.report.page.led_page import ShownFilm

    return [
        ShownFilm(film, folder / name, film.corner)
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
