"""The page of a design for LEDs: what its films give, their maps and surfaces, what was tried."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from mpfcad.film import PrismFilm
from mpfcad.report.drawing.angle_figure import cell_figure
from mpfcad.report.drawing.film.dimension_drawing import draw_dimensions
from mpfcad.report.drawing.plot import plot
from mpfcad.report.film.kind import FilmKind
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import number, with_interval

Record = dict[str, Any]


@dataclass(frozen=True, eq=False)
class ShownFilm:
    """A film of a design, and the file that holds it; `piece` is one groove piece of it."""

    kind: FilmKind
    file: Path
    piece: PrismFilm


def write_led_page(path: Path, record: Record, films: Sequence[ShownFilm]) -> None:
    """Write the page; the same record and files give the same bytes."""
    page = render(
        "led.html.j2",
        record={**record, "process": None},
        result=_result(record),
        light=plot(cell_figure(record["found"]["cell"]), "light"),
        films=[_film(film, number) for number, film in enumerate(films, 1)],
        bears=[_borne(one) for one in record["bears"]],
        tried=[_tried(one) for one in record["tried"]],
        lines=range_lines(record["range"]),
        told=pilot_lines(record["pilot"]),
        boards=[_board(one) for one in (record["range"] or {"boards": []})["boards"]],
    )
    path.write_bytes(page.encode())


def _result(record: Record) -> list[tuple[str, str]]:
    found = record["found"]
    contrast, mould = found["lamp_mura_contrast"], record["mould"]
    rows: list[tuple[str, str | None]] = [
        ("lamp-Mura contrast, traced from the files", with_interval(contrast, 4)),
        ("mean normal luminance [cd/m²]", with_interval(found["mean_luminance_cd_m2"], 0)),
        ("σ / mean", with_interval(found["sigma_over_mean"], 4)),
        ("optical distance [mm], the plate over its index counted",
         number(record["optical_distance_mm"], 4)),
        ("H:P, that distance over the LED pitch", number(record["height_over_pitch"], 3)),
        ("paths of that trace", f"{found['paths'] / 1e6:.2f} million"),
        ("least contrast of any map of this mean within the limits, by a linear model",
         number(record["model_least"]["lamp_mura_contrast"], 4)),
        ("the same for a mould's C, from 20 /mm on",
         None if mould is None else number(mould["lamp_mura_contrast"], 4)),
        ("screen", record["printing"]["words"]),
        *((f"film {k}", one["words"]) for k, one in enumerate(record.get("halftone", []), 1)),
    ]  # fmt: skip
    return [(name, value) for name, value in rows if value]


def pilot_lines(found: Record | None) -> list[str]:
    """Return what was measured of the response of light to C, in words; none of two films."""
    if found is None:
        return []
    value, error = found["response_mm"], found["standard_error_mm"]
    line = f"response of ln L to C, a harmonic to its own: {value:.2g} ± {error:.1g} mm (1 σ)"
    if found["is_told"]:
        return [line]
    return [
        f"{line}: in the noise, so no map was tried; the least of any map is that of the largest "
        "response which this leaves possible"
    ]


def range_lines(found: Record | None) -> list[str]:
    """Return what a range of boards came to, in words; none of one board."""
    if found is None:
        return []
    unit = f" {found['unit']}" if found["unit"] else ""
    words = f"{found['of']} {found['chosen']:g}{unit}"
    target = f"contrast {found['contrast_target']:g}"
    if not found["serves"]:
        return [f"no {found['of']} of the range serves {target}; shown is the easiest, {words}"]
    last = [b for b in found["boards"] if b["searched"] and not b["searched"]["serves"]]
    beyond = (
        f"; {min(last, key=lambda b: abs(b['value'] - found['chosen']))['value']:g}{unit} does not"
        if last
        else "; it is the range's end"
    )
    return [f"{found['aim']} that serves {target} in the search: {words}{beyond}"]


def _board(one: Record) -> list[str]:
    searched = one["searched"]
    return [
        f"{one['value']:g}",
        "–" if one["model_least"] is None else number(one["model_least"], 3),
        "–" if searched is None else with_interval(searched, 4),
        "–" if searched is None else "serves" if searched["serves"] else "fails",
    ]


def _film(film: ShownFilm, place: int) -> Record:
    """Return the section of one film; ids within the page are numbered."""
    kind = film.kind
    section = dict(kind.film_section(film.piece, film.piece.groove_position, None, None))
    section["plot"] = replace(section["plot"], name=f"film-{place}")
    return {
        "file": film.file.name,
        "section": section,
        "rows": [("extent", kind.extent)],
        "view": plot(kind.view(film.file), f"view-{place}"),
        "view_words": kind.view_words.replace("film.3mf", film.file.name),
        "dimensions": draw_dimensions(kind.as_grooves(film.piece), 0),
        "section_title": kind.section_title,
    }


def departure_words(departure: Record) -> str:
    """Return a departure from the design in words."""
    return ", ".join(_words(name.rpartition(".")[2], value) for name, value in departure.items())


def _words(name: str, value: float) -> str:
    if name == "led_flux_spread":
        return f"LED flux spread {value:.3g}"
    if name == "led_repeat":
        return f"over {value:g} × {value:g} cells"
    thing, _, unit = name.rpartition("_")
    shown = f"{value:+g} %" if unit == "percent" else f"{value:g} {unit}"
    return f"{thing.replace('_', ' ').replace('crossed', 'film across:')} {shown}"


def _borne(one: Record) -> list[str]:
    return [
        departure_words(one["departure"]),
        with_interval(one["lamp_mura_contrast"], 4),
        with_interval(one["mean_luminance_cd_m2"], 0),
        one["outcome"],
    ]


def _tried(one: Record) -> list[str]:
    series = one["series_per_mm"]
    moved = max((abs(c) for row in series for c in row[1:]), default=0.0)
    pattern = max([moved, *(abs(row[0]) for row in series[1:])])
    return [
        f"{series[0][0]:.4g}",
        f"{pattern:.3g}",
        with_interval(one["lamp_mura_contrast"], 4),
        f"{one['paths'] / 1e6:.2f}",
    ]
