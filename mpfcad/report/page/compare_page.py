"""The page of `mpfcad compare`: the summary table and the curves over each other."""

from html import escape
from pathlib import Path
from typing import Any

from mpfcad.report.drawing.angle_figure import angular_overlay, pitch_figure
from mpfcad.report.drawing.figure import figure_html
from mpfcad.report.page.measure_page import html_page
from mpfcad.report.page.table import figure, short, table

Record = dict[str, Any]
#: Colours that stay apart for most colour-blind readers (Okabe and Ito, "Color universal design").
_COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
_HEAD = (
    "film and stack",
    "lamp-Mura<br>contrast",
    "normal luminance<br>/ conventional",
    "viewing<br>angle H [°]",
    "viewing<br>angle V [°]",
    "efficiency<br>/ conventional",
    "sheets",
)


def write_compare_page(path: Path, record: Record) -> None:
    """Write the page; the same record gives the same bytes."""
    cases = record["cases"]
    colours = [_COLOURS[i % len(_COLOURS)] for i in range(len(cases))]
    dressed = list(zip(cases, colours, strict=True))
    curves = [(case["label"], case["contrast"], colour) for case, colour in dressed]
    body = (
        "<section><h2>Summary</h2>"
        + table(_HEAD, [_summary(case) for case in cases], numeric=range(1, 7))
        + '<p class="note">Value ± standard error; the contrast with its 95 % interval. Contrast: '
        "(L<sub>max</sub> − L<sub>min</sub>)/(L<sub>max</sub> + L<sub>min</sub>) over one lamp "
        "pitch, from the fitted curve. Normal luminance: mean over the pitch. Viewing angle: full "
        "width at half of the peak, H level and V upright on the screen. Efficiency: flux over all "
        "directions / flux that the lamps emit. Sheets: plate, diffuser sheets and films, "
        "each that is handled on its own.</p></section>"
        + "<section><h2>Luminance over the lamp pitch</h2>"
        + figure(
            figure_html(pitch_figure(curves), "pitch"),
            "Each curve over its own mean; points with 95 % bars, lines the fitted Fourier series.",
        )
        + "</section>"
        + "".join(_angles(dressed, axis) for axis in ("horizontal", "vertical"))
        + "<section><h2>All figures</h2>"
        + table(("", *map(_two_lines, cases)), _rows(cases),
                numeric=range(1, len(cases) + 1))
        + "</section>"
    )  # fmt: skip
    head = f"{len(cases)} cases, seed {record['seed']}, effort {record['effort']}."
    path.write_bytes(html_page("Comparison", "films and stacks", head, body))


def plane(case: Record, axis: str) -> str:
    """Return the plane, `across` or `along` the lamps, that is `horizontal` or `vertical`."""
    return next(key for key, name in case["screen"]["axes"].items() if name == axis)


def _summary(case: Record) -> list[Any]:
    low, high = case["contrast"]["lamp_mura_contrast"]["ci95"]
    value = case["contrast"]["lamp_mura_contrast"]["value"]
    return [
        ("nowrap", _two_lines(case)),
        f"{value:.4f}<br>{low:.4f} … {high:.4f}",
        _pair(case["relative_luminance"], 3),
        _pair(case["angular"][plane(case, "horizontal")]["fwhm_deg"], 1),
        _pair(case["angular"][plane(case, "vertical")]["fwhm_deg"], 1),
        _pair(case["relative_efficiency"], 3),
        str(case["sheet_count"]),
    ]


def _two_lines(case: Record) -> str:
    """Return film and stack, one under the other."""
    return escape(case["label"]).replace(" in ", "<br>in ", 1)


def _pair(estimate: Record | None, decimals: int) -> str:
    if estimate is None:
        return "above 160"
    if estimate["standard_error"] == 0:
        return f"{estimate['value']:g}"
    return f"{estimate['value']:.{decimals}f} ± {estimate['standard_error']:.{decimals}f}"


def _angles(dressed: list[tuple[Record, str]], axis: str) -> str:
    curves = [
        (case["label"], case["angular"][plane(case, axis)], colour) for case, colour in dressed
    ]
    return f"<section><h2>Luminance over the {axis} viewing angle</h2>" + figure(
        figure_html(angular_overlay(curves), axis),
        "Averaged over a lamp pitch; 95 % bars.",
    ) + "</section>"  # fmt: skip


def _rows(cases: list[Record]) -> list[list[Any]]:
    """Return a row for each figure that all cases have."""

    def row(label: str, *path: str) -> list[Any]:
        cells: list[Any] = [("nowrap", label)]
        for case in cases:
            entry: Any = case
            for key in path:
                entry = entry[plane(case, key) if key in ("horizontal", "vertical") else key]
            cells.append(_cell(entry))
        return cells

    return [
        row("lamp-Mura contrast", "contrast", "lamp_mura_contrast"),
        row("on 33 points", "contrast", "lamp_mura_contrast_33_points"),
        row("on 9 points", "contrast", "lamp_mura_contrast_9_points"),
        row("σ / mean", "contrast", "sigma_over_mean"),
        row("mean normal luminance [cd/m²]", "contrast", "mean_luminance_cd_m2"),
        row("above a lamp [cd/m²]", "contrast", "luminance_above_lamp_cd_m2"),
        row("between lamps [cd/m²]", "contrast", "luminance_between_lamps_cd_m2"),
        row("FWHM, horizontal [°]", "angular", "horizontal", "fwhm_deg"),
        row("FWHM, vertical [°]", "angular", "vertical", "fwhm_deg"),
        row("full width at 1/3 of normal, horizontal [°]", "angular", "horizontal",
            "third_of_normal_width_deg"),
        row("full width at 1/3 of normal, vertical [°]", "angular", "vertical",
            "third_of_normal_width_deg"),
        row("efficiency [lm/lm]", "flux", "efficiency_lm_per_lm"),
        row("flux out per area [lm/m²]", "flux", "exitance_lm_m2"),
        row("sheets", "sheet_count"),
    ]  # fmt: skip


def _cell(entry: Any) -> str:
    if entry is None:
        return "above 160"
    if isinstance(entry, int):
        return str(entry)
    return f"{short(entry['value'], 5)} ± {short(entry['standard_error'], 2)}"
