"""`mpfcad calibrate`: stylus traces of coupons -> curvatures, and a process calibration."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mpfcad.cli.character import print_json
from mpfcad.cli.measure.calibration import print_calibration, write_calibration
from mpfcad.cli.option import Json

if TYPE_CHECKING:
    from mpfcad.film import Coupon, Groove, Interval, ReadingOption, StylusFit, StylusTrace

_HEADER = (
    f"{'file':<24}{'aperture':>9}{'curvature_per_mm [95 %]':>28}"
    f"{'fitted_curvature_per_mm [95 %]':>32}{'fill [95 %]':>26}"
    f"{'rms_um':>9}{'fit_rms_um':>12}{'tilt_deg':>10}"
)


def command(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="FILE…", help="Stylus traces, as the instrument wrote them.", show_default=False
        ),
    ] = None,
    aperture: Annotated[
        list[float] | None,
        typer.Option(
            "--aperture",
            metavar="RATIO",
            help="Aperture ratio of the coupon; once a file, in order.",
        ),
    ] = None,
    coupons: Annotated[
        Path | None,
        typer.Option(
            "--coupons",
            metavar="LIST.csv",
            help="Table file,aperture_ratio in place of FILE and --aperture.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.toml", help="Write a process calibration."),
    ] = None,
    pitch_um: Annotated[
        float, typer.Option("--pitch-um", min=1, help="Pitch of the grooves.")
    ] = 50.0,
    depth_um: Annotated[
        float, typer.Option("--depth-um", min=1, help="Depth of the grooves.")
    ] = 25.0,
    unit: Annotated[
        str | None,
        typer.Option(
            "--unit",
            metavar="X[,Z]",
            help="Unit of the columns: um, mm, nm, A, m, cm, in, mil or uin [default: the file's].",
        ),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(
            "--columns",
            metavar="X,Z",
            help="Numbers of the columns, from 1 [default: by their names].",
        ),
    ] = None,
    tip_radius_um: Annotated[
        str | None,
        typer.Option(
            "--tip-radius-um",
            metavar="R[±D]",
            help="Radius of the stylus's tip, and how far off it may be [default: the file's].",
        ),
    ] = None,
    tip_angle_deg: Annotated[
        float | None,
        typer.Option(
            "--tip-angle-deg", metavar="A", help="Full angle of the tip's cone [default: 60]."
        ),
    ] = None,
    correct: Annotated[
        bool,
        typer.Option("--correct", help="Correct sign and scale of the heights by pitch and depth."),
    ] = False,
    upright: Annotated[
        bool,
        typer.Option("--upright", help="The heights are known to have the tips up: do not ask."),
    ] = False,
    model: Annotated[
        str,
        typer.Option("--model", help="Kind of calibration: tone (curve with intervals) or table."),
    ] = "tone",
    mesh: Annotated[
        str | None,
        typer.Option(
            "--mesh",
            metavar="NAME",
            help="Mesh that the coupons were printed through, such as 180-27.",
        ),
    ] = None,
    emulsion_um: Annotated[
        float, typer.Option("--emulsion-um", min=0, help="Emulsion below that mesh.")
    ] = 0.0,
    solids: Annotated[
        float,
        typer.Option("--solids", help="Solids fraction of the resin that was printed: 0 … 1."),
    ] = 1.0,
    widths: Annotated[
        int | None,
        typer.Option(
            "--widths",
            min=2,
            metavar="N",
            help="Number of prism widths to fit [default: all, up to 40].",
        ),
    ] = None,
    json: Json = False,
) -> int:
    """Find the curvature of printed grooves from stylus traces."""
    from mpfcad.boundary.out import check_out
    from mpfcad.errors import InputError
    from mpfcad.film import Groove, fit_stylus_trace, read_stylus_trace
    from mpfcad.film.process.write import CALIBRATED
    from mpfcad.units import um

    rows = _read_coupons(files or [], aperture or [], coupons)
    if out is not None and any(ratio is None for _, ratio in rows):
        raise InputError("--out: expected an --aperture for each file")
    check_out("--out", out, (CALIBRATED.encode(),))
    groove = Groove(pitch_um * um, depth_um * um)
    option = _option(unit, columns, tip_radius_um, tip_angle_deg, correct, upright)
    traces = [read_stylus_trace(path, groove, widths or 2, option) for path, _ in rows]
    fits = [
        fit_stylus_trace(trace, groove, prism_widths=widths, correct=correct) for trace in traces
    ]
    if out is not None:
        prints = [
            _coupon(ratio, path.name, fit.fill_fraction, groove)
            for (path, ratio), fit in zip(rows, fits, strict=True)
            if ratio is not None
        ]
        found = write_calibration(out, prints, groove, model, mesh, emulsion_um, solids)
    figures = [
        _figures(path, ratio, trace, fit, groove)
        for (path, ratio), trace, fit in zip(rows, traces, fits, strict=True)
    ]
    if json:
        document = {"schema": 1, "traces": figures}
        if out is not None:
            document["process"] = found
        print_json(document)
    else:
        _print_table(figures)
        if out is not None:
            print_calibration(found)
            print(out)
    return 0


def _option(
    unit: str | None,
    columns: str | None,
    tip_radius_um: str | None,
    tip_angle_deg: float | None,
    correct: bool,
    upright: bool,
) -> "ReadingOption":
    """Return what the user states over what the files say."""
    from mpfcad.errors import InputError
    from mpfcad.film import ReadingOption, StylusTip, parse_columns, parse_units
    from mpfcad.film.stylus.tip import parse_radius
    from mpfcad.units import deg

    tip = None
    if tip_angle_deg is not None and tip_radius_um is None:
        raise InputError("--tip-angle-deg: without --tip-radius-um: expected both")
    if tip_radius_um is not None:
        tip_radius, off = parse_radius(tip_radius_um)
        angle = 60.0 if tip_angle_deg is None else tip_angle_deg
        if not 10 <= angle <= 150:
            raise InputError(f"--tip-angle-deg: {angle:g}: expected 10 … 150")
        tip = StylusTip(tip_radius, angle * deg, off)
    return ReadingOption(
        parse_units(unit) if unit else None, parse_columns(columns) if columns else None,
        correct, tip, upright,
    )  # fmt: skip


def _read_coupons(
    files: list[Path], aperture: list[float], coupons: Path | None
) -> list[tuple[Path, float | None]]:
    """Return the traces and their aperture ratios, from the arguments or from a list."""
    from mpfcad.errors import InputError

    if (coupons is None) == (not files):
        raise InputError("FILE.csv: give either traces or --coupons LIST.csv")
    if coupons is not None:
        if aperture:
            raise InputError("--aperture: the list of --coupons has its own aperture ratios")
        rows = _read_list(coupons)
    elif aperture and len(aperture) != len(files):
        raise InputError(
            f"--aperture: {len(aperture)} for {len(files)} files: expected none or one a file"
        )
    else:
        ratios: list[float | None] = list(aperture) if aperture else [None] * len(files)
        rows = list(zip(files, ratios, strict=True))
        for ratio in aperture:
            _refuse_ratio("--aperture", ratio)
    return rows


def _refuse_ratio(where: str, ratio: float) -> None:
    from mpfcad.errors import InputError

    if not 0 < ratio <= 1:
        raise InputError(f"{where}: {ratio:g}: expected above 0, up to 1")


def _read_list(path: Path) -> list[tuple[Path, float | None]]:
    import csv

    from mpfcad.boundary import TEXT_LIMIT, check_file, guarded
    from mpfcad.errors import InputError

    expected = "a table of coupons"
    check_file(path, TEXT_LIMIT, expected)
    with guarded(path, expected), path.open(encoding="utf-8-sig") as file:
        rows = [row for row in csv.reader(file) if row]
    if not rows or rows[0] != ["file", "aperture_ratio"]:
        raise InputError(f"{path}: row 1: header: expected 'file,aperture_ratio'")
    found: list[tuple[Path, float | None]] = []
    for number, row in enumerate(rows[1:], 2):
        try:
            name, text = row
            ratio = float(text)
        except ValueError:
            text = ",".join(row)
            raise InputError(
                f"{path}: row {number}: {text!r}: expected a file and a number"
            ) from None
        _refuse_ratio(f"{path}: row {number}: aperture_ratio", ratio)
        found.append((path.parent / name, ratio))
    if not found:
        raise InputError(f"{path}: no rows: expected 1 or more")
    return found


def _figures(
    path: Path, ratio: float | None, trace: "StylusTrace", fit: "StylusFit", groove: "Groove"
) -> dict[str, Any]:
    from mpfcad.units import deg, um

    return {
        "file": str(path),
        "reading": trace.reading,
        "aperture_ratio": ratio,
        "curvature_per_mm": _entry(_bounds(fit.curvature)),
        "fitted_curvature_per_mm": _entry(_bounds(fit.fitted_curvature)),
        "fill_fraction": _entry(_bounds(fit.fill_fraction)),
        "residual_rms_um": fit.residual_rms / um,
        "fitted_residual_rms_um": fit.fitted_residual_rms / um,
        "tilt_deg": fit.tilt / deg,
        "groove_centre_um": fit.centre / um,
        "pitch_um": fit.pitch / um,
        "depth_um": fit.depth / um,
        "tip_radius_um": None if fit.tip is None else fit.tip.radius / um,
        "prism_widths": fit.grooves,
        "points": len(fit.position),
        "meniscus": _meniscus(fit),
        "notes": list(fit.notes),
    }


def _meniscus(fit: "StylusFit") -> dict[str, Any] | None:
    """Return the shape that was found, in figures and in words."""
    from mpfcad.units import deg, um

    shape = fit.meniscus
    if shape is None:
        return None
    below, angle = _bounds(shape.below_tips), _bounds(shape.wall_angle)
    return {
        "below_tips_um": _entry([value / um for value in below]),
        "wall_angle_deg": _entry([value / deg for value in angle]),
        "roundness": _entry(_bounds(shape.roundness)),
        "flatness": _entry(_bounds(shape.flatness)),
        "parabola_through_tips": shape.through_tips,
        "words": shape.words,
    }


def _coupon(ratio: float, name: str, fill: "Interval", groove: "Groove") -> "Coupon":
    """Return a coupon by its fill, under the names that curvatures of the stated groove give it."""
    from mpfcad.film import Coupon

    value, low, high = (
        float(groove.curvature_of_fill(f)) for f in (fill.value, fill.high, fill.low)
    )
    return Coupon(ratio, value, name, low, high)


def _bounds(interval: "Interval") -> list[float]:
    return [interval.value, interval.low, interval.high]


def _entry(bounds: list[float]) -> dict[str, Any]:
    return {"value": bounds[0], "ci95": bounds[1:]}


def _print_table(figures: list[dict[str, Any]]) -> None:
    for row in figures:
        print(row["reading"])
    print(_HEADER)
    for row in figures:
        cells = []
        for name in ("curvature_per_mm", "fitted_curvature_per_mm"):
            low, high = row[name]["ci95"]
            cells.append(f"{row[name]['value']:.3f} [{low:.3f}, {high:.3f}]")
        low, high = row["fill_fraction"]["ci95"]
        fill = f"{row['fill_fraction']['value']:.4f} [{low:.4f}, {high:.4f}]"
        ratio = "" if row["aperture_ratio"] is None else f"{row['aperture_ratio']:g}"
        print(
            f"{Path(row['file']).name:<24}{ratio:>9}{cells[0]:>28}{cells[1]:>32}"
            f"{fill:>26}{row['residual_rms_um']:>9.4f}"
            f"{row['fitted_residual_rms_um']:>12.4f}{row['tilt_deg']:>10.3f}"
        )
    for row in figures:
        if row["meniscus"]:
            print(f"{Path(row['file']).name}: {row['meniscus']['words']}")
    _print_notes(figures)


def _print_notes(figures: list[dict[str, Any]]) -> None:
    """Print each note once, with the files that it is about."""
    files: dict[str, list[str]] = {}
    for row in figures:
        for note in row["notes"]:
            files.setdefault(note, []).append(Path(row["file"]).name)
    for note, names in files.items():
        every = len(names) == len(figures) > 1
        print(f"{f'all {len(names)} files' if every else ', '.join(names)}: {note}")
