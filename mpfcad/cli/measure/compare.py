"""`mpfcad compare`: films and stacks side by side on one page."""

from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import Confidence, Effort, Json, Seed, StandardEffort, Threads


def command(
    sources: Annotated[
        list[str],
        typer.Argument(
            metavar="CASE…",
            help="JOB.toml, an export folder, FILE.stl, or a stack by its preset's name or file "
            "(with a plain BEF in it), all under tubes or all under LEDs; each with @STACK behind "
            "it to put the film into that stack.",
        ),
    ],
    seed: Seed = 1,
    effort: StandardEffort = Effort.standard,
    confidence: Confidence = False,
    threads: Threads = None,
    json: Json = False,
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder of the page and its figures.")
    ] = Path("exports/compare"),
) -> int:
    """Compare films and stacks with the conventional one, under LEDs with their own plain ones."""
    from mpfcad.cli.terminal import Terminal, print_comparison
    from mpfcad.pipeline import Measuring, compare_cases, read_cases

    with Terminal() as terminal:
        cases = []
        for source in sources:
            terminal.stage(f"reading {source}")
            film, _, stack = source.partition("@")
            cases += read_cases(film, stack or None)
        measuring = Measuring(seed, effort.value, threads)
        record = compare_cases(cases, out, measuring, terminal, confidence=confidence)
    print_comparison(record, out, as_json=json)
    return 0
