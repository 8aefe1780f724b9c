"""A cross-section as DXF in mm: one closed exact curve, and the same as a closed polyline.

Lines, parabolas and circular arcs are all quadratic rational Bézier curves, so the whole outline is
one closed SPLINE of degree 2 without any approximation (layer `OUTLINE`). Layer `POLYLINE` holds
chords within an angle, for readers without splines. X is across, Y is up.
"""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.shape.section_mesh import build_outline
from mpfcad.errors import ExportError
from mpfcad.film import Section
from mpfcad.film.section import ARC, LINE

#: DXF's number for millimetres in $INSUNITS.
MILLIMETRE = 4
#: Largest relative error of the polyline's area, and largest distance [mm] from the spline.
AREA_TOLERANCE, DISTANCE_TOLERANCE = 1e-4, 1e-9


def write_dxf(section: Section, path: Path, angle_tolerance: float) -> None:
    """Write the outline of a section; same section, same bytes."""
    import ezdxf

    path = Path(path)
    fixed = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    part = path.with_name("." + path.name + ".part")
    try:
        document = ezdxf.new("R2000")
        document.header["$INSUNITS"] = MILLIMETRE
        document.header["$MEASUREMENT"] = 1
        for layer in ("OUTLINE", "POLYLINE"):
            document.layers.add(layer)
        space = document.modelspace()
        points, weights, knots = rational_outline(section)
        spline = space.add_spline(degree=2, dxfattribs={"layer": "OUTLINE"})
        spline.control_points = np.column_stack([points, np.zeros(len(points))])
        spline.weights = weights
        spline.knots = knots
        spline.closed = True
        x, z, _ = build_outline(section, angle_tolerance)
        corners = np.column_stack([x, z]).astype(float)
        under = [(section.width, section.underside), (0.0, section.underside)]
        polyline = space.add_lwpolyline([], close=True, dxfattribs={"layer": "POLYLINE"})
        # All at once: x, y, two widths, bulge. Corner by corner takes the square of their number.
        polyline.lwpoints.set(np.pad(np.concatenate([corners, under]), ((0, 0), (0, 3))))
        document.saveas(part)
        part.replace(path)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = fixed
        part.unlink(missing_ok=True)


def rational_outline(
    section: Section,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return control points (2m+1, 2) [mm], weights and knots of the closed outline.

    Each piece is one Bézier segment: two ends, and between them the point where the tangents of
    both ends meet, with weight 1 for a parabola or line and cos(turn/2) for an arc.
    """
    piece = np.arange(section.piece_count)
    slope = [section.slope_on(piece, x) for x in (section.x[:-1], section.x[1:])]
    left, right = section.x[:-1], section.x[1:]
    low, high = section.z[:-1], section.z[1:]
    curved = section.kind != LINE
    bow = np.where(curved, slope[0] - slope[1], 1.0)
    meet = np.where(
        curved, (high - low + slope[0] * left - slope[1] * right) / bow, (left + right) / 2
    )
    level = np.where(curved, low + slope[0] * (meet - left), (low + high) / 2)
    turn = np.abs(np.arctan(slope[1]) - np.arctan(slope[0]))
    weight = np.where(section.kind == ARC, np.cos(turn / 2), 1.0)
    ends = np.column_stack([section.x, section.z])
    foot = np.array([[section.width, section.underside], [0.0, section.underside]])
    ring = np.concatenate([ends, foot, ends[:1]])
    middle = (ring[1:] + ring[:-1]) / 2
    middle[: len(piece)] = np.column_stack([meet, level])
    points = np.empty((2 * len(ring) - 1, 2))
    points[::2], points[1::2] = ring, middle
    weights = np.ones(len(points))
    weights[1 : 2 * len(piece) : 2] = weight
    inner = np.repeat(np.arange(1.0, len(ring) - 1), 2)
    last = float(len(ring) - 1)
    return points, weights, np.concatenate([[0.0] * 3, inner, [last] * 3])


def check_dxf(path: Path, section: Section) -> float:
    """Return the relative area error of the polyline, read with KLayout, once the file is right.

    Raises
    ------
    ExportError
        when the file is not in mm, a curve is not closed, the polyline is off in area, or the
        spline is off the surface.
    """
    import ezdxf

    path = Path(path)
    try:
        document = ezdxf.readfile(path)
    except (OSError, ezdxf.DXFError) as error:
        raise ExportError(f"{path.name}: cannot be read: {error}") from error
    if document.header.get("$INSUNITS") != MILLIMETRE:
        raise ExportError(f"{path.name}: $INSUNITS: expected {MILLIMETRE} (mm)")
    (spline,) = document.modelspace().query("SPLINE")
    (polyline,) = document.modelspace().query("LWPOLYLINE")
    if not (spline.closed and polyline.closed):
        raise ExportError(f"{path.name}: an outline is not closed")
    _check_spline(path, spline, section)
    off = _polyline_area(path) / section.area - 1
    if not abs(off) <= AREA_TOLERANCE:
        raise ExportError(f"{path.name}: polyline's relative area error {off:.3g}")
    return float(off)


def _check_spline(path: Path, spline: Any, section: Section) -> None:
    """Compare points of the spline, four in each piece, with the surface."""
    control = np.asarray(spline.control_points)[:, :2]
    weights = np.asarray(spline.weights)
    count = section.piece_count
    a, b, c = (control[i : i + 2 * count : 2] for i in range(3))
    w = weights[1 : 2 * count : 2][:, None]
    for t in (0.0, 0.25, 0.5, 0.8):
        blend = ((1 - t) ** 2, 2 * t * (1 - t) * w, t**2)
        point = (blend[0] * a + blend[1] * b + blend[2] * c) / sum(blend)
        surface = section.height_on(np.arange(count), point[:, 0])
        off = float(np.abs(point[:, 1] - surface).max())
        if not off <= DISTANCE_TOLERANCE:
            raise ExportError(f"{path.name}: spline is {off:.3g} mm off the surface")


def _polyline_area(path: Path) -> float:
    """Return the area [mm²] inside the closed polyline as KLayout reads it."""
    import klayout.db as kdb

    layout = kdb.Layout()
    options = kdb.LoadLayoutOptions()
    options.dxf_dbu = 1e-3
    options.dxf_unit = 1000.0
    options.dxf_polyline_mode = 2  # closed polylines become polygons
    layout.read(str(path), options)
    for info in layout.layer_infos():
        if info.name == "POLYLINE":
            region = kdb.Region(layout.top_cell().begin_shapes_rec(layout.layer(info)))
            return region.area() * 1e-12
    raise ExportError(f"{path.name}: no layer POLYLINE")
