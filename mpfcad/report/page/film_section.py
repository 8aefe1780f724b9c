"""What the report shows of the film: curvature, fill and aperture over the piece."""

from typing import Any

from mpfcad.film import CellFilm, FieldPiece
from mpfcad.report.drawing.field_view import field_figure
from mpfcad.report.drawing.figure import film_figure
from mpfcad.report.drawing.plot import plot
from mpfcad.report.page.evidence import Evidence
from mpfcad.units import um

_CAPTION = (
    "C of z = z_{0} + C/2 · x² through the tips, and the value a profiler's least-squares fit "
    "reports; fill = resin area / groove area; aperture ratio = open area / cell area, as read "
    "back from the mask file."
)


def film_values(record: dict[str, Any], evidence: Evidence) -> dict[str, Any]:
    """Return the kind of film, its figures, and its plot where it has one."""
    drawn, piece = evidence.drawn, evidence.piece
    if isinstance(drawn, CellFilm):
        return {
            "kind": "cell",
            "plot": None,
            "shape": drawn.shape,
            "pitch_um": f"{piece.groove.pitch / um:g}",
            "curvature": f"{drawn.curvature:g}",
        }
    if isinstance(drawn, FieldPiece):
        return {
            "kind": "field",
            "range": _range(drawn.curvature),
            "count": drawn.groove_count,
            "across": f"{drawn.origin[0]:.6g}",
            "along": f"{drawn.origin[1]:.6g}",
            "plot": plot(field_figure(drawn), "film"),
            "caption": "C of z = z_{0} + C/2 · x² through the tips, over the piece that is drawn.",
        }
    if piece.profile == "ideal":
        figure = film_figure(evidence.position, piece.curvature, piece.curvature, [], None, None)
        return {
            "kind": "ideal",
            "plot": plot(figure, "film"),
            "caption": "Curvature of each groove.",
        }
    figure = film_figure(
        evidence.position,
        piece.curvature,
        piece.groove.fitted_curvature(piece.curvature, piece.profile),
        piece.fill_fraction,
        evidence.aperture_ratio,
        record["mask"] and next(iter(record["mask"]["curvature"]["recovered_per_mm"].values())),
    )
    return {
        "kind": "groove",
        "range": _range(piece.curvature),
        "count": piece.groove_count,
        "limit": f"{piece.groove.curvature_empty:g}",
        "plot": plot(figure, "film"),
        "caption": _CAPTION,
    }


def _range(curvature: Any) -> str:
    return f"{curvature.min():.4g} … {curvature.max():.4g}"
