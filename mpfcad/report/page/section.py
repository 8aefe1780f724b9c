"""The sections of the report, each a function of what was found."""

from base64 import b64encode
from html import escape
from typing import Any

from mpfcad.film import CellFilm, FieldPiece
from mpfcad.report.drawing.field_view import field_figure
from mpfcad.report.drawing.figure import figure_html, film_figure, luminance_figure
from mpfcad.report.drawing.mask_drawing import draw_mask
from mpfcad.report.drawing.stack_drawing import draw_stack
from mpfcad.report.page.evidence import Evidence
from mpfcad.report.page.table import fact_table, figure, short, table, with_interval
from mpfcad.report.page.wording import gate_row, verdict_words
from mpfcad.units import um

Record = dict[str, Any]


def verdict_section(record: Record) -> str:
    """Return the banner and a line a gate."""
    verdict = record["verdict"]
    banner = f'<div class="banner {verdict}"><b>{verdict}</b>{verdict_words(record)}</div>'
    head = ("gate", "formula", "value [95 % interval]", "limit", "outcome")
    rows = [gate_row(gate) for gate in record["gates"]]
    note = (
        '<p class="note">A gate with an interval is decided by the interval: PASS when all of it '
        "is within the limit, MARGINAL when all of it is within the marginal limit, FAIL when none "
        "of it is, INCONCLUSIVE otherwise. The verdict is the worst gate.</p>"
    )
    return banner + table(head, rows) + note


def traceability_section(record: Record) -> str:
    """Return hashes, versions, seed, command, and that the traced file is the shipped one."""
    provenance = record["provenance"]
    traced = provenance["traced"]
    shipped = provenance["sha256"][traced["file"]]
    same = "the same" if shipped == traced["sha256"] else "NOT the same"
    hashes = [
        (escape(n), f'<span class="hash">{h}</span>') for n, h in provenance["sha256"].items()
    ]
    inputs = [
        (escape(name), f'<span class="hash">{value}</span>')
        for name, value in provenance["inputs_sha256"].items()
    ]
    versions = ", ".join(f"{name} {value}" for name, value in provenance["versions"].items())
    return (
        f"<p>The ray tracer read <code>{traced['file']}</code> from disk with SHA-256 "
        f'<span class="hash">{traced["sha256"]}</span>; the file in this export has {same}. Its '
        "curvature was compared with that of the mask, read back from the mask file.</p>"
        f"<pre>{escape(provenance['command'])}</pre>"
        + "<h3>Files of this export (SHA-256)</h3>"
        + fact_table(hashes)
        + "<h3>Files it was made from (SHA-256)</h3>"
        + fact_table(inputs)
        + fact_table(
            [
                ("Seed", str(provenance["seed"])),
                ("Threads", escape(provenance["threads"])),
                ("Versions", escape(versions)),
            ]
        )
        + '<p class="note"><code>mpfcad verify</code> on this folder hashes every file and finds '
        "every figure again from the files, bit for bit.</p>"
    )


def input_section(record: Record, evidence: Evidence) -> str:
    """Return the drawing of the stack and every input with its tag."""
    rows = [
        [
            f"<code>{escape(entry['name'])}</code>",
            short(entry["value"], 6),
            f'<span class="tag {entry["tag"]}">{entry["tag"]}</span>',
            escape(str(entry["source"])),
        ]
        for entry in record["inputs"]
    ]
    drawing = figure(
        draw_stack(evidence.stack),
        "The stack across the lamps, from the reflector up to the viewer. Sheets and film are "
        "drawn thicker than they are.",
    )
    return drawing + table(("input", "value", "tag", "source"), rows)


def film_section(record: Record, evidence: Evidence) -> str:
    """Return curvature, fill and aperture over the piece."""
    piece = evidence.piece
    figures = film_figure(
        evidence.position,
        piece.curvature,
        piece.groove.fitted_curvature(piece.curvature, piece.profile),
        piece.fill_fraction,
        evidence.aperture_ratio,
        record["mask"] and next(iter(record["mask"]["curvature"]["recovered_per_mm"].values())),
    )
    if isinstance(evidence.drawn, CellFilm):
        return (
            f"<p>{evidence.drawn.shape.capitalize()}s of {piece.groove.pitch / um:g} µm in both "
            f"directions with C = {evidence.drawn.curvature:g} /mm. The printing process is "
            "calibrated for grooves, so this film has <b>no mask</b>.</p>"
        )
    if piece.profile == "ideal" and not isinstance(evidence.drawn, FieldPiece):
        words = (
            "<p>The profile is the pure parabola, also below the prism's walls. Resin can only be "
            "added, so this film cannot be printed and has <b>no mask</b>: it needs a mould.</p>"
        )
        figures = film_figure(evidence.position, piece.curvature, piece.curvature, [], None, None)
        return words + figure(figure_html(figures, "film"), "Curvature of each groove.")
    if isinstance(evidence.drawn, FieldPiece):
        return _field_words(record, evidence.drawn)
    caveats = "".join(f"<li>{escape(text)}</li>" for text in record["process"]["caveats"])
    limit = piece.groove.curvature_empty
    words = (
        f"<p>One curvature a groove, C = {piece.curvature.min():.4g} … "
        f"{piece.curvature.max():.4g} /mm over {piece.groove_count} grooves. The mask's aperture "
        f"ratio sets the fill, the fill sets the curvature. A groove of C = {limit:g} /mm is "
        f"empty; above that nothing can be printed.</p>"
        f"<p>Process: {escape(record['process']['source'])}</p><ul>{caveats}</ul>"
    )
    return words + figure(
        figure_html(figures, "film"),
        "C of z = z<sub>0</sub> + C/2 · x² through the tips, and the value a profiler's "
        "least-squares fit reports; fill = resin area / groove area; aperture ratio = open area / "
        "cell area, as read back from the mask file.",
    )


