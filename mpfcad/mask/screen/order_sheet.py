"""The order on one page of A4, with reportlab; the same values give the same bytes."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.mask.whole import whole_file

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

#: Points a mm; margins, column and line in mm.
_POINT = 72 / 25.4
_LEFT, _TOP, _VALUE, _LINE, _FOOT = 18.0, 279.0, 78.0, 5.6, 18.0
_DRAWING = 52.0


def write_order(
    path: Path, order: dict[str, Any], printability: str | None, hashes: dict[str, str]
) -> None:
    """Write the order sheet.

    Parameters
    ----------
    path
        of the PDF
    order
        as `describe_order` gives it
    printability
        what the gates said
    hashes
        SHA-256 of each mask file by its name
    """
    from reportlab.lib.pagesizes import A4
    from reportlab.pdfgen.canvas import Canvas

    with whole_file(path) as part:
        canvas = Canvas(str(part), pagesize=A4, invariant=1, pageCompression=1)
        canvas.setTitle(f"Screen order: {order['name']}, revision {order['revision']}")
        canvas.setCreator("mpfcad")
        canvas.setFont("Helvetica-Bold", 15)
        canvas.drawString(_LEFT * _POINT, _TOP * _POINT, f"Screen order: {order['name']}")
        height = _TOP - 9
        for label, value in _rows(order, printability):
            _write_row(canvas, height, label, value)
            height -= _LINE
        _draw_panel(canvas, order, height - 4)
        _write_hashes(canvas, hashes)
        canvas.showPage()
        canvas.save()


def _rows(order: dict[str, Any], printability: str | None) -> Iterator[tuple[str, str]]:
    yield "revision; content hash", f"{order['revision']}; {order['content_sha256_12']}"
    yield "printability", str(printability)
    if order["mesh"] is None:
        yield "mesh", "not stated: phototool only"
    else:
        yield (
            "mesh",
            (
                f"{order['mesh']} {order['mesh_material']}: opening "
                f"{order['mesh_opening_um']:.3g} µm, fabric {order['mesh_thickness_um']:.3g} µm"
            ),
        )
        if order["mesh_computed"]:
            yield "of these computed", f"{order['mesh_computed']}: state the weaver's in the offer"
        yield "angle of the threads to the grooves", f"{order['mesh_angle_deg']:g}°"
        yield "emulsion over mesh", f"{order['emulsion_over_mesh_um']:g} µm"
    yield "emulsion side", f"the {order['emulsion_side']}'s"
    drawn = {"open": "where resin passes", "closed": "where no resin passes"}
    yield "drawn", drawn[order["polarity"]]
    seen = "mirrored: seen from the film's side" if order["mirror"] else "from the squeegee's side"
    yield "seen", seen
    low, high = order["aperture_ratio"]
    yield "pattern; period along the grooves", f"{order['pattern']}; {order['period_um']:.4f} µm"
    yield "aperture ratio", f"{low:.4f} to {high:.4f}"
    for name in ("aperture", "web"):
        size = order[f"smallest_{name}_um"]
        yield f"smallest {name}", "none" if size is None else f"{size:.3f} µm"
    if order["edge_tolerance_um"] is not None:
        yield (
            "tolerance of an aperture's length",
            (
                f"± {order['edge_tolerance_um']:.2g} µm (changes the curvature by "
                f"{order['edge_tolerance_curvature_per_mm']:g} /mm)"
            ),
        )
    stroke = {"along": "along the grooves (y)", "across": "across the grooves (x)"}
    yield "grooves; squeegee", f"along y; {stroke[order['squeegee']]}"
    for name, label in (("panel", "panel, x × y"), ("artwork", "artwork with furniture"),
                        ("frame_inside", "frame, inside at least")):  # fmt: skip
        yield label, " × ".join(f"{side:.2f}" for side in order[f"{name}_mm"]) + " mm"
    yield "open area", f"{order['open_area_cm2']:.1f} cm²"
    yield "fiducials", f"{order['fiducials']} crosses, 10 mm off the corners, 4 mm across"
    wedge = ", ".join(f"{100 * ratio:.3g}" for ratio in order["coupon_aperture_ratio"])
    yield "step wedge [%]", wedge or "none"


def _write_row(canvas: "Canvas", height: float, label: str, value: str) -> None:
    canvas.setFont("Helvetica", 9)
    canvas.drawString(_LEFT * _POINT, height * _POINT, label)
    canvas.setFont("Helvetica-Bold", 9)
    canvas.drawString(_VALUE * _POINT, height * _POINT, value)


def _draw_panel(canvas: "Canvas", order: dict[str, Any], top: float) -> None:
    """Draw frame, artwork and panel to one scale, and the directions."""
    frame, art, panel = (order[f"{k}_mm"] for k in ("frame_inside", "artwork", "panel"))
    space = top - _FOOT - 34
    scale = min(_DRAWING * 2 / max(frame[0], art[0]), space / max(frame[1], art[1]))
    middle = (_LEFT + _DRAWING, top - space / 2)
    for size, width in ((frame, 1.2), (art, 0.4), (panel, 0.8)):
        canvas.setLineWidth(width)
        x, y = (m - s * scale / 2 for m, s in zip(middle, size, strict=True))
        canvas.rect(x * _POINT, y * _POINT, size[0] * scale * _POINT, size[1] * scale * _POINT)
    x, y = 132.0, middle[1]
    canvas.setLineWidth(0.8)
    canvas.line(x * _POINT, (y - 12) * _POINT, x * _POINT, (y + 12) * _POINT)
    canvas.setFont("Helvetica", 8)
    canvas.drawString((x + 3) * _POINT, y * _POINT, "grooves (y)")
    canvas.drawString(x * _POINT, (y - 18) * _POINT, "frame, artwork, panel: to scale")


def _write_hashes(canvas: "Canvas", hashes: dict[str, str]) -> None:
    canvas.setFont("Courier", 7)
    for i, (name, digest) in enumerate(sorted(hashes.items())):
        canvas.drawString(_LEFT * _POINT, (_FOOT + 24 - 3.6 * i) * _POINT, f"{digest}  {name}")
    canvas.setFont("Helvetica", 8)
    canvas.drawString(_LEFT * _POINT, (_FOOT + 28) * _POINT, "SHA-256 of the files")
