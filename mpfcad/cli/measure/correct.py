"""`mpfcad correct`: the next map after the luminance of a print was measured."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from mpfcad.cli.measure.judge import photo_of, refuse_infinite, refuse_not_above_0, unit_of
from mpfcad.cli.option import (
    Crop,
    Dark,
    Flat,
    ImageRotation,
    Json,
    PerCount,
    PixelSide,
    PositionUnit,
    Threads,
)


def command(
    export: Annotated[
        Path, typer.Argument(metavar="EXPORT", help="Export of the film that was printed.")
    ],
    measured: Annotated[
        Path, typer.Option("--measured", metavar="FILE", help="Measured luminance: curve or image.")
    ],
    lamp_at_mm: Annotated[
        float, typer.Option("--lamp-at-mm", metavar="MM", help="Place of a lamp in that file.")
    ],
    process: Annotated[
        Path | None,
        typer.Option(
            "--process", metavar="FILE.toml", help="Process calibration from coupons of this print."
        ),
    ] = None,
    stack: Annotated[
        Path | None,
        typer.Option(
            "--stack",
            metavar="FILE.toml",
            help="Backlight that mpfcad fit found with this print [default: the export's].",
        ),
    ] = None,
    solids: Annotated[
        str | None,
        typer.Option(
            "--solids",
            metavar="S|auto",
            help="Solids fraction of the resin of the next print; auto: the nearest to the "
            "print's that serves, or the best [default: the print's].",
        ),
    ] = None,
    pitch_mm: Annotated[
        float | None,
        typer.Option(
            "--pitch-mm", metavar="MM", help="Lamp pitch in that file [default: the stack's]."
        ),
    ] = None,
    unit: PositionUnit = None,
    pixel_mm: PixelSide = None,
    cd_m2_per_count: PerCount = 1.0,
    dark: Dark = None,
    flat: Flat = None,
    crop: Crop = None,
    rotation_deg: ImageRotation = 0.0,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder [default: exports/NAME-corrected]."),
    ] = None,
    threads: Threads = None,
    json: Json = False,
) -> int:
    """Find the next map after a print was measured; write its job, and what changes in the mask."""
    from mpfcad.cli.character import print_json
    from mpfcad.cli.terminal import Terminal
    from mpfcad.pipeline.correct.printed import correct_print
    from mpfcad.pipeline.judge import Judging

    folder = out or Path("exports") / f"{export.name}-corrected"
    refuse_not_above_0(pitch_mm, pixel_mm, cd_m2_per_count)
    refuse_infinite("--lamp-at-mm", lamp_at_mm)
    photo = photo_of(pixel_mm, cd_m2_per_count, dark, flat, crop, rotation_deg)
    judging = Judging(photo, unit_of(unit), pitch_mm, lamp_at_mm)
    with Terminal() as terminal:
        record = correct_print(
            export, measured, judging, folder,
            process_file=process, stack_file=stack, solids=_solids(solids),
            threads=threads, progress=terminal,
        )  # fmt: skip
    if json:
        print_json(record)
        return 0
    seen, next_one = record["measured_lamp_mura_contrast"], record["predicted_lamp_mura_contrast"]
    print(f"measured contrast {seen['value']:.4f} [{seen['ci95'][0]:.4f}, {seen['ci95'][1]:.4f}]")
    print(f"next map: {next_one['value']:.4f} [{next_one['ci95'][0]:.4f}, "
          f"{next_one['ci95'][1]:.4f}] by the model as corrected, within "
          f"{record['contrast_limit']:g} in {record['confidence']:.0%} of the measurement's "
          "plausible truths")  # fmt: skip
    share = record["share_at_limits"]
    if share > 0:
        low, high = record["curvature_limits_per_mm"]
        ways = "another mesh or period" if solids else "--solids auto, another mesh or period"
        print(f"C lies at what can be printed, {low:.4g} ... {high:.4g} /mm, over {share:.0%} of "
              f"the pitch: {ways} would allow more")  # fmt: skip
    resin = record["solids_fraction"]
    if resin["next"] != resin["printed"]:
        print(f"resin: solids fraction {resin['next']:.4g} instead of {resin['printed']:.4g}")
    print(folder / f"{record['name']}.toml")
    return 0


def _solids(text: str | None) -> "float | Literal['auto'] | None":
    """Return a solids fraction as asked.

    Raises
    ------
    InputError
        when it is none.
    """
    from mpfcad.errors import InputError

    if text is None or text == "auto":
        return text  # type: ignore[return-value]
    try:
        found = float(text)
    except ValueError:
        found = float("nan")
    if not 0 < found <= 1:
        raise InputError(f"--solids: {text}: expected auto, or above 0 up to 1")
    return found
