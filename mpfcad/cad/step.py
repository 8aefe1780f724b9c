"""Write the film as a STEP file (AP214) in mm: an assembly of the bodies `BEF` and `fill`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from mpfcad.cad.step_colour import colour_bodies
from mpfcad.errors import ExportError
from mpfcad.film import PrismFilm

if TYPE_CHECKING:
    from OCP.StepData import StepData_StepModel
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopoDS import TopoDS_Shape

#: The bodies' names and their colours (red, green, blue; 0…1).
COLOURS = {"BEF": (0.62, 0.74, 0.86), "fill": (0.96, 0.72, 0.26)}
#: The header's time: fixed, so that the same film gives the same bytes.
TIMESTAMP = "2000-01-01T00:00:00"


def write_step(film: PrismFilm, path: Path, *, name: str = "film") -> None:
    """Write the prism film (`BEF`) and the resin (`fill`, one solid a groove) with exact parabolas.

    Without any resin there is no `fill`. Same film and name, same bytes.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    ExportError
        when OCCT refuses to write.
    """
    from mpfcad.cad import solid

    path = Path(path)
    bodies = {"BEF": solid.build_prism(film), "fill": solid.build_fill(film)}
    bodies = {body: shape for body, shape in bodies.items() if shape is not None}
    label = name.encode("ascii", "replace").decode()
    part = path.with_name("." + path.name + ".part")
    try:
        _write(bodies, part, label)
        colour_bodies(part, [COLOURS[body] for body in bodies])
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _write(bodies: dict[str, TopoDS_Shape], path: Path, name: str) -> None:
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_AsIs

    mute_occt()
    document = _document(bodies, name)
    writer = STEPCAFControl_Writer()
    # Only after the writer exists: OCCT drops settings made before without a word.
    Interface_Static.SetCVal_s("write.step.schema", "AP214IS")
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    writer.SetColorMode(False)
    writer.SetNameMode(True)
    if not writer.Transfer(document, STEPControl_AsIs):
        raise ExportError(f"{name}: OCCT cannot turn the film into STEP")
    model = writer.ChangeWriter().Model()
    _set_header(model, name)
    _number_components(model)
    if writer.Write(str(path)) != IFSelect_RetDone:
        raise ExportError(f"{path.name}: OCCT cannot write this file")


def _document(bodies: dict[str, TopoDS_Shape], name: str) -> TDocStd_Document:
    """Return an assembly called `name` of the named bodies."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = new_document()
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    assembly = shapes.NewShape()
    TDataStd_Name.Set_s(assembly, TCollection_ExtendedString(name))
    for body, shape in bodies.items():
        part = shapes.AddShape(shape, False)
        place = shapes.AddComponent(assembly, part, TopLoc_Location())
        for label in (part, place):
            TDataStd_Name.Set_s(label, TCollection_ExtendedString(body))
    shapes.UpdateAssemblies()
    return document


def _set_header(model: StepData_StepModel, name: str) -> None:
    """Fill the header with what is true of every machine."""
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.TCollection import TCollection_HAsciiString as Text

    header = APIHeaderSection_MakeHeader(model)
    header.SetName(Text(name))
    header.SetTimeStamp(Text(TIMESTAMP))
    header.SetAuthorValue(1, Text(""))
    header.SetOrganizationValue(1, Text(""))
    header.SetPreprocessorVersion(Text("mpfcad"))
    header.SetOriginatingSystem(Text("mpfcad"))
    header.SetAuthorisation(Text(""))
    header.SetDescriptionValue(1, Text("Multi-performance film; unit mm; x across, y along, z up"))


def _number_components(model: StepData_StepModel) -> None:
    """Count the assembly's components from 1; OCCT goes on from the last file it wrote."""
    from OCP.StepRepr import StepRepr_NextAssemblyUsageOccurrence
    from OCP.TCollection import TCollection_HAsciiString

    entities = (model.Value(index) for index in range(1, model.NbEntities() + 1))
    components = [e for e in entities if isinstance(e, StepRepr_NextAssemblyUsageOccurrence)]
    for number, component in enumerate(components, 1):
        component.SetId(TCollection_HAsciiString(str(number)))


def new_document() -> TDocStd_Document:
    """Return an empty OCCT document in mm."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)
    # Without this every label gets a name of its own kind ("SOLID", "COMPOUND").
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).SetAutoNaming_s(False)
    return document


def mute_occt() -> None:
    """Keep OCCT's chatter about transfers off the terminal; failures still show."""
    from OCP.Message import Message, Message_Fail

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Fail)
