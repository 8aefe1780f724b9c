"""`mpfcad sweep`: contrast and luminance over any values of a job, on any number of processes."""

from pathlib import Path
from typing import Annotated, Any

import typer

from mpfcad.cli.option import Confidence, Out


def command(
    sweep_file: Annotated[
        Path, typer.Argument(metavar="SWEEP.toml", help="The sweep.", show_default=False)
    ],
    out: Out = None,
    confidence: Confidence = False,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://HOST:PORT."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=1, metavar="N", help="Local processes [default: all cores]."),
    ] = None,
) -> int:
    """Trace every point of a sweep; resumes where it stopped."""
    from mpfcad.cli.terminal import Terminal
    from mpfcad.job.sweep import read_sweep
    from mpfcad.pipeline import default_sweep_out, run_sweep
    from mpfcad.report import limit_words

    sweep = read_sweep(sweep_file)
    if confidence and sweep.confidence is None:
        sweep = sweep.model_copy(update={"confidence": {}})
    folder = out or default_sweep_out(sweep)
    with Terminal() as terminal:
        record = run_sweep(
            sweep, sweep_file, folder, scheduler=scheduler, workers=workers, progress=terminal
        )
    for one in record["optima"]:
        low, high = one["contrast"]["ci95"]
        curve = ", ".join(f"{k} = {v}" for k, v in one["curve"].items())
        print(
            f"{curve + ': ' if curve else ''}least contrast {one['contrast']['value']:.4f} "
            f"[{low:.4f}, {high:.4f}] at {one['axis']} = {one['optimum']:g}"
        )
        if "likeliest" in one:
            print(_likeliest(one))
    for one in record["thickness_limits"]:
        curve = ", ".join(f"{k} = {v}" for k, v in one["curve"].items())
        print(f"{curve + ': ' if curve else ''}{' '.join(limit_words(one))}")
    print(folder / "sweep.html")
    return 0


def _likeliest(optimum: dict[str, Any]) -> str:
    """Return where a curve is most likely within the limit, in words."""
    found, axis = optimum["likeliest"], optimum["axis"]
    low, high = found["ci95"]
    return (
        f"most likely at most {found['limit']:g} in the real backlight: "
        f"{found['value']:.2f} [{low:.2f}, {high:.2f}] at {axis} = {found[axis]:g}"
    )
