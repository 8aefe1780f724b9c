"""The order on one page of A4, with reportlab; the same values give the same bytes."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.boundary.out import whole_file
from mpfcad.mask.check.found import FoundMask
from mpfcad.mask.screen.order_picture import (
    POINT,
    Frame,
    draw_artwork,
    draw_window,
    fiducial_centres,
    find_window,
)
from mpfcad.units import um

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

#: Margins, column and line [mm]; the pictures' widths and the hashes' height.
_LEFT, _TOP, _VALUE, _LINE, _FOOT = 18.0, 279.0, 78.0, 5.4, 14.0
_ARTWORK, _WINDOW, _HASHES = 92.0, 74.0, 32.0


def write_order(
    path: Path,
    order: dict[str, Any],
    printability: str | None,
    hashes: dict[str, str],
    artwork: tuple[str, FoundMask] | None,
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
    artwork
        the file that is drawn, and what it holds; None: pixels only
    """
    from reportlab.lib.pagesizes import A4
    from reportlab.pdfgen.canvas import Canvas

    with whole_file(path) as part:
        canvas = Canvas(str(part), pagesize=A4, invariant=1, pageCompression=1)
        canvas.setTitle(f"Screen order: {order['name']}, revision {order['revision']}")
        canvas.setCreator("mpfcad")
        canvas.setFont("Helvetica-Bold", 15)
        canvas.drawString(_LEFT * POINT, _TOP * POINT, f"Screen order: {order['name']}")
        height = _TOP - 9
        found = None if artwork is None else artwork[1]
        for label, value in _rows(order, printability, found):
            _write_row(canvas, height, label, value)
            height -= _LINE
        if artwork is not None:
            _draw_pictures(canvas, order, artwork, height)
        _write_hashes(canvas, hashes)
        canvas.showPage()
        canvas.save()


def _rows(
    order: dict[str, Any], printability: str | None, found: FoundMask | None
) -> Iterator[tuple[str, str]]:
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
        over = order["emulsion_over_mesh_um"]
        yield "emulsion over mesh", "not stated" if over is None else f"{over:g} µm"
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
    if found is not None and found.fiducials:
        axes = zip("xy", zip(*fiducial_centres(found), strict=True), strict=True)
        places = "; ".join(
            f"{axis} {', '.join(dict.fromkeys(f'{value:.3f}' for value in sorted(values)))}"
            for axis, values in axes
        )
        yield "their centres [mm] from the panel's corner", places
    ratios = order["coupon_aperture_ratio"][:: -1 if order["mirror"] else 1]
    wedge = ", ".join(f"{100 * ratio:.3g}" for ratio in ratios)
    yield "step wedge, left to right [%]", wedge or "none"


def _write_row(canvas: "Canvas", height: float, label: str, value: str) -> None:
    canvas.setFont("Helvetica", 9)
    canvas.drawString(_LEFT * POINT, height * POINT, label)
    canvas.setFont("Helvetica-Bold", 9)
    canvas.drawString(_VALUE * POINT, height * POINT, value)


def _draw_pictures(
    canvas: "Canvas", order: dict[str, Any], artwork: tuple[str, FoundMask], top: float
) -> None:
    """Draw the artwork and a magnified cut-out of it, side by side, as the file has them."""
    name, found = artwork
    foot = _FOOT + _HASHES
    window = find_window(found, order["period_um"] * um)
    draw_artwork(canvas, found, Frame(_LEFT, foot, _ARTWORK, top - foot), window)
    draw_window(canvas, found, Frame(_LEFT + _ARTWORK + 8, foot, _WINDOW, top - foot), window)
    canvas.setFont("Helvetica", 7)
    text = f"drawn from {name}; x across, y along the grooves, from the panel's lower left corner"
    canvas.drawString(_LEFT * POINT, (foot - 3) * POINT, text)


def _write_hashes(canvas: "Canvas", hashes: dict[str, str]) -> None:
    canvas.setFont("Courier", 7)
    for i, (name, digest) in enumerate(sorted(hashes.items())):
        canvas.drawString(_LEFT * POINT, (_FOOT + 20 - 3.6 * i) * POINT, f"{digest}  {name}")
    canvas.setFont("Helvetica", 8)
    canvas.drawString(_LEFT * POINT, (_FOOT + 24) * POINT, "SHA-256 of the files")
