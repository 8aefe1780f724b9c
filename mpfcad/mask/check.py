"""A mask file read back with klayout: each groove's aperture ratio, from the file alone.

The arrays are never flattened: an array of nx columns and ny rows of a rectangle becomes nx
columns, and the overlap of each with each groove, times its rows, is that groove's open area.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import ExportError
from mpfcad.mask.aperture import Mask
from mpfcad.mask.column import Columns, column_area, measure_webs
from mpfcad.mask.rule import GRID
from mpfcad.mask.write import APERTURE, FIDUCIAL, OUTLINE, TEXT

if TYPE_CHECKING:
    import klayout.db as kdb

#: How far a groove's aperture ratio read back may be from the wanted one: 0.1 percentage point.
RATIO_TOLERANCE = 0.001
#: Database unit of a mask file [µm].
DATABASE_UNIT = 0.001


@dataclass(frozen=True, eq=False)
class MaskCheck:
    """What a mask file holds, as read back; lengths in mm.

    Attributes
    ----------
    aperture_ratio
        (n,) float64, open area over area of each groove
    aperture_ratio_error_max
        largest distance from the wanted aperture ratio
    aperture_count
        number of apertures
    smallest_aperture, smallest_web
        narrowest opening, and narrowest stretch between openings; None on a mask without any
    width, length
        of the outline
    unit
        database unit [µm]
    fiducial_count
        crosses outside the outline
    text
        the lines of text
    """

    aperture_ratio: NDArray[np.float64]
    aperture_ratio_error_max: float
    aperture_count: int
    smallest_aperture: float | None
    smallest_web: float | None
    width: float
    length: float
    unit: float
    fiducial_count: int
    text: tuple[str, ...]


def check_mask(path: Path, mask: Mask) -> MaskCheck:
    """Read a mask file and compare it with what was wanted of `mask`.

    Raises
    ------
    ExportError
        when anything is not as wanted; a groove (counted from 0) is named.
    """
    import klayout.db as kdb

    path = Path(path)
    layout = kdb.Layout()
    try:
        layout.read(str(path))
        top = layout.top_cell()
    except RuntimeError as error:
        raise ExportError(f"{path}: not a readable mask: {' '.join(str(error).split())}") from None
    if top is None or abs(layout.dbu - DATABASE_UNIT) > 1e-12:
        raise ExportError(f"{path}: database unit {layout.dbu:g} µm: wanted {DATABASE_UNIT:g}")
    outline = _read_outline(path, layout, top)
    fiducials, text = _read_furniture(path, layout, top, outline)
    columns = _read_columns(path, layout, top)
    _check_panel(path, mask, outline, columns)

    edge = np.rint(np.arange(mask.groove_count + 1) * mask.pitch / GRID).astype(np.int64)
    area = column_area(columns, edge)
    ratio = area * GRID**2 / (mask.pitch * mask.length)
    error = np.abs(ratio - mask.wanted_ratio)
    worst = int(np.argmax(error))
    if not error[worst] <= RATIO_TOLERANCE:
        raise ExportError(
            f"{path}: groove {worst} (counted from 0): aperture ratio {ratio[worst]:.5f}: "
            f"wanted {mask.wanted_ratio[worst]:.5f} ± {RATIO_TOLERANCE:g}"
        )
    _check_furniture(path, mask, columns, fiducials, text)
    aperture, web = measure_webs(str(path), columns, mask.pitch / GRID)
    for name, size, limit in (
        ("aperture", aperture, mask.rules.min_aperture),
        ("web", web, mask.rules.min_web),
    ):
        if size is not None and size * GRID < limit - 2 * GRID:
            raise ExportError(f"{path}: smallest {name} {size * GRID:g} mm: wanted {limit:g} mm")
    return MaskCheck(
        aperture_ratio=ratio,
        aperture_ratio_error_max=float(error[worst]),
        aperture_count=columns.aperture_count,
        smallest_aperture=None if aperture is None else aperture * GRID,
        smallest_web=None if web is None else web * GRID,
        width=outline.width() * GRID,
        length=outline.height() * GRID,
        unit=layout.dbu,
        fiducial_count=fiducials,
        text=text,
    )


def _read_outline(path: Path, layout: "kdb.Layout", top: "kdb.Cell") -> "kdb.Box":
    layer = layout.find_layer(OUTLINE, 0)
    shapes = [] if layer is None else list(top.shapes(layer).each())
    if len(shapes) != 1 or not shapes[0].is_box():
        raise ExportError(f"{path}: layer {OUTLINE}/0: wanted one rectangle, the panel's outline")
    return shapes[0].box


def _read_furniture(
    path: Path, layout: "kdb.Layout", top: "kdb.Cell", outline: "kdb.Box"
) -> tuple[int, tuple[str, ...]]:
    """Return the number of fiducials, all outside the outline, and the lines of text."""
    fiducials = 0
    layer = layout.find_layer(FIDUCIAL, 0)
    if layer is not None:
        for shape in top.begin_shapes_rec(layer):
            if shape.shape().bbox().transformed(shape.trans()).overlaps(outline):
                raise ExportError(f"{path}: layer {FIDUCIAL}/0: a fiducial inside the panel")
            fiducials += 1
    layer = layout.find_layer(TEXT, 0)
    shapes = [] if layer is None else top.shapes(layer).each()
    return fiducials, tuple(shape.text_string for shape in shapes if shape.is_text())


def _read_columns(path: Path, layout: "kdb.Layout", top: "kdb.Cell") -> Columns:
    """Return every aperture of the file as columns along y."""
    layer = layout.find_layer(APERTURE, 0)
    if layer is None:
        return Columns.build([])
    found: list[tuple[int, ...]] = []
    for shape in top.shapes(layer).each():
        found.append((*_box(path, top, shape), 1, 0, 1, 0))
    rectangles: dict[int, tuple[int, int, int, int] | None] = {}
    for instance in top.each_inst():
        index = instance.cell_index
        if index not in rectangles:
            rectangles[index] = _rectangle(path, layout.cell(index), layer)
        rectangle = rectangles[index]
        if rectangle is None:
            continue
        found.append(_array(path, instance, rectangle))
    return Columns.build(found)


def _rectangle(path: Path, cell: "kdb.Cell", layer: int) -> tuple[int, int, int, int] | None:
    """Return left, bottom, width, height of the cell's one aperture; None when it has none."""
    if cell.bbox(layer).empty():
        return None
    shapes = list(cell.shapes(layer).each())
    if len(shapes) != 1 or cell.child_instances():
        raise ExportError(f"{path}: cell {cell.name}: wanted one aperture")
    return _box(path, cell, shapes[0])


