"""The report's section on film.step and film.stl: figures, drawings, the film in 3-D."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from mpfcad.film import CellFilm, FieldPiece
from mpfcad.report.drawing.cell_view import cell_view
from mpfcad.report.drawing.dimension_drawing import draw_dimensions
from mpfcad.report.drawing.field_view import field_view
from mpfcad.report.drawing.groove_drawing import draw_grooves
from mpfcad.report.drawing.groove_view import groove_view
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.evidence import Evidence
from mpfcad.report.page.number import number

if TYPE_CHECKING:
    import plotly.graph_objects as go

Record = dict[str, Any]


def cad_values(record: Record, evidence: Evidence) -> dict[str, Any]:
    """Return what film.step and film.stl hold, and a few grooves in cross-section."""
    stl = evidence.folder / "film.stl"
    cells = isinstance(evidence.drawn, CellFilm)
    title = "A section through the cells' tips" if cells else "The first groove of the piece"
    readable = record["mesh"] is not None
    return {
        "rows": _rows(record, evidence),
        "view": plot(_shown(stl, evidence), "grooves") if readable else None,
        "view_words": _view_words(evidence),
        "dimensions": draw_dimensions(evidence.made, 0),
        "section_title": title,
        "grooves": None
        if cells or not readable
        else draw_grooves(stl, evidence.made, evidence.shown_groove),
    }


def _rows(record: Record, evidence: Evidence) -> list[tuple[str, Any]]:
    # A file that does not read back has no figures: each is "not applicable".
    nothing: dict[str, Any] = {}
    step, mesh, pair = (record[key] or nothing for key in ("step", "mesh", "step_mesh"))
    bodies = ", ".join(f"{n} {v:.6g} mm³" for n, v in step.get("bodies_volume_mm3", {}).items())
    return [
        ("both: extent", _extent(evidence)),
        ("film.step: bodies", bodies or "none read back"),
        ("film.step: largest relative error of a volume", _quantity(step.get("volume_error"))),
        ("film.stl: facets", _quantity(mesh.get("triangle_count"))),
        ("film.stl: relative error of the volume", _quantity(mesh.get("volume_error"))),
        ("film.stl: facet normals, rms / of the facet nearest to its limit",
         _pair(mesh.get("normal_error_deg_rms"), mesh.get("normal_error_deg_max"), "°")),
        ("film.stl: slopes against the profile's secants, rms / of the worst groove",
         _pair(mesh.get("secant_error_deg_rms"), mesh.get("secant_error_deg_rms_worst_groove"),
               "°")),
        ("film.stl against film.step: largest distance / difference of volume",
         _quantity(pair.get("distance_um_max"), " µm") + " / "
         + _quantity(pair.get("volume_difference"))),
        ("mask against film.stl: largest difference of C",
         _quantity(record["mask_mesh_curvature_difference_per_mm"], " /mm")),
    ]  # fmt: skip


def _shown(stl: Path, evidence: Evidence) -> "go.Figure":
    """Return the drawing of film.stl in three dimensions."""
    if isinstance(evidence.drawn, CellFilm):
        return cell_view(stl, evidence.drawn)
    if isinstance(evidence.drawn, FieldPiece):
        return field_view(stl, evidence.drawn)
    return groove_view(stl, evidence.made)


def _view_words(evidence: Evidence) -> str:
    what = "Cells" if isinstance(evidence.drawn, CellFilm) else "Grooves"
    how = "in true proportion"
    if isinstance(evidence.drawn, FieldPiece):
        how = "over its whole length, drawn shortened; a section is in true proportion"
    return (
        f"{what} in the middle of the piece {how}; turn with the mouse. The surface is that of "
        "film.stl; the base goes on below."
    )


def _extent(evidence: Evidence) -> str:
    """Return size and number of what the CAD files hold, and where it lies on the panel."""
    place = f"x = 0 is {evidence.piece.origin:.6g} mm from the panel's edge"
    if isinstance(evidence.drawn, CellFilm):
        cells = evidence.drawn
        size = (*cells.size, cells.thickness)
        number = f"{cells.count[0]} × {cells.count[1]} cells"
    elif isinstance(evidence.drawn, FieldPiece):
        piece = evidence.drawn
        size, number = (*piece.size, piece.thickness), f"{piece.groove_count} grooves"
        place += f", y = 0 {piece.origin[1]:.6g} mm"
    else:
        film = evidence.made.film
        size, number = (film.width, film.length, film.thickness), f"{film.groove_count} grooves"
    return " × ".join(f"{part:.6g}" for part in size) + f" mm, {number}; {place}"


def _pair(first: float | None, second: float | None, unit: str) -> Markup:
    return _quantity(first, unit) + " / " + _quantity(second, unit)


def _quantity(value: float | None, unit: str = "") -> Markup:
    return escape("not applicable") if value is None else number(value, 3) + unit
