"""`mpfcad judge`: a measured luminance, curve or image, judged as a trace is."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mpfcad.cli.option import (
    Crop,
    Dark,
    Flat,
    ImageRotation,
    Json,
    PerCount,
    PixelSide,
    PositionUnit,
    Seed,
)

if TYPE_CHECKING:
    from mpfcad.measure.observed import Photo


def command(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Curve (CSV) or image (TIFF, FITS, EXR, CSV).")
    ],
    against: Annotated[
        Path | None,
        typer.Option(
            "--against",
            metavar="EXPORT",
            help="Export to compare with: its luminance and its limits.",
        ),
    ] = None,
    pitch_mm: Annotated[
        float | None,
        typer.Option("--pitch-mm", metavar="MM", help="Lamp pitch [default: found in the file]."),
    ] = None,
    lamp_at_mm: Annotated[
        float | None,
        typer.Option("--lamp-at-mm", metavar="MM", help="Place of a lamp in the file."),
    ] = None,
    spots: Annotated[
        bool, typer.Option("--spots", help="LEDs: judge the contrast over a cell.")
    ] = False,
    cell_mm: Annotated[
        str | None,
        typer.Option("--cell-mm", metavar="X,Y", help="Size of the cell [default: found]."),
    ] = None,
    unit: PositionUnit = None,
    pixel_mm: PixelSide = None,
    cd_m2_per_count: PerCount = 1.0,
    dark: Dark = None,
    flat: Flat = None,
    crop: Crop = None,
    rotation_deg: ImageRotation = 0.0,
    limit: Annotated[
        float | None,
        typer.Option("--limit", help="PASS up to this contrast [default: export's, or 0.012]."),
    ] = None,
    marginal: Annotated[
        float | None,
        typer.Option(
            "--marginal", help="MARGINAL up to this contrast [default: export's, or 0.018]."
        ),
    ] = None,
    page: Annotated[
        Path | None,
        typer.Option("--page", metavar="FILE.html", help="Write a page of plots and figures."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE.json", help="Write the figures as JSON.")
    ] = None,
    seed: Seed = 1,
    json: Json = False,
) -> int:
    """Judge a measured luminance by the same code and gates as a trace."""
    from mpfcad.boundary.out import check_out
    from mpfcad.cli.character import print_json
    from mpfcad.gate import exit_code
    from mpfcad.pipeline.judge import Judging, gate_of, judge_luminance

    refuse_not_above_0(pitch_mm, pixel_mm, cd_m2_per_count)
    refuse_infinite("--lamp-at-mm", lamp_at_mm)
    judging = Judging(
        photo_of(pixel_mm, cd_m2_per_count, dark, flat, crop, rotation_deg),
        unit_of(unit), pitch_mm, lamp_at_mm, _pair(cell_mm), spots, limit, marginal, against, seed,
    )  # fmt: skip
    check_out("--out", out, (b"{\n",))
    check_out("--page", page, (b"<!DOCTYPE html>",))
    record = judge_luminance(file, judging)
    _write(record, out, page)
    if json:
        print_json(record)
    else:
        _print(record)
    return exit_code(gate_of(record).outcome)


def photo_of(
    pixel: float | None, scale: float, dark: Path | None, flat: Path | None, crop: str | None,
    rotation_deg: float,
) -> "Photo | None":  # fmt: skip
    """Return how an image becomes luminance, by the options; None without a pixel's size."""
    from mpfcad.errors import InputError
    from mpfcad.measure.observed import Photo
    from mpfcad.units import deg

    refuse_infinite("--rotation-deg", rotation_deg)
    if abs(rotation_deg) > 180:
        raise InputError(f"--rotation-deg: {rotation_deg:g}: expected -180 to 180")
    if pixel is None:
        return None
    box = None
    if crop is not None:
        try:
            left, top, right, bottom = (int(part) for part in crop.split(","))
        except ValueError:
            raise InputError(f"--crop: {crop!r}: expected four whole numbers L,T,R,B") from None
        box = (left, top, right, bottom)
    return Photo(pixel, scale, dark, flat, box, rotation_deg * deg)


def refuse_not_above_0(
    pitch_mm: float | None, pixel_mm: float | None, cd_m2_per_count: float
) -> None:
    """Refuse sizes and scales of a measurement that are not above 0."""
    from mpfcad.errors import InputError

    for name, value in (("--pitch-mm", pitch_mm), ("--pixel-mm", pixel_mm),
                        ("--cd-m2-per-count", cd_m2_per_count)):  # fmt: skip
        if value is not None and not 0 < value < math.inf:
            raise InputError(f"{name}: {value:g}: expected above 0")


def refuse_infinite(name: str, value: float | None) -> None:
    """Refuse nan and inf as an option's value."""
    from mpfcad.errors import InputError

    if value is not None and not math.isfinite(value):
        raise InputError(f"{name}: {value:g}: expected a finite number")


def unit_of(text: str | None) -> str | None:
    """Return the unit that `--unit` names."""
    from mpfcad.film import parse_units

    return None if text is None else parse_units(text)[0]


def _pair(text: str | None) -> tuple[float, float] | None:
    from mpfcad.errors import InputError

    if text is None:
        return None
    try:
        across, along = (float(part) for part in text.split(","))
        if not 0 < min(across, along) <= max(across, along) < math.inf:
            raise ValueError
    except ValueError:
        raise InputError(f"--cell-mm: {text!r}: expected X,Y above 0") from None
    return across, along


def _write(record: dict[str, Any], out: Path | None, page: Path | None) -> None:
    """Write record and page, each whole or not at all."""
    from mpfcad.boundary.out import asked_file
    from mpfcad.export import canonical_json
    from mpfcad.report.page.judge_page import write_judge_page

    if out is not None:
        with asked_file(out) as part:
            part.write_text(canonical_json(record), "utf-8")
    if page is not None:
        with asked_file(page) as part:
            write_judge_page(part, record)


def _print(record: dict[str, Any]) -> None:
    print(record["reading"])
    gate = record["gates"][0]
    low, high = gate["ci95"]
    print(f"{record['verdict']}: lamp-Mura contrast {gate['value']:.4f} [{low:.4f}, {high:.4f}], "
          f"expected at most {gate['limit']:g} (marginal {gate['marginal_limit']:g})")  # fmt: skip
    if record["kind"] == "stripes":
        said = " (found)" if record["pitch_found"] else ""
        print(f"lamp pitch {record['lamp_pitch_mm']:.5g} mm{said}, {record['pitches']} whole "
              f"pitches, a lamp at {record['lamp_at_mm']:.4g} mm")  # fmt: skip
    else:
        cell = record["cell"]
        print(f"{record['cells']} cells of {cell['across_mm']:.5g} x {cell['along_mm']:.5g} mm")
    for note in record.get("notes", ()):
        print(note)
    mean = record["mean_luminance_cd_m2"]
    print(f"mean luminance {mean['value']:.5g} cd/m2")
    if "against" in record:
        found = record["against"]
        noise = found["expected_rms"]
        print(f"against {found['name']}: luminance {found['luminance_ratio']:.4g} times, curves "
              f"differ by {found['residual_rms']:.4f} rms, noise {noise:.4f}")  # fmt: skip
