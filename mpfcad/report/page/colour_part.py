"""The part of a measurement's page on colour."""

from typing import Any

from mpfcad.report.drawing.colour_figure import (
    colour_angle_figure,
    colour_cell_figure,
    colour_pitch_figure,
)
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.number import number

Record = dict[str, Any]


def colour_part(found: Record, inputs: list[Record], axes: dict[str, str] | None = None) -> Record:
    """Return the figures, plots and notes on colour; `axes`: how the cuts over direction lie."""
    mean, is_cell = found["mean"], len(set(found["over_screen"]["y_mm"])) > 1
    rows = [
        ("colour Mura: largest Δu′v′ from the mean", found["colour_mura"], 3),
        ("mean x", mean["x"], 5),
        ("mean y", mean["y"], 5),
        ("mean u′", mean["u_prime"], 5),
        ("mean v′", mean["v_prime"], 5),
        ("mean normal luminance Y [cd/m²]", mean["luminance_cd_m2"], 5),
    ]
    bands = found["bands"]
    figure = colour_cell_figure(found) if is_cell else colour_pitch_figure(found)
    part = {
        "rows": [(*row, "–") for row in rows],
        "is_cell": is_cell,
        "plot": plot(figure, "colour"),
        "paths": found["paths"],
        "bands": [
            (f"{wavelength:g}", number(share * 100, 3))
            for wavelength, share in zip(bands["wavelength_nm"], bands["power_share"], strict=True)
        ],
        "said": [
            one["source"]
            for one in inputs
            if one["name"].removeprefix("stack.") in ("light.flat", "light.dispersion")
        ],
    }
    angled = axes is not None and "over_angle" in found
    part["angle"] = plot(colour_angle_figure(found, axes or {}), "colour-angle") if angled else None
    return part
