"""What a run will need: files, memory, and at most how many paths; said, or refused before work."""

from dataclasses import dataclass

from mpfcad.errors import InputError
from mpfcad.pipeline.effort import TRACE_SETTINGS
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.size import most_triangles

#: Memory of a run without its film [GB]; of a groove of film.step in the CAD kernel, and of
#: a triangle of the mesh while it is checked [bytes]. Measured on 80 and 7846 grooves; paths take
#: none of it, they are traced in blocks.
_BASE, _GROOVE, _TRIANGLE = 0.9, 110_000, 400
#: Time of a groove in STEP, its check and comparison, and of a triangle [s], on one core.
_GROOVE_TIME, _TRIANGLE_TIME = 0.012, 2e-6


@dataclass(frozen=True)
class Need:
    """What a run needs at most.

    Attributes
    ----------
    grooves, triangles
        of the piece in film.step and film.stl
    memory_gb
        of the process
    file_minutes
        for the CAD files and their checks, on one core
    paths
        of all traces, at most
    """

    grooves: int
    triangles: int
    memory_gb: float
    file_minutes: float
    paths: int

    def trace_minutes(self, million_paths_per_second: float) -> float:
        """Return how long all traces take at most."""
        return self.paths / 1e6 / million_paths_per_second / 60


def run_need(plan: Plan, effort: str) -> Need:
    """Return what a run of a plan needs at most."""
    grooves = plan.piece.groove_count
    triangles = most_triangles(plan.job, grooves)
    memory = _BASE + (_GROOVE * grooves + _TRIANGLE * triangles) / 1e9
    seconds = _GROOVE_TIME * grooves + _TRIANGLE_TIME * triangles
    # The film, its prisms without resin, and a film of another backlight where the job asks for it.
    traces = 2 + (plan.job.baseline is not None)
    paths = traces * TRACE_SETTINGS[effort].path_limit
    return Need(grooves, triangles, memory, seconds / 60, paths)


def available_memory() -> float:
    """Return the memory [GB] that this machine can give now."""
    import psutil

    return float(psutil.virtual_memory().available) / 1e9


def refuse_memory(need: Need, where: str) -> None:
    """Refuse a run that needs more memory than there is.

    Raises
    ------
    InputError
        naming what is there, and how many grooves fit.
    """
    there = available_memory()
    if need.memory_gb <= there:
        return
    share = max(there - _BASE, 0.0) / (need.memory_gb - _BASE)
    raise InputError(
        f"{where}: cad.extent: {need.grooves} grooves need {need.memory_gb:.1f} GB of memory: "
        f"expected at most {there:.1f} GB, about {int(share * need.grooves)} grooves (cad.extent = "
        "'pitch'), or a larger cad.angle_tolerance_deg"
    )
