"""`mpfcad trace`: any closed film mesh in a backlight stack."""

from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import (
    Confidence,
    Effort,
    EstimatorWord,
    Json,
    Seed,
    StandardEffort,
    Threads,
)


def command(
    mesh: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE",
            help="A closed film: STL, 3MF, PLY, OBJ or STEP, in mm; none for a stack with a BSDF "
            "table in its place.",
            show_default=False,
        ),
    ] = None,
    stack: Annotated[
        str, typer.Option("--stack", metavar="NAME|FILE.toml", help="See mpfcad stacks.")
    ] = "thesis-32in-mpf",
    thickness_mm: Annotated[
        float | None,
        typer.Option("--thickness-mm", metavar="MM", help="Reflector to plate [default: preset]."),
    ] = None,
    offset_mm: Annotated[
        float, typer.Option("--offset-mm", metavar="MM", help="Left edge from a lamp's axis.")
    ] = 0.0,
    prism: Annotated[
        Path | None,
        typer.Option("--prism", metavar="FILE", help="The film without its resin."),
    ] = None,
    repair: Annotated[
        bool,
        typer.Option("--repair", help="Repair a mesh that is no solid into FILE-repaired.stl."),
    ] = False,
    seed: Seed = 1,
    effort: StandardEffort = Effort.standard,
    confidence: Confidence = False,
    estimator: EstimatorWord = "auto",
    threads: Threads = None,
    json: Json = False,
) -> int:
    """Trace a film mesh in a stack: figures only, no verdict."""
    from mpfcad.cli.terminal import Terminal, print_trace
    from mpfcad.pipeline import trace_mesh

    with Terminal() as terminal:
        figures = trace_mesh(
            mesh, stack, thickness_mm, offset_mm, seed, effort.value, threads, terminal, prism,
            repair, confidence, estimator,
        )  # fmt: skip
    print_trace(figures, as_json=json)
    return 0
