"""How the facets of film.stl close in on the film as they get finer."""

import tempfile
from pathlib import Path
from typing import Any

from mpfcad.errors import MpfcadError
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.units import deg

#: Tolerances in terms of the job's own, and grooves that they are tried on.
FACTORS = (8.0, 4.0, 2.0, 1.0, 0.5)
GROOVES = 12
_COARSEST_DEG, _FINEST_DEG = 5.0, 0.01


def facet_convergence(plan: Plan) -> list[dict[str, Any]] | None:
    """Return what a few grooves' mesh is like at coarser and finer facets, in outside names.

    Each mesh is written to a file and read back. None for a film that is one piece, whose mesh
    takes long, and for one whose mesh float32 cannot hold at any of these.
    """
    rows: list[dict[str, Any]] = []
    for factor in FACTORS:
        degrees = plan.job.cad.angle_tolerance_deg * factor
        if not _FINEST_DEG <= degrees <= _COARSEST_DEG:
            continue
        table = plan.job.cad.model_copy(update={"angle_tolerance_deg": degrees})
        film = kind_of(plan.drawn, table)
        first = max(0, (plan.piece.groove_count - GROOVES) // 2)
        count = min(GROOVES, plan.piece.groove_count)
        few = film.tile(first, count)
        if few is None:
            return None
        with tempfile.TemporaryDirectory() as temporary:
            path = Path(temporary) / "few.stl"
            try:
                few.write(path, plan.job.name)
                check = few.check_mesh(path)
            except MpfcadError:  # finer than float32: the shipped file is not
                continue
        row = {
            "angle_tolerance_deg": degrees,
            "facets_per_groove": check.triangle_count / count,
            "normal_error_deg_max": check.normal_error_max / deg,
            "volume_error": check.volume_error,
        }
        # Facets are no wider than the volume allows: a coarser angle may give the same mesh.
        if rows and rows[-1]["facets_per_groove"] == row["facets_per_groove"]:
            rows.pop()
        rows.append(row)
    return rows or None
