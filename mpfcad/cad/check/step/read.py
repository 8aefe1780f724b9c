"""Read the bodies of a STEP file with OCCT, by name and as they are."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.errors import ExportError

if TYPE_CHECKING:
    from OCP.collections import DataMap_TCollection_AsciiString_TCollection_AsciiString
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopoDS import TopoDS_Shape

#: What OCCT may not do to the file's shapes (parameters of its operator FixShape): repair them. It
#: adds what a STEP file need not or cannot state: the curves that faces need in their own
#: parameters, and edges without length where a patch shrinks to a point (FixDegenerated).
REPAIRS = (
    *("FixFreeShell", "FixFreeFace", "FixFreeWire", "FixSameParameter", "FixShellOrientation"),
    *("FixFaceOrientation", "FixOrientation", "FixAddNaturalBound", "FixMissingSeam"),
    *("FixSmallAreaWire", "FixIntersectingWires", "FixLoopWires", "FixSplitFace", "FixReorder"),
    *("FixSmall", "FixConnected", "FixLacking", "FixSelfIntersection"),
    *("FixVertexPosition", "FixVertexTolerance"),
)


def read_bodies(path: Path, *, repair: bool) -> dict[str, TopoDS_Shape]:
    """Return the bodies in the file by name, read with OCCT: as they are, or as OCCT repairs them.

    Raises
    ------
    ExportError
        when the file cannot be read, or two bodies have one name.
    """
    bodies = read_instances(path, repair=repair)
    for name, shapes in bodies.items():
        if len(shapes) > 1:
            raise ExportError(f"{path.name}: two bodies named {name}")
    return {name: shapes[0] for name, shapes in bodies.items()}


def read_instances(path: Path, *, repair: bool) -> dict[str, list[TopoDS_Shape]]:
    """Return all bodies of each name, where they stand.

    Edges of patches have curves in the patch that OCCT computes itself; it then has to fit them.
    """
    from OCP.collections import Sequence_TDF_Label
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    _mute_occt()
    document = _new_document()
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    # Names alone are compared: what else a file may say is not even looked for.
    for mode in ("Color", "Layer", "Props", "GDT", "Mat", "View", "SHUO"):
        getattr(reader, f"Set{mode}Mode")(False)
    found = reader.ReadFile(str(path)) == IFSelect_RetDone
    # Reading resets them.
    if not repair:
        reader.SetShapeFixParameters(_without_repairs())
    if not found or not reader.Transfer(document):
        raise ExportError(f"{path.name}: OCCT cannot read this file")
    roots = Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    bodies: dict[str, list[TopoDS_Shape]] = {}
    for index in range(1, roots.Length() + 1):
        for name, shape in _parts(roots.Value(index)):
            bodies.setdefault(name, []).append(shape)
    return bodies


def _without_repairs() -> DataMap_TCollection_AsciiString_TCollection_AsciiString:
    """Return OCCT's parameters of shape processing with every repair switched off."""
    from OCP.collections import DataMap_TCollection_AsciiString_TCollection_AsciiString
    from OCP.TCollection import TCollection_AsciiString

    parameters = DataMap_TCollection_AsciiString_TCollection_AsciiString()
    for repair in REPAIRS:
        key = TCollection_AsciiString(f"FixShape.{repair}Mode")
        parameters.Bind(key, TCollection_AsciiString("0"))
    return parameters


def _parts(label: TDF_Label) -> Iterator[tuple[str, TopoDS_Shape]]:
    """Yield the name and shape of each part under a label of an OCCT document."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.TDataStd import TDataStd_Name
    from OCP.XCAFDoc import XCAFDoc_ShapeTool

    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        components = Sequence_TDF_Label()
        XCAFDoc_ShapeTool.GetComponents_s(label, components)
        for index in range(1, components.Length() + 1):
            yield from _parts(components.Value(index))
        return
    name = TDataStd_Name()
    found = label.FindAttribute(TDataStd_Name.GetID_s(), name)
    yield name.Get().ToExtString() if found else "", XCAFDoc_ShapeTool.GetShape_s(label)


def _new_document() -> TDocStd_Document:
    """Return an empty OCCT document in mm."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)
    return document


def _mute_occt() -> None:
    """Keep OCCT's chatter about transfers off the terminal; failures still show."""
    from OCP.Message import Message, Message_Fail

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Fail)
