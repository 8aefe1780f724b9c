"""`mpfcad calibrate`: stylus traces of coupons -> curvatures, and a process calibration."""

import json as json_format
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mpfcad.cli.option import Json

if TYPE_CHECKING:
    from mpfcad.film import Groove, Interval, StylusFit

_HEADER = (
    f"{'file':<24}{'aperture':>9}{'curvature_per_mm [95 %]':>28}"
    f"{'fitted_curvature_per_mm [95 %]':>32}{'fill':>8}"
    f"{'rms_um':>9}{'fit_rms_um':>12}{'tilt_deg':>10}"
)


def command(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="FILE.csv…", help="Stylus traces x_um,z_um.", show_default=False),
    ] = None,
    aperture: Annotated[
        list[float] | None,
        typer.Option("--aperture", metavar="RATIO", help="Of the coupon, once a file, in order."),
    ] = None,
    coupons: Annotated[
        Path | None,
        typer.Option("--coupons", metavar="LIST.csv", help="file,aperture_ratio in FILE's place."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE.toml", help="Write a process calibration."),
    ] = None,
    pitch_um: Annotated[float, typer.Option("--pitch-um", min=1, help="Of the grooves.")] = 50.0,
    depth_um: Annotated[float, typer.Option("--depth-um", min=1, help="Of the grooves.")] = 25.0,
    widths: Annotated[int, typer.Option("--widths", min=2, help="Prism widths fitted.")] = 2,
    json: Json = False,
) -> int:
    """Find the curvature of printed grooves from stylus traces."""
    from mpfcad.errors import InputError
    from mpfcad.film import Coupon, Groove, fit_stylus_trace, read_stylus_trace, write_process
    from mpfcad.units import um

    rows = _read_coupons(files or [], aperture or [], coupons)
    if out is not None and any(ratio is None for _, ratio in rows):
        raise InputError("--out: an aperture ratio must be given for each file")
    groove = Groove(pitch_um * um, depth_um * um)
    traces = [read_stylus_trace(path, groove, widths) for path, _ in rows]
    fits = [fit_stylus_trace(trace, groove, prism_widths=widths) for trace in traces]
    if out is not None:
        write_process(
            out,
            [
                Coupon(ratio, fit.curvature.value, path.name)
                for (path, ratio), fit in zip(rows, fits, strict=True)
                if ratio is not None
            ],
            groove,
        )
    figures = [
        _figures(path, ratio, fit, groove) for (path, ratio), fit in zip(rows, fits, strict=True)
    ]
    if json:
        document = {"schema": 1, "prism_widths": widths, "traces": figures}
        print(json_format.dumps(document, indent=1, ensure_ascii=False))
    else:
        _print_table(figures, out)
    return 0


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
            f"--aperture: {len(aperture)} for {len(files)} files: allowed none or one a file"
        )
    else:
        ratios: list[float | None] = list(aperture) if aperture else [None] * len(files)
        rows = list(zip(files, ratios, strict=True))
    for path, ratio in rows:
        if ratio is not None and not 0 < ratio <= 1:
            raise InputError(f"{path}: aperture_ratio {ratio:g}: allowed above 0, up to 1")
    return rows


def _read_list(path: Path) -> list[tuple[Path, float | None]]:
    import csv

    from mpfcad.errors import InputError

    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None
    if not rows or rows[0] != ["file", "aperture_ratio"]:
        raise InputError(f"{path}: row 1: header: allowed 'file,aperture_ratio'")
    found: list[tuple[Path, float | None]] = []
    for number, row in enumerate(rows[1:], 2):
        try:
            name, ratio = row
            found.append((path.parent / name, float(ratio)))
        except ValueError:
            text = ",".join(row)
            raise InputError(
                f"{path}: row {number}: {text!r}: allowed a file and a number"
            ) from None
    if not found:
        raise InputError(f"{path}: no rows: allowed 1 or more")
    return found


def _figures(path: Path, ratio: float | None, fit: "StylusFit", groove: "Groove") -> dict[str, Any]:
    from mpfcad.units import deg, um

    fill = [float(groove.fill_fraction(c)) for c in _bounds(fit.curvature)]
    return {
        "file": str(path),
        "aperture_ratio": ratio,
        "curvature_per_mm": _entry(_bounds(fit.curvature)),
        "fitted_curvature_per_mm": _entry(_bounds(fit.fitted_curvature)),
        "fill_fraction": _entry([fill[0], fill[2], fill[1]]),
        "residual_rms_um": fit.residual_rms / um,
        "fitted_residual_rms_um": fit.fitted_residual_rms / um,
        "tilt_deg": fit.tilt / deg,
        "groove_centre_um": fit.centre / um,
        "points": len(fit.position),
    }


def _bounds(interval: "Interval") -> list[float]:
    return [interval.value, interval.low, interval.high]


def _entry(bounds: list[float]) -> dict[str, Any]:
    return {"value": bounds[0], "ci95": bounds[1:]}


def _print_table(figures: list[dict[str, Any]], out: Path | None) -> None:
    print(_HEADER)
    for row in figures:
        cells = []
        for name in ("curvature_per_mm", "fitted_curvature_per_mm"):
            low, high = row[name]["ci95"]
            cells.append(f"{row[name]['value']:.3f} [{low:.3f}, {high:.3f}]")
        ratio = "" if row["aperture_ratio"] is None else f"{row['aperture_ratio']:g}"
        print(
            f"{Path(row['file']).name:<24}{ratio:>9}{cells[0]:>28}{cells[1]:>32}"
            f"{row['fill_fraction']['value']:>8.4f}{row['residual_rms_um']:>9.4f}"
            f"{row['fitted_residual_rms_um']:>12.4f}{row['tilt_deg']:>10.3f}"
        )
    if out is not None:
        print(out)
