"""Arguments and options that several subcommands share."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer


class Effort(StrEnum):
    """How long to trace; the same words as in a job's `[trace]`."""

    quick = "quick"
    standard = "standard"
    final = "final"


JobFile = Annotated[Path, typer.Argument(metavar="JOB.toml", help="The job.", show_default=False)]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Folder of the results [default: exports/NAME]."),
]
TraceEffort = Annotated[
    Effort | None,
    typer.Option("--effort", help="How long to trace [default: the job's]."),
]
StandardEffort = Annotated[Effort, typer.Option("--effort", help="How long to trace.")]
Seed = Annotated[
    int,
    typer.Option("--seed", min=0, max=2**64 - 1, metavar="N", help="Seed of the random numbers."),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Confidence = Annotated[
    bool,
    typer.Option(
        "--confidence",
        help="State how likely the contrast's limits are met, with every input's uncertainty.",
    ),
]
EstimatorWord = Annotated[
    str,
    typer.Option(
        "--estimator",
        metavar="WAY",
        help="Trace a cell of LEDs forward (from the LEDs), backward (from the meter), or auto: "
        "what a pilot run finds to need less work.",
    ),
]
Junit = Annotated[
    Path | None,
    typer.Option("--junit", metavar="FILE.xml", help="Write the gates as a JUnit report too."),
]
Threads = Annotated[
    int | None,
    typer.Option(
        "--threads",
        min=1,
        metavar="N",
        help="Threads of the tracer; the figures do not depend on it [default: all cores].",
    ),
]
#: Where a film of `read_case` lies.
ThicknessMm = Annotated[
    float | None,
    typer.Option("--thickness-mm", metavar="MM", help="Reflector to plate [default: stack's]."),
]
OffsetMm = Annotated[
    float, typer.Option("--offset-mm", metavar="MM", help="Left edge of FILE.stl from a lamp.")
]

#: How the file of a measured luminance, a curve or an image, is to be read.
PositionUnit = Annotated[
    str | None, typer.Option("--unit", metavar="U", help="Unit of a curve's positions.")
]
PixelSide = Annotated[
    float | None, typer.Option("--pixel-mm", metavar="MM", help="Side of an image's pixel.")
]
PerCount = Annotated[
    float,
    typer.Option("--cd-m2-per-count", metavar="L", help="Luminance of one count of an image."),
]
Dark = Annotated[Path | None, typer.Option("--dark", help="Image to subtract: dark frame.")]
Flat = Annotated[Path | None, typer.Option("--flat", help="Image to divide by: flat field.")]
Crop = Annotated[
    str | None,
    typer.Option("--crop", metavar="L,T,R,B", help="Part of the image to use, in pixels."),
]
ImageRotation = Annotated[
    float, typer.Option("--rotation-deg", help="Angle from the image's x to across the lamps.")
]


def formats(text: str, known: tuple[str, ...], option: str = "--format") -> tuple[str, ...]:
    """Return the words of `known` named in `text`, separated by commas.

    Raises
    ------
    InputError
        when a word is unknown or none is given.
    """
    from mpfcad.errors import InputError

    chosen = tuple(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))
    unknown = [name for name in chosen if name not in known]
    if unknown or not chosen:
        wrong = unknown[0] if unknown else repr(text)
        raise InputError(f"{option}: {wrong}: expected some of {', '.join(known)}")
    return chosen
