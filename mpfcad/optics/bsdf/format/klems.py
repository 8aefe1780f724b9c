"""Klems XML files, as LBNL's WINDOW 6 and Radiance's genBSDF write them.

`Front` is the side that the light comes from outdoors: here the side of the lamps, below. Bins are
numbered by the (kx, ky) of the way of travel, for light of either side (Radiance, bsdf_m.c); values
are [1/sr], incidence by columns.
"""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis, klems_basis
from mpfcad.optics.bsdf.missing import Matrices
from mpfcad.optics.bsdf.rebin import expand_isotropic
from mpfcad.optics.bsdf.table import ABOVE, BELOW, REFLECT, TRANSMIT, BsdfTable

_DIRECTIONS = {
    "Transmission Front": (TRANSMIT, BELOW),
    "Transmission Back": (TRANSMIT, ABOVE),
    "Reflection Front": (REFLECT, BELOW),
    "Reflection Back": (REFLECT, ABOVE),
}
_NAMESPACE = "http://windows.lbl.gov"


def read_klems(path: Path, root: ElementTree.Element) -> tuple[AngleBasis, Matrices]:
    """Return the basis and the matrices (i, o) [1/sr] that a file's XML has, by (way, side).

    Raises
    ------
    InputError
        when the file is no Klems matrix of visible light, or a matrix is not as its basis says.
    """
    structure = incident_structure(root)
    if structure not in ("columns", "rows"):
        raise InputError(
            f"{path}: IncidentDataStructure: {structure or 'missing'}: expected Columns, Rows, "
            "TensorTree3 or TensorTree4"
        )
    bases = {
        basis.name.lower(): basis for basis in map(_basis_reader(path), root.iter("AngleBasis"))
    }
    found: Matrices = {}
    used: AngleBasis | None = None
    for key, direction, block in visible_blocks(path, root):
        basis = _basis_of(path, block, bases, direction)
        if used is not None and not used.is_same(basis):
            raise InputError(f"{path}: {direction}: basis {basis.name}: expected {used.name}")
        used = basis
        matrix = _matrix(path, block, basis.count, direction)
        found[key] = matrix.T if structure == "columns" else matrix
    assert used is not None  # there is a block, or `visible_blocks` has raised
    return used, found


def incident_structure(root: ElementTree.Element) -> str:
    """Return how incidence is ordered, in lower case: columns, rows, tensortree3, tensortree4."""
    return (root.findtext(".//IncidentDataStructure") or "").strip().lower()


def visible_blocks(
    path: Path, root: ElementTree.Element
) -> list[tuple[tuple[int, int], str, ElementTree.Element]]:
    """Return ((way, side), direction, block) of each block of visible light.

    Raises
    ------
    InputError
        when there is none, or a direction is there twice.
    """
    blocks: list[tuple[tuple[int, int], str, ElementTree.Element]] = []
    for data in _visible(path, root):
        for block in data.iter("WavelengthDataBlock"):
            direction = (block.findtext("WavelengthDataDirection") or "").strip().title()
            if direction not in _DIRECTIONS:
                continue
            key = _DIRECTIONS[direction]
            if any(key == one for one, _, _ in blocks):
                raise InputError(f"{path}: {direction}: is there twice: expected once")
            blocks.append((key, direction, block))
    if not blocks:
        raise InputError(
            f"{path}: no WavelengthDataBlock: expected one of {', '.join(_DIRECTIONS)}"
        )
    return blocks


def _visible(path: Path, root: ElementTree.Element) -> list[ElementTree.Element]:
    """Return the data of visible light."""
    every = list(root.iter("WavelengthData"))
    kinds = [(data.findtext("Wavelength") or "").strip() for data in every]
    visible = [d for d, kind in zip(every, kinds, strict=True) if kind.lower() in ("visible", "")]
    if not visible:
        raise InputError(f"{path}: Wavelength: {', '.join(kinds) or 'missing'}: expected Visible")
    return visible


