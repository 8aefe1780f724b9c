"""GDSII and DXF read with klayout: arrays of references stay arrays.

An aperture is a cell that holds one rectangle; a tile is a cell of such references.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.errors import ExportError
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.check.found import Box, FoundMask, read_polarity
from mpfcad.mask.format.dxf import MILLIMETRE
from mpfcad.mask.layer import APERTURE, COUPON, FIDUCIAL, OUTLINE, TEXT
from mpfcad.mask.rule import GRID
from mpfcad.units import mm, um

if TYPE_CHECKING:
    import klayout.db as kdb

#: A layer's name in a DXF; older files have number and datatype, which klayout understands.
_NAMED = re.compile(r"[A-Z]+_(\d+)")
#: Database unit of a mask file [µm].
DATABASE_UNIT = GRID / um
#: Places of a file that are gone through one by one, at most: a few bytes can state 10⁹ of them.
MOST_PLACES = 50_000_000
_MOST_FIDUCIALS = 10_000
#: DXF's numbers of units end here; the first is none.
_UNITS = 25


def open_layout(path: Path) -> "kdb.Layout":
    """Return a layout file as klayout reads it, its arrays kept.

    Raises
    ------
    ExportError
        when it cannot be read or is not on the 1 nm grid.
    """
    import klayout.db as kdb

    options = kdb.LoadLayoutOptions()
    options.dxf_unit = mm / um
    options.dxf_dbu = DATABASE_UNIT
    layout = kdb.Layout(False)
    try:
        layout.read(str(path), options)
        top = layout.top_cell()
    except RuntimeError as error:
        raise ExportError(f"{path}: not a readable mask: {' '.join(str(error).split())}") from None
    if top is None or abs(layout.dbu - DATABASE_UNIT) > 1e-12:
        raise ExportError(f"{path}: database unit {layout.dbu:g} µm: expected {DATABASE_UNIT:g}")
    _number_layers(layout)
    return layout


def check_unit(path: Path) -> None:
    """Refuse a DXF whose header states another unit than mm; without unit it is taken as mm.

    Raises
    ------
    ExportError
        naming the unit, and how its drawing is scaled.
    """
    from ezdxf import DXFError, units
    from ezdxf.filemanagement import dxf_file_info

    try:
        stated = dxf_file_info(path).insert_units
    except DXFError as error:
        raise ExportError(f"{path}: not a readable mask: {error}") from None
    if stated not in (0, MILLIMETRE):
        name = units.decode(stated) if 0 < stated < _UNITS else "unknown"
        raise ExportError(
            f"{path}: $INSUNITS {stated} ({name}): its numbers are not mm: expected "
            f"{MILLIMETRE} (mm), drawn 1:1"
        )


def _number_layers(layout: "kdb.Layout") -> None:
    """Give layers that have names only (DXF) the numbers that stand in them: `APERTURE_1`."""
    import klayout.db as kdb

    for index in layout.layer_indexes():
        info = layout.get_info(index)
        found = _NAMED.fullmatch(info.name)
        if info.layer < 0 and found is not None:
            layout.set_info(index, kdb.LayerInfo(int(found[1]), 0))


def read_layout(path: Path) -> FoundMask:
    """Return what a GDSII or DXF file holds.

    Raises
    ------
    ExportError
        when it holds anything else than a mask does.
    """
    layout = open_layout(path)
    text = _texts(layout)
    return FoundMask(
        outline=read_outline(path, layout),
        unit=layout.dbu,
        text=text,
        fiducials=_boxes(path, layout, FIDUCIAL),
        coupon=tuple(layout_arrays(path, layout, COUPON)),
        drawn=read_polarity(path, text),
        arrays=lambda: layout_arrays(path, layout, APERTURE),
        window=lambda box: layout_window(layout, box),
    )


def layout_window(layout: "kdb.Layout", box: Box) -> "kdb.Region":
    """Return the apertures that touch a box, each whole."""
    import klayout.db as kdb

    layer = layout.find_layer(APERTURE, 0)
    if layer is None:
        return kdb.Region()
    shapes = layout.top_cell().begin_shapes_rec_touching(layer, kdb.Box(*box))
    return kdb.Region(shapes).flatten()


def read_outline(path: Path, layout: "kdb.Layout") -> Box:
    """Return the one rectangle on the outline's layer."""
    layer = layout.find_layer(OUTLINE, 0)
    shapes = [] if layer is None else list(layout.top_cell().shapes(layer).each())
    boxes = [_rectangle(shape) for shape in shapes]
    if len(boxes) != 1 or boxes[0] is None:
        raise ExportError(f"{path}: layer {OUTLINE}/0: expected one rectangle, the panel's outline")
    box = boxes[0]
    return box.left, box.bottom, box.right, box.top