def _field_words(record: Record, film: FieldPiece) -> str:
    """Return what the curvature is over a piece where it varies along the grooves too."""
    low, high = film.curvature.min(), film.curvature.max()
    words = (
        f"<p>The curvature varies across and along the grooves: C = {low:.4g} … {high:.4g} /mm in "
        f"the piece of {film.groove_count} grooves, which lies {film.origin[0]:.6g} mm across and "
        f"{film.origin[1]:.6g} mm along from the panel's corner. "
    )
    if record["process"] is None:
        words += "The profile is the pure parabola, so there is <b>no mask</b>.</p>"
    else:
        caveats = "".join(f"<li>{escape(text)}</li>" for text in record["process"]["caveats"])
        words += f"</p><p>Process: {escape(record['process']['source'])}</p><ul>{caveats}</ul>"
    return words + figure(
        figure_html(field_figure(film), "film"),
        "C of z = z<sub>0</sub> + C/2 · x² through the tips, over the piece that is drawn.",
    )


def mask_section(record: Record, evidence: Evidence) -> str:
    """Return what the mask files hold, and a window of one."""
    if record["mask"] is None:
        cells = isinstance(evidence.drawn, CellFilm)
        reason = "cells have no printing process" if cells else "an ideal film cannot be printed"
        return f"<p>No mask: {reason}.</p>"
    files = record["mask"]["files"]
    names = list(files)
    lines = (
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
    rows = [
        [label, *("none" if files[n][key] is None else short(files[n][key], digits) for n in names)]
        for label, key, digits in lines
    ]
    shown = evidence.shown_groove.items()
    windows = {title: evidence.first_groove + groove for title, groove in shown}
    drawing = ""
    if names[0].endswith((".oas", ".gds")):
        picture = evidence.folder / names[0]
        drawing = figure(
            draw_mask(picture, evidence.panel, windows, evidence.mask_period),
            "Drawn from the file: blue is drawn, the lines are the prisms' tips.",
        )
    stated = escape(files[names[0]]["text"][1])
    difference = short(record["mask"]["curvature"]["difference_max_per_mm"], 3)
    words = (
        f"<p>On the artwork: <b>{stated}</b>. The curvature that the mask files give through the "
        f"process differs from the wanted one by {difference} /mm at most, over all grooves of the "
        f"panel and all files.</p>"
    )
    picture = b64encode((evidence.folder / "mask.png").read_bytes()).decode("ascii")
    preview = f'<img src="data:image/png;base64,{picture}" alt="The mask" style="max-width:100%">'
    return (
        words
        + table(("read back from", *names), rows, numeric=range(1, len(names) + 1))
        + figure(preview, "mask.png, drawn from the file: the whole panel's aperture ratio.")
        + drawing
    )


def _energy_rows(here: dict[str, Any], there: dict[str, Any], prefix: str = "") -> list[list[str]]:
    """Return the rows of two energy balances, those of each element among them."""
    rows: list[list[str]] = []
    for key in dict.fromkeys([*here, *there]):
        label = prefix + key.replace("_", " ")
        pair = (here.get(key, "–"), there.get(key, "–"))
        if isinstance(pair[0], dict):
            rows += _energy_rows(*pair, prefix=label + " ")
        else:
            rows.append([escape(label), short(pair[0], 5), short(pair[1], 5)])
    return rows


def luminance_section(record: Record) -> str:
    """Return luminance over the pitch, against the conventional stack, and the energy balance."""
    base = record["baseline"]
    head = ("", "lamp-Mura contrast", "mean normal luminance [cd/m²]", "paths")
    rows = [
        [
            label,
            with_interval(found["lamp_mura_contrast"], 4),
            with_interval(found["mean_luminance_cd_m2"], 0),
            short(found["paths"]),
        ]
        for label, found in ((f"<b>{escape(record['name'])}</b>", record), ("conventional", base))
    ]
    limit = record["gates"][0]["limit"]
    caption = (
        "33 points over one lamp pitch at the panel's middle, with their 95 % band; the lines "
        "are the Fourier series that the contrast is read from, so that single noisy points do not "
        "widen L<sub>max</sub> − L<sub>min</sub>. Right: "
        f"L / mean − 1; the dotted lines stand at ± {limit * 100:g} %."
    )
    return (
        figure(figure_html(luminance_figure(record), "luminance"), caption)
        + table(head, rows, numeric=(1, 2, 3))
        + "<h3>Energy balance</h3>"
        + table(
            ("share of the lamps' light", "this film", "conventional"),
            _energy_rows(record["energy"], base["energy"]),
            numeric=(1, 2),
        )
    )
