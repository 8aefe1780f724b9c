"""`mpfcad measure`: every photometric figure of a film in a stack, as JSON, pictures and a page."""

from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import (
    Confidence,
    Effort,
    EstimatorWord,
    Json,
    OffsetMm,
    Seed,
    StandardEffort,
    ThicknessMm,
    Threads,
)


def command(
    source: Annotated[
        str, typer.Argument(metavar="FILE.stl|DIR|JOB.toml|STACK", help="What to measure.")
    ],
    stack: Annotated[
        str | None,
        typer.Option(
            "--stack",
            metavar="NAME|FILE.toml",
            help="Stack to measure in [default: the film's own].",
        ),
    ] = None,
    thickness_mm: ThicknessMm = None,
    offset_mm: OffsetMm = 0.0,
    what: Annotated[
        str | None,
        typer.Option(
            "--what",
            metavar="A,B,…",
            help="What to measure: contrast, angular, conoscope, flux, uniformity, camera, panel, "
            "polarisation, colour, psf [default: all that the stack has].",
        ),
    ] = None,
    seed: Seed = 1,
    effort: StandardEffort = Effort.standard,
    confidence: Confidence = False,
    estimator: EstimatorWord = "auto",
    threads: Threads = None,
    json: Json = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder [default: exports/NAME-measure]."),
    ] = None,
) -> int:
    """Measure contrast, viewing angles, conoscope, flux, uniformity and camera image of a film."""
    from mpfcad.cli.option import formats
    from mpfcad.cli.terminal import Terminal, print_measurement
    from mpfcad.pipeline import (
        WHAT,
        Measuring,
        default_measure_out,
        default_what,
        measure_film,
        read_case,
    )

    chosen = formats(what, WHAT, "--what") if what else None
    with Terminal() as terminal:
        terminal.stage(f"reading {source}")
        case = read_case(source, stack, thickness_mm, offset_mm)
        folder = out or default_measure_out(case)
        measuring = Measuring(seed, effort.value, threads, estimator)
        record = measure_film(
            case, chosen or default_what(case), folder, measuring, terminal, confidence=confidence
        )
    print_measurement(record, folder, as_json=json)
    return 0
