"""What the report shows of the mask: figures read back from its files, and pictures of one."""

from base64 import b64encode
from typing import Any

from mpfcad.report.drawing.film.levelling_figure import levelling_figure
from mpfcad.report.drawing.film.mask_drawing import draw_mask
from mpfcad.report.drawing.film.mask_zoom import mask_zoom
from mpfcad.report.drawing.plot import plot
from mpfcad.report.film.evidence import Evidence
from mpfcad.report.page.number import number

#: What is read back from each file: words, key of the record, digits.
_LINES = (
    ("aperture ratio, lowest", "aperture_ratio_min", 5),
    ("aperture ratio, highest", "aperture_ratio_max", 5),
    ("largest error of a groove's aperture ratio", "aperture_ratio_error_max", 3),
    ("apertures", "aperture_count", 4),
    ("smallest aperture [µm]", "smallest_aperture_um", 5),
    ("smallest web [µm]", "smallest_web_um", 5),
    ("width across the grooves [mm]", "width_mm", 7),
    ("length along the grooves [mm]", "length_mm", 7),
    ("database unit, or pixel [µm]", "database_unit_um", 3),
    ("an edge is off by up to [µm]", "snap_error_um", 3),
    ("largest error of a 1 mm square's ratio", "ratio_map_error_max", 3),
    ("windows checked with klayout", "window_count", 3),
    ("too narrow in them", "window_violations", 3),
)


def mask_values(record: dict[str, Any], evidence: Evidence) -> dict[str, Any]:
    """Return what the mask files hold and their pictures, or why there is no mask."""
    if record["mask"] is None and record["process"] is not None:
        return {"reason": "no file reads back as the one that was written"}
    if record["mask"] is None:
        return {"reason": evidence.kind.no_mask}
    files = record["mask"]["files"]
    names = list(files)
    rows = [
        [
            label,
            *("none" if files[n][key] is None else number(files[n][key], digits) for n in names),
        ]
        for label, key, digits in _LINES
    ]
    drawing, levelled = None, evidence.levelled
    if names[0].endswith((".oas", ".gds")):
        shown = evidence.shown_groove.items()
        windows = {title: evidence.first_groove + groove for title, groove in shown}
        file = evidence.folder / names[0]
        drawing = draw_mask(file, evidence.panel, windows, evidence.mask_period)
    return {
        "names": names,
        "rows": rows,
        "stated": files[names[0]]["text"][1],
        "pictures": [
            (name, b64encode((evidence.folder / name).read_bytes()).decode("ascii"))
            for name in ("mask.png", "mask-crossed.png")
            if (evidence.folder / name).is_file()
        ],
        "drawing": drawing,
        "zoom": mask_zoom(evidence.folder / names[0], evidence.panel.groove.pitch),
        "printing": _printing_rows(record.get("printing")),
        "levelled": levelled and plot(levelling_figure(levelled), "levelling"),
        "crossed": _printing_rows((record.get("crossed") or {}).get("printing")),
    }


def _printing_rows(printing: dict[str, Any] | None) -> list[tuple[str, Any]]:
    """Return what the screen does to the print."""
    if not printing:
        return []
    rows = [
        ("screen", printing["screen"]),
        ("of its mesh computed, not a weaver's figures", printing.get("mesh_computed") or "None"),
        ("share of the ink volume that leaves the screen", number(printing["release"], 3)),
        ("ripple of C after levelling [1/mm]", number(printing["ripple_curvature_per_mm"], 3)),
        ("ripple of luminance after levelling", number(printing["ripple_luminance"], 3)),
        (
            f"change of C by a print that lies {printing['registration_um']:g} µm off [1/mm]",
            number(printing["registration_curvature_per_mm"], 3),
        ),
        (
            "C is known to ± [1/mm], 95 %, by the process",
            number(printing["curvature_half_width_per_mm"], 2),
        ),
    ]
    return [(name, value) for name, value in rows if str(value) != "None"]
