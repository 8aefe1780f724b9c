"""The page of `mpfcad measure`: every figure that was asked for, with its standard error."""

from base64 import b64encode
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.report.drawing.angle_figure import (
    angular_figure,
    conoscope_figure,
    panel_figure,
    pitch_figure,
)
from mpfcad.report.drawing.figure import (
    BASE_COLOUR,
    FILM_COLOUR,
    PRINT_SCRIPT,
    figure_html,
    plotly_script,
)
from mpfcad.report.drawing.picture import PICTURES, band_width
from mpfcad.report.page.style import STYLE
from mpfcad.report.page.table import figure, short, table

Record = dict[str, Any]
_HEAD = ("", "value", "standard error", "95 % interval")


def write_measure_page(path: Path, record: Record) -> None:
    """Write the page; the same record and pictures give the same bytes."""
    sections = [
        f"<section><h2>{title}</h2>{make(record, path.parent)}</section>"
        for name, (title, make) in _SECTIONS.items()
        if name in record
    ]
    traced = record["traced"]
    head = (
        f"{escape(traced['film'])} in {escape(traced['stack'])}: {escape(traced['title'])}. Seed "
        f"{traced['seed']}, effort {traced['effort']}."
    )
    path.write_bytes(html_page(record["name"], "measured luminance", head, "".join(sections)))


def html_page(name: str, kind: str, head: str, body: str) -> bytes:
    """Return a whole page that needs no network."""
    return (
        '<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(name)}: {kind}</title><style>{STYLE}</style>"
        f"<script>{plotly_script()}</script></head><body><main>"
        f'<h1>{escape(name)}: {kind}</h1><p class="sub">{head}</p>{body}'
        "<footer>Every figure is a Monte-Carlo estimate with its standard error; lengths in mm, "
        "angles in degrees, luminance in cd/m².</footer></main>"
        f"<script>{PRINT_SCRIPT}</script></body></html>\n"
    ).encode()


def estimate_row(label: str, estimate: Record | None, digits: int = 4, none: str = "–") -> list:
    """Return the cells of one figure: what, value, standard error, interval."""
    if estimate is None:
        return [label, none, "", ""]
    low, high = estimate["ci95"]
    return [
        label,
        short(estimate["value"], digits),
        short(estimate["standard_error"], 2),
        f"{short(low, digits)} … {short(high, digits)}",
    ]


def _contrast(record: Record, folder: Path) -> str:
    found, base = record["contrast"], record.get("baseline", {}).get("contrast")
    curves = [(record["name"], found, FILM_COLOUR)]
    curves += [("conventional", base, BASE_COLOUR)] if base else []
    rows = [
        ("lamp-Mura contrast (L<sub>max</sub> − L<sub>min</sub>)/(L<sub>max</sub> + L<sub>min"
         "</sub>), fitted curve", found["lamp_mura_contrast"], 3),
        ("the same on 33 points", found["lamp_mura_contrast_33_points"], 3),
        ("the same on 9 points", found["lamp_mura_contrast_9_points"], 3),
        ("σ / mean", found["sigma_over_mean"], 3),
        *((f"harmonic {i} of the pitch / mean", amplitude, 3)
          for i, amplitude in enumerate(found["harmonic_amplitude"], 1)),
        ("mean normal luminance [cd/m²]", found["mean_luminance_cd_m2"], 5),
        ("normal luminance above a lamp [cd/m²]", found["luminance_above_lamp_cd_m2"], 5),
        ("normal luminance between lamps [cd/m²]", found["luminance_between_lamps_cd_m2"], 5),
    ]  # fmt: skip
    if "relative_luminance" in record:
        rows.append(
            ("mean normal luminance / conventional", record["relative_luminance"], 4)
        )  # fmt: skip
    return figure(
        figure_html(pitch_figure(curves), "pitch"),
        "33 points over one lamp pitch, seen along the normal, with 95 % bars; the line is the "
        "Fourier series that every figure below is read from, free of the noise's own contrast. "
        f"{short(found['paths'])} paths.",
    ) + table(_HEAD, (estimate_row(*row) for row in rows), numeric=(1, 2, 3))


def _angular(record: Record, folder: Path) -> str:
    angular, axes = record["angular"], record["screen"]["axes"]
    rows = []
    for plane in ("along", "across"):
        label = f"{axes[plane]} ({plane} the lamps)"
        curve, beyond = angular[plane], "above 160"
        rows.append(
            estimate_row(
                f"{label}: full width at half of the peak [°]", curve["fwhm_deg"], 4, beyond
            )
        )
        rows.append(
            estimate_row(
                f"{label}: full width at a third of the normal luminance [°]",
                curve["third_of_normal_width_deg"],
                4,
                beyond,
            )
        )
    return figure(
        figure_html(angular_figure(angular, axes), "angular"),
        "Luminance over the viewing angle, averaged over a lamp pitch, with 95 % bars. "
        f"{short(angular['paths'])} paths.",
    ) + table(_HEAD, rows, numeric=(1, 2, 3))


