"""What a screen maker quotes from: the facts of an order, as values, lines of text and coupons."""

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from mpfcad.film import Process
from mpfcad.mask.aperture import Mask
from mpfcad.mask.fabric import Mesh
from mpfcad.mask.format.drawing import draw
from mpfcad.mask.format.furniture import wedge_ratios
from mpfcad.mask.phototool import Phototool
from mpfcad.mask.rule import GRID
from mpfcad.units import deg, um

Direction = Literal["along", "across"]
#: Inside of the frame over the artwork, furniture included (SGIA: at least 1.5 times the print).
FRAME_SHARE = 1.5


@dataclass(frozen=True)
class OrderTerms:
    """What the user decides besides the mask.

    Attributes
    ----------
    revision
        of the artwork
    squeegee
        direction of the stroke, `along` or `across` the grooves
    frame
        (across, along) inside of the frame [mm]; None: `FRAME_SHARE` of the artwork
    mesh_angle
        of the threads to the grooves [rad]
    emulsion
        over mesh [mm]; None: not stated
    curvature_tolerance
        change of a groove's curvature [1/mm] that the tolerance of an edge stands for
    """

    revision: str
    squeegee: Direction
    frame: tuple[float, float] | None
    mesh_angle: float
    emulsion: float | None
    curvature_tolerance: float


def edge_tolerance(mask: Mask, process: Process, curvature: float) -> float | None:
    """Return by how much an aperture's length may be off [mm]; None without apertures.

    So much changes the most sensitive groove's curvature by `curvature` [1/mm], when all its
    apertures are off alike.
    """
    ends = np.array(mask.ratio_ends)
    if not ends[1]:
        return None
    low = process.curvature(ends) - curvature
    there = process.aperture_ratio_of_curvature(np.maximum(low, process.curvature_min))
    change = float(np.abs(there - ends).min())
    if mask.rules.pattern == "slot":
        return change * mask.period
    side = float(np.sqrt(ends[0] * mask.pitch * mask.period))
    return change * mask.pitch * mask.period / (2 * side)


def artwork_size(mask: Mask, phototool: Phototool) -> tuple[float, float]:
    """Return the size of the artwork, furniture included, across and along [mm].

    Of the order's lines the first is drawn, too: `phototool` holds it in its notes.
    """
    left, bottom, right, top = (v * GRID for v in draw(mask, phototool, paints=True).bounds())
    return right - left, top - bottom


def describe_order(
    mask: Mask, process: Process, phototool: Phototool, terms: OrderTerms
) -> dict[str, Any]:
    """Return the facts of the order in outside names, fit for JSON."""
    mesh, rules = mask.rules.mesh, mask.rules
    aperture, web = mask.smallest_features
    tolerance = edge_tolerance(mask, process, terms.curvature_tolerance)
    screen = screen_line(mesh, terms)
    artwork = artwork_size(mask, replace(phototool, notes=(screen,)))
    frame = terms.frame or tuple(float(np.ceil(FRAME_SHARE * side / 10) * 10) for side in artwork)
    return {
        "name": mask.name,
        "revision": terms.revision,
        "content_sha256_12": mask.content_hash,
        "screen": screen,
        "mesh": None if mesh is None else mesh.name,
        "mesh_material": None if mesh is None else mesh.material,
        "mesh_opening_um": None if mesh is None else mesh.opening / um,
        "mesh_thickness_um": None if mesh is None else mesh.thickness / um,
        "mesh_computed": "" if mesh is None else mesh.computed,
        "mesh_angle_deg": terms.mesh_angle / deg,
        "emulsion_over_mesh_um": None if terms.emulsion is None else terms.emulsion / um,
        "emulsion_side": phototool.emulsion_side,
        "polarity": phototool.polarity,
        "mirror": phototool.mirror,
        "pattern": rules.pattern,
        "period_um": mask.period / um,
        "smallest_aperture_um": None if aperture is None else aperture / um,
        "smallest_web_um": None if web is None else web / um,
        "edge_tolerance_um": None if tolerance is None else tolerance / um,
        "edge_tolerance_curvature_per_mm": terms.curvature_tolerance,
        "aperture_ratio": list(mask.ratio_ends),
        "groove_direction": "y",
        "squeegee": terms.squeegee,
        "panel_mm": [mask.width, mask.length],
        "artwork_mm": list(artwork),
        "frame_inside_mm": list(frame),
        "open_area_cm2": float(mask.aperture_ratio.sum()) * mask.pitch * mask.length / 100,
        "fiducials": 4 if "fiducial" in phototool.furniture else 0,
        "coupon_aperture_ratio": list(wedge_ratios(mask))
        if "coupon" in phototool.furniture
        else [],
    }


def screen_line(mesh: Mesh | None, terms: OrderTerms) -> str:
    """Return the mesh, how it stands and its emulsion as a line of ASCII text."""
    if mesh is None:
        return "phototool only: no mesh named"
    over = "not stated" if terms.emulsion is None else f"{terms.emulsion / um:g} um"
    return (
        f"mesh {mesh.name} {mesh.material} at {terms.mesh_angle / deg:g} deg to the grooves; "
        f"emulsion over mesh {over}"
    )


def order_lines(order: dict[str, Any]) -> tuple[str, ...]:
    """Return the order as lines of ASCII text for the files, the line of the screen first."""
    pattern = f"{order['pattern']} period {order['period_um']:.4f} um"
    if order["smallest_aperture_um"] is not None:
        pattern += f"; smallest aperture {order['smallest_aperture_um']:.3f} um"
    if order["smallest_web_um"] is not None:
        pattern += f", web {order['smallest_web_um']:.3f} um"
    if order["edge_tolerance_um"] is not None:
        pattern += f"; lengths +- {order['edge_tolerance_um']:.2g} um"
    frame = " x ".join(f"{side:g}" for side in order["frame_inside_mm"])
    stroke = {"along": "y", "across": "x"}[order["squeegee"]]
    return (
        order["screen"],
        pattern,
        f"grooves along y; squeegee along {stroke}; frame inside {frame} mm; revision "
        f"{order['revision']}",
    )


def coupon_table(order: dict[str, Any]) -> str:
    """Return the list of coupons that `mpfcad calibrate --coupons` takes, traces to be added."""
    ratios = [ratio for ratio in order["coupon_aperture_ratio"] if 0 < ratio < 1]
    rows = [f"coupon-{i}.csv,{ratio:g}" for i, ratio in enumerate(ratios, 1)]
    return "\n".join(["file,aperture_ratio", *rows]) + "\n"
