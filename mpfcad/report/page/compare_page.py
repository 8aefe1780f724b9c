"""The page of `mpfcad compare`: the summary table and the curves over each other."""

from itertools import cycle
from pathlib import Path
from typing import Any

from mpfcad.report.drawing.angle_figure import angular_overlay, pitch_figure
from mpfcad.report.drawing.plot import Plot, plot
from mpfcad.report.page.environment import render
from mpfcad.report.page.led_compare_page import build_led_compare_page
from mpfcad.report.page.number import with_error, with_interval

Record = dict[str, Any]
#: Colours that stay apart for most colour-blind readers (Okabe and Ito, "Color universal design").
_COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")


def write_compare_page(path: Path, record: Record) -> None:
    """Write the page; the same record gives the same bytes."""
    cases = record["cases"]
    if "cell" in cases[0]["contrast"]:
        path.write_bytes(build_led_compare_page(record).encode())
        return
    dressed = list(zip(cases, cycle(_COLOURS), strict=False))
    curves = [(case["label"], case["contrast"], colour) for case, colour in dressed]
    page = render(
        "compare.html.j2",
        name="Comparison",
        kind="films and stacks",
        head=f"{len(cases)} cases, seed {record['seed']}, effort {record['effort']}.",
        cases=[_summary(case) for case in cases],
        likely="confidence" in cases[0],
        pitch=plot(pitch_figure(curves), "pitch"),
        angles=[(axis, _angles(dressed, axis)) for axis in ("horizontal", "vertical")],
        rows=_rows(cases),
    )
    path.write_bytes(page.encode())


def plane(case: Record, axis: str) -> str:
    """Return the plane, `across` or `along` the lamps, that is `horizontal` or `vertical`."""
    return next(key for key, name in case["screen"]["axes"].items() if name == axis)


def _summary(case: Record) -> Record:
    contrast = case["contrast"]["lamp_mura_contrast"]
    low, high = contrast["ci95"]
    film, _, stack = case["label"].partition(" in ")
    return {
        "film": film,
        "stack": stack,
        "contrast": f"{contrast['value']:.4f}",
        "interval": f"{low:.4f} … {high:.4f}",
        "figures": [
            _pair(case["relative_luminance"], 3),
            _pair(case["angular"][plane(case, "horizontal")]["fwhm_deg"], 1),
            _pair(case["angular"][plane(case, "vertical")]["fwhm_deg"], 1),
            _pair(case["relative_efficiency"], 3),
            str(case["sheet_count"]),
            *_likely(case),
        ],
    }


def _likely(case: Record) -> list[str]:
    """Return how likely a case is accepted; nothing where that was not asked."""
    if "confidence" not in case:
        return []
    found = case["confidence"]
    low, high = found["contrast"]["ci95"]
    words = [with_interval(found["probability"]["marginal"], 2), f"contrast {low:.4f} … {high:.4f}"]
    words += [f"most by {one['name']}" for one in found["inputs"][:1]]
    return [", ".join(words)]


def _pair(estimate: Record | None, decimals: int) -> str:
    if estimate is None:
        return "above 160"
    if estimate["standard_error"] == 0:
        return f"{estimate['value']:g}"
    return f"{estimate['value']:.{decimals}f} ± {estimate['standard_error']:.{decimals}f}"


def _angles(dressed: list[tuple[Record, str]], axis: str) -> Plot:
    curves = [
        (case["label"], case["angular"][plane(case, axis)], colour) for case, colour in dressed
    ]
    return plot(angular_overlay(curves), axis)


def _rows(cases: list[Record]) -> list[tuple[str, list[str]]]:
    """Return a row for each figure that all cases have."""

    def row(label: str, *path: str) -> tuple[str, list[str]]:
        cells = []
        for case in cases:
            entry: Any = case
            for key in path:
                entry = entry[plane(case, key) if key in ("horizontal", "vertical") else key]
            cells.append(_cell(entry))
        return label, cells

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
    return str(entry) if isinstance(entry, int) else with_error(entry, 5)