def _rectangle(shape: "kdb.Shape") -> "kdb.Box | None":
    """Return a shape as a rectangle; None when it is none."""
    if shape.is_box():
        return shape.box
    return shape.polygon.bbox() if shape.is_polygon() and shape.polygon.is_box() else None


def refuse_many(path: Path, cell: str, count: int, most: int = MOST_PLACES) -> None:
    """Refuse to go through more places than any mask has.

    Raises
    ------
    ExportError
        naming the cell.
    """
    if count > most:
        raise ExportError(f"{path}: cell {cell[:60]}: {count} places: expected at most {most}")


def _boxes(path: Path, layout: "kdb.Layout", number: int) -> tuple[Box, ...]:
    layer = layout.find_layer(number, 0)
    if layer is None:
        return ()
    found: list[Box] = []
    shapes = layout.top_cell().begin_shapes_rec(layer)
    for shape in shapes.each():
        refuse_many(path, layout.top_cell().name, len(found) + 1, _MOST_FIDUCIALS)
        box = shape.shape().bbox().transformed(shape.trans())
        found.append((box.left, box.bottom, box.right, box.top))
    return tuple(found)


def _texts(layout: "kdb.Layout") -> tuple[str, ...]:
    layer = layout.find_layer(TEXT, 0)
    shapes = [] if layer is None else layout.top_cell().shapes(layer).each()
    return tuple(shape.text_string for shape in shapes if shape.is_text())


def layout_arrays(path: Path, layout: "kdb.Layout", number: int) -> Iterator[ApertureArray]:
    """Yield what stands on a layer: shapes of the top cell, references, and tiles of references."""
    layer = layout.find_layer(number, 0)
    if layer is not None:
        for x, y, array in _cell_arrays(path, layout, layout.top_cell(), layer):
            place = array.place
            origin = (place.origin[0] + x, place.origin[1] + y)
            steps = (place.column_step, place.row_step)
            yield ApertureArray(array.shape, Placement(origin, place.columns, place.rows, *steps))


def _cell_arrays(
    path: Path, layout: "kdb.Layout", cell: "kdb.Cell", layer: int
) -> Iterator[tuple[int, int, ApertureArray]]:
    """Yield where a cell's arrays are moved to, and the arrays."""
    for shape in cell.shapes(layer).each():
        box = _box(path, cell, shape)
        yield box.left, box.bottom, ApertureArray((box.width(), box.height()), Placement((0, 0)))
    inner: dict[int, list[tuple[int, int, ApertureArray]]] = {}
    for instance in cell.each_inst():
        index = instance.cell_index
        if index not in inner:
            inner[index] = list(_cell_arrays(path, layout, layout.cell(index), layer))
        if not inner[index]:
            continue
        place = _placement(path, instance)
        if not layout.cell(index).is_leaf():
            refuse_many(path, cell.name, place.count * len(inner[index]))
        for x, y, array in inner[index]:
            if layout.cell(index).is_leaf():
                yield x, y, ApertureArray(array.shape, place)
            else:  # a tile
                for a, b in place.positions():
                    yield x + int(a), y + int(b), array


def _box(path: Path, cell: "kdb.Cell", shape: "kdb.Shape") -> "kdb.Box":
    box = _rectangle(shape)
    if box is None:
        raise ExportError(f"{path}: cell {cell.name}: an aperture that is no rectangle")
    return box


def _placement(path: Path, instance: "kdb.Instance") -> Placement:
    """Return the places of an upright reference, or array of references."""
    trans = instance.trans
    if instance.is_complex() or trans.rot != 0:
        raise ExportError(f"{path}: cell {instance.cell.name}: turned or scaled")
    columns, step_x, rows, step_y = 1, 0, 1, 0
    for count, step in ((instance.na, instance.a), (instance.nb, instance.b)):
        if count <= 1:
            continue
        if step.x and not step.y and columns == 1:
            columns, step_x = count, step.x
        elif step.y and not step.x and rows == 1:
            rows, step_y = count, step.y
        else:
            raise ExportError(f"{path}: cell {instance.cell.name}: an oblique array")
    x = trans.disp.x + min(0, (columns - 1) * step_x)
    y = trans.disp.y + min(0, (rows - 1) * step_y)
    return Placement((x, y), columns, rows, (abs(step_x), 0), (0, abs(step_y)))
