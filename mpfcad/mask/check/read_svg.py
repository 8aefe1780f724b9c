"""SVG read again with an XML reader: its dashed lines become arrays."""

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

from mpfcad.errors import ExportError
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.check.found import Box, FoundMask, read_polarity, region_of
from mpfcad.mask.layer import APERTURE, COUPON, FIDUCIAL, LAYERS, OUTLINE
from mpfcad.mask.rule import GRID
from mpfcad.units import um

#: How far a coordinate may be from the grid: rounding of a decimal [grid steps].
OFF_GRID = 1e-3
_SVG = "{http://www.w3.org/2000/svg}"
_HREF = "{http://www.w3.org/1999/xlink}href"
_PART = re.compile(r"M0 ([0-9.]+)V([0-9.]+)")


def read_svg(path: Path) -> FoundMask:
    """Return what an SVG file holds.

    Raises
    ------
    ExportError
        when it holds anything else than a mask does.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise ExportError(f"{path}: not a readable mask: {error}") from None
    try:
        return _find(path, root)
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        raise ExportError(f"{path}: no element of a mask: {error!r}") from None


def _find(path: Path, root: ElementTree.Element) -> FoundMask:
    if root.tag != f"{_SVG}svg":
        raise ExportError(f"{path}: not a readable mask: {root.tag}")
    scale = float(root.attrib["width"].removesuffix("mm")) / float(
        root.attrib["viewBox"].split()[2]
    )
    if abs(scale - 1) > 1e-9:
        raise ExportError(f"{path}: one unit is {scale:g} mm: expected 1")
    found = (root.findtext(f"{_SVG}{tag}", "") for tag in ("title", "desc"))
    text = tuple(line for part in found for line in part.split("\n"))
    groups: dict[str, list[ElementTree.Element]] = {}
    body = root.find(f"{_SVG}g")
    if body is None:
        raise ExportError(f"{path}: holds no group of layers")
    for group in body.findall(f"{_SVG}g"):
        groups.setdefault(group.get("class") or group.get("id") or "", []).append(group)
    tiles = {group.attrib["id"]: group for group in body.iterfind(f"{_SVG}defs/{_SVG}g")}
    polarity = read_polarity(path, text)
    if (polarity == "closed") != ("closed" in groups):
        raise ExportError(f"{path}: text: 'drawn = {polarity}' is not what is painted")
    ink = "#fff" if polarity == "closed" else "#000"
    if any(group.get("fill", ink) != ink for group in groups.get(LAYERS[APERTURE], ())):
        raise ExportError(f"{path}: an aperture that is painted with wrong polarity")

    def arrays(layer: int = APERTURE) -> Iterator[ApertureArray]:
        for group in groups.get(LAYERS[layer], ()):
            yield from _arrays(path, group, tiles)

    apertures = tuple(arrays())
    crosses = (p for group in groups.get(LAYERS[FIDUCIAL], ()) for p in group)
    return FoundMask(
        outline=_box(groups[LAYERS[OUTLINE]][0][0]),
        unit=GRID / um,
        text=text,
        fiducials=tuple(_polygon_box(cross.attrib["points"]) for cross in crosses),
        coupon=tuple(arrays(COUPON)),
        drawn="open",
        arrays=lambda: iter(apertures),
        window=lambda box: region_of(iter(apertures), box),
    )


def _arrays(
    path: Path, group: ElementTree.Element, tiles: dict[str, ElementTree.Element]
) -> Iterator[ApertureArray]:
    lines: dict[str, tuple[int, int, int]] = {}
    for element in group:
        if element.tag == f"{_SVG}defs":
            for line in element:
                lines[line.attrib["id"]] = _line(path, line)
        elif element.tag == f"{_SVG}use":
            # As SVG 1.1 writes it, or as SVG 2 does: masks of earlier versions.
            name = (element.get(_HREF) or element.attrib["href"]).removeprefix("#")
            if name in lines:
                yield _dashed(path, element, *lines[name])
                continue
            x, y = _steps(element.attrib["x"]), _steps(element.attrib["y"])
            for shape in tiles[name]:
                yield _array(_box(shape), (x, y))
        elif element.tag == f"{_SVG}rect":
            yield _array(_box(element), (0, 0))
        elif element.tag != f"{_SVG}polygon" or group.get("class") == LAYERS[APERTURE]:
            raise ExportError(f"{path}: {element.tag.removeprefix(_SVG)}: no aperture")


def _line(path: Path, element: ElementTree.Element) -> tuple[int, int, int]:
    """Return width, length and the step of a line's parts: all but the last are as long."""
    parts = _PART.findall(element.attrib["d"])
    if "".join(f"M0 {low}V{high}" for low, high in parts) != element.attrib["d"] or not parts:
        raise ExportError(f"{path}: {element.get('id')}: no line along the grooves")
    ends = [(_steps(low), _steps(high)) for low, high in parts]
    if ends[0][0] != 0 or any(a[1] != b[0] for a, b in pairwise(ends)):
        raise ExportError(f"{path}: {element.get('id')}: a line with gaps")
    return _steps(element.attrib["stroke-width"]), ends[-1][1], ends[0][1]


def _dashed(
    path: Path, element: ElementTree.Element, width: int, length: int, part: int
) -> ApertureArray:
    """Return the rectangles of a dashed line."""
    dash, gap = (_steps(value) for value in element.attrib["stroke-dasharray"].split())
    step = dash + gap
    if min(dash, gap) <= 0 or length % step or (part != length and part % step):
        raise ExportError(f"{path}: a line is no whole number of dashes and gaps")
    left = _steps(element.attrib["x"], 2) - width
    if left % 2:
        raise ExportError(f"{path}: a line's edge is off the 1 nm grid")
    place = Placement(
        (left // 2, _steps(element.attrib["y"])), rows=length // step, row_step=(0, step)
    )
    return ApertureArray((width, dash), place)


def _array(box: Box, by: tuple[int, int], rows: int = 1, step: int = 0) -> ApertureArray:
    place = Placement((box[0] + by[0], box[1] + by[1]), rows=rows, row_step=(0, step))
    return ApertureArray((box[2] - box[0], box[3] - box[1]), place)


def _box(element: ElementTree.Element) -> Box:
    x, y, width, height = (_steps(element.attrib[k]) for k in ("x", "y", "width", "height"))
    return x, y, x + width, y + height


def _polygon_box(points: str) -> Box:
    corners = [tuple(map(_steps, corner.split(","))) for corner in points.split()]
    x, y = zip(*corners, strict=True)
    return min(x), min(y), max(x), max(y)


def _steps(text: str, share: int = 1) -> int:
    """Return a length in mm as grid steps, or as so many to the step.

    Raises
    ------
    ValueError
        when it is off the grid.
    """
    steps = float(text) / GRID * share
    if abs(steps - round(steps)) > OFF_GRID:
        raise ValueError(f"{text}: off the 1 nm grid")
    return round(steps)