def _basis_reader(path: Path):
    def read(element: ElementTree.Element) -> AngleBasis:
        name = (element.findtext("AngleBasisName") or "").strip()
        blocks = list(element.iter("AngleBasisBlock"))
        try:
            edge = [float(b.findtext("ThetaBounds/UpperTheta") or "") for b in blocks]
            azimuths = [int(b.findtext("nPhis") or "") for b in blocks]
        except (TypeError, ValueError):
            raise InputError(f"{path}: AngleBasis {name}: needs UpperTheta and nPhis") from None
        if not edge or np.any(np.diff([0.0, *edge]) <= 0) or abs(edge[-1] - 90) > 1e-6:
            raise InputError(f"{path}: AngleBasis {name}: UpperTheta: expected to rise to 90")
        if min(azimuths) < 1:
            raise InputError(
                f"{path}: AngleBasis {name}: nPhis {min(azimuths)}: expected from 1 up"
            )
        edge[-1] = 90.0
        return AngleBasis(name, np.radians([0.0, *edge]), np.array(azimuths, np.int64))

    return read


def _basis_of(
    path: Path, block: ElementTree.Element, bases: dict[str, AngleBasis], direction: str
) -> AngleBasis:
    column = (block.findtext("ColumnAngleBasis") or "").strip()
    row = (block.findtext("RowAngleBasis") or "").strip()
    if column != row:
        raise InputError(
            f"{path}: {direction}: RowAngleBasis {row!r}: expected the ColumnAngleBasis {column!r}"
        )
    if column.lower() in bases:
        return bases[column.lower()]
    try:
        return klems_basis(column)
    except InputError as error:
        raise InputError(f"{path}: {direction}: {error}") from None


def _matrix(
    path: Path, block: ElementTree.Element, count: int, direction: str
) -> NDArray[np.float64]:
    text = (block.findtext("ScatteringData") or "").replace(",", " ").split()
    if len(text) != count * count:
        raise InputError(
            f"{path}: {direction}: {len(text)} values: expected {count} x {count} = {count**2}"
        )
    try:
        return np.array(text, float).reshape(count, count)
    except ValueError as error:
        raise InputError(f"{path}: {direction}: {error}") from None


def klems_xml(table: BsdfTable) -> str:
    """Return a table as the text of a Klems XML file; numbers read back as the same bits."""
    table = expand_isotropic(table)
    root = ElementTree.Element("WindowElement", xmlns=_NAMESPACE)
    _add(root, "WindowElementType", "System")
    _add(root, "FileType", "BSDF")
    layer = _add(_add(root, "Optical"), "Layer")
    material = _add(layer, "Material")
    _add(material, "Name", table.name)
    _add(material, "Manufacturer", "mpfcad")
    # WINDOW's parser refuses a material without thickness; a table stands for a thin element.
    _add(material, "Thickness", "0").set("unit", "Millimeter")
    _add(material, "DeviceType", "Other")
    definition = _add(layer, "DataDefinition")
    _add(definition, "IncidentDataStructure", "Columns")
    _add_basis(_add(definition, "AngleBasis"), table.basis)
    for direction, (way, side) in _DIRECTIONS.items():
        data = _add(layer, "WavelengthData")
        _add(data, "LayerNumber", "System")
        _add(data, "Wavelength", "Visible").set("unit", "Integral")
        _add(data, "SourceSpectrum", "CIE Illuminant D65 1nm.ssp")
        _add(data, "DetectorSpectrum", "ASTM E308 1931 Y.dsp")
        block = _add(data, "WavelengthDataBlock")
        _add(block, "WavelengthDataDirection", direction)
        _add(block, "ColumnAngleBasis", table.basis.name)
        _add(block, "RowAngleBasis", table.basis.name)
        _add(block, "ScatteringDataType", "BTDF" if way == TRANSMIT else "BRDF")
        rows = (", ".join(map(repr, row)) for row in table.value[way, side].T.tolist())
        _add(block, "ScatteringData", "\n" + ",\n".join(rows) + "\n")
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode") + "\n"


def _add_basis(element: ElementTree.Element, basis: AngleBasis) -> None:
    _add(element, "AngleBasisName", basis.name)
    edge = [f"{e:.10g}" for e in np.degrees(basis.edge)]
    for r, polar in enumerate(np.degrees(basis.polar)):
        block = _add(element, "AngleBasisBlock")
        _add(block, "Theta", f"{polar:.10g}")
        _add(block, "nPhis", str(basis.azimuths[r]))
        bounds = _add(block, "ThetaBounds")
        _add(bounds, "LowerTheta", edge[r])
        _add(bounds, "UpperTheta", edge[r + 1])


def _add(parent: ElementTree.Element, tag: str, text: str | None = None) -> ElementTree.Element:
    child = ElementTree.SubElement(parent, tag)
    child.text = text
    return child
