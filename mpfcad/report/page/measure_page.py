"""The page of `mpfcad measure`: every figure that was asked for, with its standard error."""

from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.report.drawing.angle_figure import (
    angular_figure,
    cell_figure,
    conoscope_figure,
    panel_figure,
    pitch_figure,
)
from mpfcad.report.drawing.figure import BASE_COLOUR, FILM_COLOUR
from mpfcad.report.drawing.picture import PICTURES, band_width
from mpfcad.report.drawing.plot import plot
from mpfcad.report.film.cell_section import way_words
from mpfcad.report.film.confidence_section import confidence_values
from mpfcad.report.page.colour_part import colour_part
from mpfcad.report.page.environment import render
from mpfcad.report.page.number import number
from mpfcad.report.page.spread_part import spread_values

Record = dict[str, Any]
#: A line of a table of estimates: what, the estimate, digits, words where there is none.
Row = tuple[str, Record | None, int, str]
_BEYOND = "above 160"
TITLES = {
    "contrast": "Luminance",
    "angular": "Viewing angle",
    "conoscope": "Conoscopic map",
    "flux": "Flux and efficiency",
    "uniformity": "Uniformity of the screen",
    "camera": "Camera image",
    "panel": "The whole panel",
    "polarisation": "Polarisation of the normal light",
    "psf": "The light of one LED, and of one zone",
    "colour": "Colour",
    "confidence": "Does the contrast hold in the real backlight?",
}


def write_measure_page(path: Path, record: Record) -> None:
    """Write the page; the same record and pictures give the same bytes."""
    traced = record["traced"]
    parts = [name for name in TITLES if name in record]
    head = (
        f"{traced['film']} in {traced['stack']}: {traced['title']}. Seed {traced['seed']}, "
        f"effort {traced['effort']}."
    )
    repeat = record["screen"]["repeat"]
    page = render(
        "measure.html.j2",
        name=record["name"],
        kind="measured luminance",
        head=head,
        record=record,
        parts=parts,
        titles=TITLES | {"contrast": f"Luminance over {repeat}"},
        repeat=repeat,
        **{name: _VALUES[name](record, path.parent) for name in parts},
    )
    path.write_bytes(page.encode())


