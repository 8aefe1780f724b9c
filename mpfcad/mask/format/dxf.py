"""A drawing as DXF R2000 with ezdxf: closed polylines in blocks, arrays as INSERTs; in mm.

The header states unit, measurement and extents; layers are named for what they hold.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.format.drawing import Drawing
from mpfcad.mask.layer import APERTURE, COUPON, LAYERS, OUTLINE, TEXT
from mpfcad.mask.rule import GRID

if TYPE_CHECKING:
    from ezdxf.layouts import BlockLayout, Modelspace

#: An INSERT counts its rows and columns with 15 bits.
LARGEST_ARRAY = 32_767
#: Decimals of a coordinate in mm: the 1 nm grid.
DECIMALS = 6
TEXT_HEIGHT = 3.0
UNIT_TEXT = "unit: mm"
#: $INSUNITS and $MEASUREMENT.
MILLIMETRE, METRIC = 4, 1


def write_dxf(drawing: Drawing, path: Path) -> None:
    """Write `drawing` to `path`."""
    import ezdxf

    with _without_date():
        document = ezdxf.new("R2000", units=MILLIMETRE)
        _state_extents(document, drawing)
        for layer in LAYERS:
            document.layers.add(layer_name(layer))
        space = document.modelspace()
        blocks = _Blocks(document)
        panel = ApertureArray((drawing.width, drawing.length), Placement((0, 0)))
        _add_outline(space, panel, OUTLINE)
        for layer, points in drawing.polygons:
            _add_outline(space, ApertureArray(points, Placement((0, 0))), layer)
        for i, label in enumerate((*drawing.labels, None)):
            text = UNIT_TEXT if label is None else label.text
            lowest = min((line.position[1] for line in drawing.labels), default=0)
            foot = _mm(lowest) - 3 * TEXT_HEIGHT if label is None else _mm(label.position[1])
            at = (0.0 if label is None else _mm(label.position[0]), foot)
            attributes = {"layer": layer_name(TEXT), "height": TEXT_HEIGHT, "insert": at}
            if drawing.labels or i:
                space.add_text(text, dxfattribs=attributes)
        for array in drawing.arrays:
            _insert(space, blocks.shape(array, APERTURE), APERTURE, array.place)
        for array in drawing.coupon:
            _insert(space, blocks.shape(array, COUPON), COUPON, array.place)
        for tile in drawing.tile_cells():
            block = document.blocks.new(tile.name)
            for array in tile.arrays:
                _insert(block, blocks.shape(array, APERTURE), APERTURE, array.place)
        for placed in drawing.tiles:
            _insert(space, placed.tile.name, APERTURE, placed.place)
        document.saveas(path)


def _state_extents(document: Any, drawing: Drawing) -> None:
    """Put unit, measurement and extents into the header, and the view onto them."""
    left, bottom, right, top = (_mm(value) for value in drawing.bounds())
    document.header["$MEASUREMENT"] = METRIC
    document.header["$EXTMIN"], document.header["$EXTMAX"] = (left, bottom, 0), (right, top, 0)
    document.header["$LIMMIN"], document.header["$LIMMAX"] = (left, bottom), (right, top)
    document.modelspace().reset_extents((left, bottom, 0), (right, top, 0))
    document.set_modelspace_vport(top - bottom, ((left + right) / 2, (bottom + top) / 2))


def layer_name(layer: int) -> str:
    """Return the name of a layer, what it holds and its number: `APERTURE_1`."""
    return f"{LAYERS[layer].upper()}_{layer}"


@contextmanager
def _without_date() -> Iterator[None]:
    """Have ezdxf write a fixed date and id."""
    import ezdxf

    before = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = before


class _Blocks:
    """One block for each shape."""

    def __init__(self, document: Any) -> None:
        self.document = document
        self.names: dict[object, str] = {}

    def shape(self, array: ApertureArray, layer: int) -> str:
        shape = array.shape
        key = (layer, shape if isinstance(shape, tuple) else shape.tobytes())
        if key not in self.names:
            self.names[key] = f"L{layer}S{len(self.names)}"
            _add_outline(self.document.blocks.new(self.names[key]), array, layer)
        return self.names[key]


def _add_outline(into: "Modelspace | BlockLayout", array: ApertureArray, layer: int) -> None:
    """Add the array's shape once, as a closed polyline."""
    points: Any = array.shape
    if isinstance(array.shape, tuple):
        width, length = array.shape
        points = ((0, 0), (width, 0), (width, length), (0, length))
    corners = [(_mm(x), _mm(y)) for x, y in points]
    into.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer_name(layer)})


def _insert(into: "Modelspace | BlockLayout", name: str, layer: int, place: Placement) -> None:
    """Add INSERTs: a lattice along the axes as a few, anything else one by one."""
    attributes = {"layer": layer_name(layer)}
    (ax, ay), (bx, by) = place.column_step, place.row_step
    if place.offset is not None or ay or bx:
        for x, y in place.positions():
            into.add_blockref(name, (_mm(x), _mm(y)), dxfattribs=attributes)
        return
    for i in range(0, place.columns, LARGEST_ARRAY):
        for j in range(0, place.rows, LARGEST_ARRAY):
            at = (_mm(place.origin[0] + i * ax), _mm(place.origin[1] + j * by))
            lattice = {
                "column_count": min(LARGEST_ARRAY, place.columns - i),
                "row_count": min(LARGEST_ARRAY, place.rows - j),
                "column_spacing": _mm(ax),
                "row_spacing": _mm(by),
            }
            into.add_blockref(name, at, dxfattribs=attributes | lattice)


def _mm(value: int) -> float:
    return round(float(value) * GRID, DECIMALS)
