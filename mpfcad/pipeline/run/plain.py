"""The plain prism film in the job's own backlight: what the resin is there for."""

import tempfile
from pathlib import Path

import numpy as np

from mpfcad.film import PrismFilm
from mpfcad.measure import (
    CellResult,
    Lit,
    LuminanceResult,
    TraceRun,
    light_film,
    luminance_over_cell,
    luminance_over_pitch,
)
from mpfcad.pipeline.effort import over_pitches
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.size import groove_count

#: A luminance over what repeats: the lamp pitch, or a cell of LEDs.
Traced = LuminanceResult | CellResult
#: Half of the 95 % interval of the contrast at which its trace ends: its lamps show plainly.
PLAIN_GOAL = 0.004


def trace_luminance(lit: Lit, run: TraceRun, half_width_goal: float) -> Traced:
    """Return the luminance over a lamp pitch or, under LEDs, over a cell."""
    if lit.is_cell:
        return luminance_over_cell(lit, run, half_width_goal=half_width_goal)
    return luminance_over_pitch(lit, over_pitches(run, lit), half_width_goal=half_width_goal)


def trace_plain(plan: Plan, folder: Path, run: TraceRun, half_width_goal: float) -> Traced:
    """Return the light of the job's prisms without resin, written to a file and read back.

    `folder` holds the meshes that the stack needs besides the film's.
    """
    from mpfcad.cad import write_stl

    stack = plan.stack.with_files_in(folder)
    with tempfile.TemporaryDirectory() as temporary:
        mesh = Path(temporary) / "plain.stl"
        write_stl(_plain_film(plan), mesh, plan.job.cad.angle_tolerance)
        goal = max(half_width_goal, PLAIN_GOAL)
        return trace_luminance(light_film(stack.with_bare(mesh), mesh), run, goal)


def _plain_film(plan: Plan) -> PrismFilm:
    """Return one lamp pitch of the job's prisms without resin, or one groove under LEDs."""
    groove, period = plan.piece.groove, plan.stack.period
    count = 1 if period.along > 0 else groove_count(period.across, groove.pitch)
    empty = np.full(count, groove.curvature_empty)
    return PrismFilm(groove, plan.piece.base, 2.0, "filled", empty)