def _contrast(record: Record, folder: Path) -> Record:
    found, base = record["contrast"], record.get("baseline", {}).get("contrast")
    if "cell" in found:
        return _cell(found)
    curves = [(record["name"], found, FILM_COLOUR)]
    curves += [("conventional", base, BASE_COLOUR)] if base else []
    rows = [
        ("lamp-Mura contrast (L_{max} − L_{min})/(L_{max} + L_{min}), fitted curve",
         found["lamp_mura_contrast"], 3),
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
        rows.append(("mean normal luminance / conventional", record["relative_luminance"], 4))
    return {
        "cell": False,
        "way": "",
        "plot": plot(pitch_figure(curves), "pitch"),
        "paths": found["paths"],
        "rows": _rows(rows),
    }


def _cell(found: Record) -> Record:
    """Return the figures of a cell of LEDs."""
    rows = [
        ("lamp-Mura contrast (L_{max} − L_{min})/(L_{max} + L_{min}) over the cell",
         found["lamp_mura_contrast"], 3),
        *((f"L_{{min}}/L_{{max}} on {count} points of the cell", points["min_over_max"], 4)
          for count, points in found["points"].items()),
        ("σ / mean", found["sigma_over_mean"], 3),
        *((f"harmonic {name.replace('_', ' ')} / mean", amplitude, 3)
          for name, amplitude in found["harmonic_amplitude"].items()),
        ("mean normal luminance [cd/m²]", found["mean_luminance_cd_m2"], 5),
        ("normal luminance above an LED [cd/m²]", found["luminance_above_led_cd_m2"], 5),
    ]  # fmt: skip
    return {
        "cell": True,
        "way": way_words(found),
        "plot": plot(cell_figure(found["cell"]), "cell"),
        "paths": found["paths"],
        "rows": _rows(rows),
    }


def _under_leds(record: Record) -> bool:
    return str(record["screen"]["repeat"]).startswith("the cell")


def _rows(rows: list[tuple[str, Record | None, int]], none: str = "–") -> list[Row]:
    return [(*row, none) for row in rows]


def _angular(record: Record, folder: Path) -> Record:
    angular, axes = record["angular"], record["screen"]["axes"]
    rows, beside = [], "grooves" if _under_leds(record) else "lamps"
    for plane in ("along", "across"):
        label, curve = f"{axes[plane]} ({plane} the {beside})", angular[plane]
        rows += [
            (f"{label}: full width at half of the peak [°]", curve["fwhm_deg"], 4),
            (f"{label}: full width at a third of the normal luminance [°]",
             curve["third_of_normal_width_deg"], 4),
        ]  # fmt: skip
    return {
        "plot": plot(angular_figure(angular, axes, beside), "angular"),
        "paths": angular["paths"],
        "rows": _rows(rows, _BEYOND),
    }


def _conoscope(record: Record, folder: Path) -> Record:
    found = record["conoscope"]
    figure = conoscope_figure(found, record["screen"]["lamps_level"])
    return {
        "plot": plot(figure, "conoscope"),
        "paths": found["paths"],
        "largest_error": float(np.max(found["standard_error_cd_m2"])),
    }


def _flux(record: Record, folder: Path) -> Record:
    found = record["flux"]
    sources = "LEDs" if _under_leds(record) else "lamps"
    rows = [
        (f"efficiency: flux out / flux that the {sources} emit [lm/lm]",
         found["efficiency_lm_per_lm"]),
        ("efficiency / conventional", record.get("relative_efficiency")),
        (f"flux out per area [lm/m²], traced from the {sources}", found["exitance_lm_m2"]),
        ("the same, from the luminance over the hemisphere", found["exitance_backward_lm_m2"]),
        ("the same, from the conoscopic map",
         record.get("conoscope", {}).get("exitance_lm_m2")),
        ("flux out of the panel [lm]", found["flux_lm"]),
    ]  # fmt: skip
    return {
        "rows": _rows([(label, value, 5) for label, value in rows if value is not None]),
        "difference_sigma": f"{found['forward_minus_backward_sigma']:.1f}",
    }


def _uniformity(record: Record, folder: Path) -> Record:
    found = record["uniformity"]
    rows = [
        (f"δ = L_{{min}}/L_{{max}} on {count} points", value, 4)
        for count, value in found["uniformity_min_over_max"].items()
    ]
    points = [
        (f"{u * 100:g} %", f"{v * 100:g} %", number(value, 5), number(error, 2))
        for (u, v), value, error in zip(
            found["point_share"], found["luminance_cd_m2"], found["standard_error_cd_m2"],
            strict=True,
        )
    ]  # fmt: skip
    return {"rows": _rows(rows), "points": points}


def _camera(record: Record, folder: Path) -> Record:
    found = record["camera"]
    error = np.max(found["standard_error_cd_m2"]) / np.mean(found["luminance_cd_m2"])
    parts = len(found["luminance_cd_m2"][0])
    cells = found.get("cells")
    across, along = found["pixel_mm"], found.get("pixel_along_mm", found["pixel_mm"])
    lines = len(found["luminance_cd_m2"]) * np.array(cells or (1, 1))
    values = "one traced value" if parts == 1 else f"{parts} traced values"
    words = f"every line along the lamps is {values}"
    if cells:
        words = f"the picture is {cells[0]} × {cells[1]} times the pixels of one cell, each traced,"
    return {
        "pictures": [
            (name, b64encode((folder / name).read_bytes()).decode()) for name in PICTURES[:2]
        ],
        "edges_mm": f"{across * lines[0]:.4g} × {along * lines[1]:.4g}",
        "pixel_mm": f"{across:.3g}",
        "band_percent": f"{band_width(found) * 100:g}",
        "words": words,
        "error_percent": f"{error * 100:.2f}",
        "paths": found["paths"],
    }


def _panel(record: Record, folder: Path) -> Record:
    found = record["panel"]
    rows = [
        (f"corner {name.replace('_', ', ')} / middle", corner, 4)
        for name, corner in found["corner_over_middle"].items()
    ]
    return {
        "plot": plot(panel_figure(found, record["screen"]["lamps_level"]), "panel"),
        "largest_error": float(np.max(found["standard_error_cd_m2"])),
        "paths": found["paths"],
        "rows": _rows(rows),
    }


def _polarisation(record: Record, folder: Path) -> Record:
    found = record["polarisation"]
    bands = found.get("by_band", {"wavelength_nm": [], "along_minus_across": []})
    rows = [
        ("normal luminance, all light [cd/m²]", found["luminance_cd_m2"], 5),
        ("degree of polarisation", found["degree_of_polarisation"], 3),
        ("Q/I: along the grooves less across them", found["along_minus_across"], 3),
        ("U/I: at 45° less at 135°", found["diagonal"], 3),
        ("V/I: of the two circles", found["circular"], 3),
        *((f"luminance behind an ideal polariser at {angle:g}° to the grooves [cd/m²]", one, 5)
          for angle, one in zip(found["polariser_angle_deg"], found["behind_polariser_cd_m2"],
                                strict=True)),
        *((f"Q/I of the power at {band:g} nm", one, 3)
          for band, one in zip(bands["wavelength_nm"], bands["along_minus_across"], strict=True)
          if one is not None),
    ]  # fmt: skip
    return {"rows": _rows(rows), "paths": found["paths"]}


def _psf(record: Record, folder: Path) -> Record:
    return spread_values(record["psf"])


def _colour(record: Record, folder: Path) -> Record:
    inputs, axes = record["traced"]["inputs"], record["screen"]["axes"]
    return colour_part(record["colour"], inputs, axes)


def _confidence(record: Record, folder: Path) -> Record | None:
    return confidence_values(record)


_VALUES = {
    "contrast": _contrast,
    "angular": _angular,
    "conoscope": _conoscope,
    "flux": _flux,
    "uniformity": _uniformity,
    "camera": _camera,
    "panel": _panel,
    "polarisation": _polarisation,
    "psf": _psf,
    "colour": _colour,
    "confidence": _confidence,
}
