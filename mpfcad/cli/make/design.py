"""`mpfcad design`: find the curvature map for a backlight, and verify it."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from mpfcad.cli.option import Out, Threads, TraceEffort


def command(
    design_file: Annotated[
        Path, typer.Argument(metavar="DESIGN.toml", help="The design.", show_default=False)
    ],
    out: Out = None,
    effort: TraceEffort = None,
    threads: Threads = None,
    verify: Annotated[
        bool, typer.Option("--verify/--no-verify", help="Run the job that was found.")
    ] = True,
) -> int:
    """Find the curvature map for a backlight; write its job and verify it."""
    from mpfcad.cli.likely import print_both
    from mpfcad.cli.make import run
    from mpfcad.cli.terminal import Terminal
    from mpfcad.job.design import read_design
    from mpfcad.job.led_design import is_led_design
    from mpfcad.pipeline import default_design_out, run_design
    from mpfcad.report import range_words

    if is_led_design(design_file):
        return _led(design_file, out, effort, threads)
    design = read_design(design_file)
    folder = out or default_design_out(design)
    with Terminal() as terminal:
        job_file = run_design(design, design_file, folder, threads=threads, progress=terminal)
    record = json.loads((folder / "design.json").read_bytes())
    for sentence in range_words(record["thickness"]) if record["thickness"] else ():
        print(sentence)
    if record["confidence"] is not None:
        print_both(record["confidence"])
    print(f"{job_file}\n{folder / 'design.html'}")
    if not verify:
        return 0
    verified = folder.with_name(design.name)
    if verified == folder:
        verified = folder.with_name(f"{design.name}-run")
    return run.command(job_file, verified, effort, threads)


def _led(design_file: Path, out: Path | None, effort: TraceEffort, threads: Threads) -> int:
    """Find printed films for LEDs and print what they give."""
    from mpfcad.cli.terminal import Terminal
    from mpfcad.job.led_design import read_led_design
    from mpfcad.pipeline.led.design import run_led_design

    design = read_led_design(design_file)
    folder = out or Path("exports") / f"{design.name}-design"
    chosen = "standard" if effort is None else effort.value
    with Terminal() as terminal:
        record = run_led_design(
            design, design_file, folder, effort=chosen, threads=threads, progress=terminal
        )
    _print_led(record, folder)
    return 0


def _print_led(record: dict[str, Any], folder: Path) -> None:
    """Print the films that a design for LEDs has tried and found."""
    from mpfcad.report.page.led_page import departure_words, pilot_lines, range_lines

    for line in range_lines(record["range"]):
        print(line)
    for one in record["tried"]:
        low, high = one["lamp_mura_contrast"]["ci95"]
        mean = one["series_per_mm"][0][0]
        print(f"tried C = {mean:.4g} /mm: {one['lamp_mura_contrast']['value']:.4f} "
              f"[{low:.4f}, {high:.4f}]")  # fmt: skip
    for line in pilot_lines(record["pilot"]):
        print(line)
    for film in record["films"]:
        resin = ""
        if film["fill_min"] is not None:
            resin = f" fill {film['fill_min']:.2%} … {film['fill_max']:.2%},"
        print(
            f"film {film['size_mm'][0]:g} × {film['size_mm'][1]:g} mm: C "
            f"{film['curvature_min_per_mm']:.4g} … {film['curvature_max_per_mm']:.4g} /mm,{resin} "
            f"{film['pieces']} pieces"
        )
    found = record["found"]["lamp_mura_contrast"]
    low, high = found["ci95"]
    print(
        f"H:P {record['height_over_pitch']:.3f}, the plate counted; traced from the files: "
        f"lamp_mura_contrast {found['value']:.4f} [{low:.4f}, {high:.4f}]"
    )
    least = record["model_least"]["lamp_mura_contrast"]
    print(
        f"linear model of the last traces: no map of this mean within the limits below {least:.4f}"
    )
    if record["mould"] is not None:  # what a halftone's traces tell is no mould's
        print(f"a mould, C from 20 /mm on: {record['mould']['lamp_mura_contrast']:.4f}, same model")
    for number, one in enumerate(record.get("halftone", []), 1):
        print(f"film {number}: {one['words']}")
    print(record["printing"]["words"])
    for one in record["bears"]:
        low, high = one["lamp_mura_contrast"]["ci95"]
        print(
            f"with {departure_words(one['departure'])}: {one['lamp_mura_contrast']['value']:.4f} "
            f"[{low:.4f}, {high:.4f}]"
        )
    print(folder)