def _box(path: Path, cell: "kdb.Cell", shape: "kdb.Shape") -> tuple[int, int, int, int]:
    if not shape.is_box():
        raise ExportError(f"{path}: cell {cell.name}: an aperture that is no rectangle")
    box = shape.box
    return box.left, box.bottom, box.width(), box.height()


def _array(
    path: Path, instance: "kdb.Instance", rectangle: tuple[int, int, int, int]
) -> tuple[int, ...]:
    """Return left, bottom, width, height, columns, their step, rows, their step of an array."""
    trans = instance.trans
    if instance.is_complex() or trans.rot != 0:
        raise ExportError(f"{path}: cell {instance.cell.name}: turned or scaled")
    nx, step_x, ny, step_y = 1, 0, 1, 0
    for count, step in ((instance.na, instance.a), (instance.nb, instance.b)):
        if count <= 1:
            continue
        if step.x and not step.y and nx == 1:
            nx, step_x = count, step.x
        elif step.y and not step.x and ny == 1:
            ny, step_y = count, step.y
        else:
            raise ExportError(f"{path}: cell {instance.cell.name}: an oblique array")
    left, bottom, width, height = rectangle
    left += trans.disp.x + min(0, (nx - 1) * step_x)
    bottom += trans.disp.y + min(0, (ny - 1) * step_y)
    return left, bottom, width, height, nx, abs(step_x), ny, abs(step_y)


def _check_panel(path: Path, mask: Mask, outline: "kdb.Box", columns: Columns) -> None:
    """Refuse a wrong outline and apertures outside it."""
    wanted = (0, 0, round(mask.groove_count * mask.pitch / GRID), round(mask.length / GRID))
    if (outline.left, outline.bottom, outline.right, outline.top) != wanted:
        raise ExportError(f"{path}: outline {outline}: wanted {wanted} (1 nm steps)")
    if not columns.is_inside(*wanted):
        raise ExportError(f"{path}: an aperture outside the outline")


def _check_furniture(
    path: Path, mask: Mask, columns: Columns, fiducials: int, text: tuple[str, ...]
) -> None:
    """Refuse a wrong number of apertures or fiducials, and a text without name and hash."""
    if columns.aperture_count != mask.aperture_count:
        raise ExportError(
            f"{path}: {columns.aperture_count} apertures: wanted {mask.aperture_count}"
        )
    if fiducials != 4:
        raise ExportError(f"{path}: {fiducials} fiducials: wanted 4")
    if not any(mask.name in line and mask.content_hash in line for line in text):
        raise ExportError(f"{path}: text: wanted {mask.name!r} with hash {mask.content_hash}")
