"""`mpfcad rays`: a backlight's light as a ray file for other optics programs."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import Json, OffsetMm, Seed, ThicknessMm, Threads


class Place(StrEnum):
    """Where rays are taken."""

    screen = "screen"
    film = "film"


def command(
    source: Annotated[
        str,
        typer.Argument(metavar="FILE.stl|DIR|JOB.toml|STACK", help="The film in its backlight."),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "--out",
            metavar="FILE",
            help="Ray file: .tm25ray (IES TM-25), .dat (Zemax) or .ray (LightTools); "
            "an older one is replaced.",
        ),
    ],
    at: Annotated[
        Place,
        typer.Option("--at", help="Light that leaves the screen, or that comes up to the film."),
    ] = Place.screen,
    rays: Annotated[
        int, typer.Option("--rays", min=1, max=1_000_000_000, metavar="N", help="Number of rays.")
    ] = 1_000_000,
    stack: Annotated[
        str | None,
        typer.Option(
            "--stack", metavar="NAME|FILE.toml", help="Stack to put it in [default: its own]."
        ),
    ] = None,
    thickness_mm: ThicknessMm = None,
    offset_mm: OffsetMm = 0.0,
    seed: Seed = 1,
    threads: Threads = None,
    json: Json = False,
) -> int:
    """Write the light that leaves the screen, or comes up to the film, as a ray file."""
    from mpfcad.backlight.source.ray_write import check_ray_suffix
    from mpfcad.cli.character import print_json
    from mpfcad.cli.terminal import Terminal
    from mpfcad.pipeline import read_case, write_rays

    check_ray_suffix("--out", out)
    with Terminal() as terminal:
        terminal.stage(f"reading {source}")
        case = read_case(source, stack, thickness_mm, offset_mm)
        record = write_rays(
            case, out, "film" if at is Place.film else "screen", rays, seed, threads, terminal
        )
    if json:
        print_json(record)
        return 0
    flux = record["flux_lm"]
    print(
        f"{record['file']}: {record['rays']} rays, {record['form']}, mm, "
        f"{flux['value']:.6g} ± {flux['standard_error']:.2g} lm; "
        f"the lamps emit {record['emitted_lm']:.6g} lm"
    )
    return 0