def _conoscope(record: Record, folder: Path) -> str:
    found = record["conoscope"]
    return figure(
        figure_html(conoscope_figure(found, record["screen"]["lamps_level"]), "conoscope"),
        "Luminance over the viewing direction as the screen's viewer sees it, 0 to 80° from the "
        "normal, averaged over a lamp pitch: traced every 5° and 15° of azimuth, straight between. "
        f"{short(found['paths'])} paths; standard error of a direction "
        f"{short(_largest(found), 2)} cd/m² at most.",
    )


def _largest(conoscope: Record) -> float:
    return max(max(row) for row in conoscope["standard_error_cd_m2"])


def _flux(record: Record, folder: Path) -> str:
    found = record["flux"]
    rows = [
        ("efficiency: flux out / flux that the lamps emit [lm/lm]", found["efficiency_lm_per_lm"]),
        ("efficiency / conventional", record.get("relative_efficiency")),
        ("flux out per area [lm/m²], traced from the lamps", found["exitance_lm_m2"]),
        ("the same, from the luminance over the hemisphere", found["exitance_backward_lm_m2"]),
        ("the same, from the conoscopic map",
         record.get("conoscope", {}).get("exitance_lm_m2")),
        ("flux out of the panel [lm]", found["flux_lm"]),
    ]  # fmt: skip
    rows = [estimate_row(label, value, 5) for label, value in rows if value is not None]
    return (
        table(_HEAD, rows, numeric=(1, 2, 3))
        + '<p class="note">Forward and backward traces share nothing but the scene: they differ by '
        f"{found['forward_minus_backward_sigma']:.1f} standard errors. "
        f"{record['screen']['rim']}</p>"
    )


def _uniformity(record: Record, folder: Path) -> str:
    found = record["uniformity"]
    rows = [
        estimate_row(f"δ = L<sub>min</sub>/L<sub>max</sub> on {count} points", value)
        for count, value in found["uniformity_min_over_max"].items()
    ]
    points = [
        (f"{u * 100:g} %", f"{v * 100:g} %", short(value, 5), short(error, 2))
        for (u, v), value, error in zip(
            found["point_share"], found["luminance_cd_m2"], found["standard_error_cd_m2"],
            strict=True,
        )
    ]  # fmt: skip
    return (
        table(_HEAD, rows, numeric=(1, 2, 3))
        + table(
            ("of the width, across the lamps", "of the length, along them", "L [cd/m²]",
             "standard error"),
            points, numeric=(0, 1, 2, 3),
        )
        + f'<p class="note">{record["screen"]["rim"]}</p>'
    )  # fmt: skip


def _camera(record: Record, folder: Path) -> str:
    found = record["camera"]
    shown = "".join(
        f'<img src="data:image/png;base64,{b64encode((folder / name).read_bytes()).decode()}" '
        f'alt="{name}" style="width:48%;margin-right:1%">'
        for name in PICTURES[:2]
    )
    mean = np.mean(found["luminance_cd_m2"])
    error = np.max(found["standard_error_cd_m2"]) / mean
    parts = len(found["luminance_cd_m2"][0])
    lines = "one traced value" if parts == 1 else f"{parts} traced values"
    edge = found["pixel_mm"] * len(found["luminance_cd_m2"])
    return figure(
        shown,
        f"The screen's middle, {edge:g} × {edge:g} mm, from straight above; pixels of "
        f"{found['pixel_mm']:g} mm. Left: black is 0, white 1.1 of the mean, as the eye sees it. "
        f"Right: bands of {band_width(found) * 100:g} % of the mean, at least two standard errors, "
        f"blue below and brown above. Nothing is "
        f"smoothed: every line along the lamps is {lines} with a standard error of up to "
        f"{error * 100:.2f} % ({short(found['paths'])} paths in all); camera.tif holds them in 16 "
        f"bits.",
    )


def _panel(record: Record, folder: Path) -> str:
    found = record["panel"]
    rows = [
        estimate_row(f"corner {name.replace('_', ', ')} / middle", corner)
        for name, corner in found["corner_over_middle"].items()
    ]
    return figure(
        figure_html(panel_figure(found, record["screen"]["lamps_level"]), "panel"),
        "Normal luminance of cells over the whole panel, each averaged over itself; standard error "
        f"of a cell {short(float(np.max(found['standard_error_cd_m2'])), 2)} cd/m² at most. "
        f"{short(found['paths'])} paths. {record['screen']['rim']}",
    ) + table(_HEAD, rows, numeric=(1, 2, 3))


_SECTIONS = {
    "contrast": ("Luminance over the lamp pitch", _contrast),
    "angular": ("Viewing angle", _angular),
    "conoscope": ("Conoscopic map", _conoscope),
    "flux": ("Flux and efficiency", _flux),
    "uniformity": ("Uniformity of the screen", _uniformity),
    "camera": ("Camera image", _camera),
    "panel": ("The whole panel", _panel),
}
