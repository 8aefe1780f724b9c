"""The report's section on film.step and film.stl: figures, drawings, the film in 3-D."""

from typing import Any

from markupsafe import Markup, escape

from mpfcad.report.drawing.film.dimension_drawing import draw_dimensions
from mpfcad.report.drawing.film.groove_drawing import draw_grooves
from mpfcad.report.drawing.plot import plot
from mpfcad.report.film.evidence import Evidence
from mpfcad.report.page.number import number

Record = dict[str, Any]


def cad_values(record: Record, evidence: Evidence) -> dict[str, Any]:
    """Return what film.step and film.stl hold, and a few grooves in cross-section."""
    traced = evidence.folder / evidence.traced
    kind, readable = evidence.kind, bool(record["mesh"] or record.get("library"))
    drawn = kind.shows_grooves and readable
    made = kind.as_grooves(evidence.piece)
    return {
        "rows": _rows(record, evidence),
        "view": plot(kind.view(traced), "grooves") if readable else None,
        "view_words": kind.view_words,
        "dimensions": draw_dimensions(made, 0),
        "section_title": kind.section_title,
        "grooves": draw_grooves(traced, made, evidence.shown_groove) if drawn else None,
    }


def _rows(record: Record, evidence: Evidence) -> list[tuple[str, Any]]:
    # A file that does not read back has no figures: each is "not applicable".
    nothing: dict[str, Any] = {}
    step, mesh, pair = (record[key] or nothing for key in ("step", "mesh", "step_mesh"))
    place = f"x = 0 is {evidence.piece.origin:.6g} mm from the panel's edge"
    if evidence.traced != "film.stl":
        return _library_rows(record, evidence)
    bodies = ", ".join(f"{n} {v:.6g} mm³" for n, v in step.get("bodies_volume_mm3", {}).items())
    return [
        ("both: extent", f"{evidence.kind.extent}; {place}"),
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


def _library_rows(record: Record, evidence: Evidence) -> list[tuple[str, Any]]:
    """Return what the films of instances hold, that in the job's place and that across."""
    rows: list[tuple[str, Any]] = [(f"{evidence.traced}: extent", evidence.kind.extent)]
    across = record.get("crossed")
    for name, found in ((evidence.traced, record), ("film-crossed.3mf", across)):
        if not found:
            continue
        library = found["library"] or {}
        rows += [
            (f"{name}: pieces, facets in all of them",
             _pair(library.get("pieces"), library.get("triangle_count"), "")),
            (f"{name}: C by its corners, least / largest",
             _pair(library.get("curvature_min_per_mm"), library.get("curvature_max_per_mm"),
                   " /mm")),
            (f"mask against {name}: largest difference of C",
             _quantity(found["mask_mesh_curvature_difference_per_mm"], " /mm")),
        ]  # fmt: skip
    return rows


def _pair(first: float | None, second: float | None, unit: str) -> Markup:
    return _quantity(first, unit) + " / " + _quantity(second, unit)


def _quantity(value: float | None, unit: str = "") -> Markup:
    return escape("not applicable") if value is None else number(value, 3) + unit
