"""One point of a sweep: its film is made, read back and traced; the same wherever it is done."""

import tempfile
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.backlight import Stack
from mpfcad.boundary import guarded
from mpfcad.errors import InputError
from mpfcad.film import Groove
from mpfcad.job import FilmTable, GateTable, build_job
from mpfcad.job.reader import validate
from mpfcad.job.sweep import FILL_AXIS, LAMP_AXIS, LED_AXES, REGISTRATION_AXES, Sweep
from mpfcad.pipeline.confidence.covariance import with_covariance
from mpfcad.pipeline.confidence.find import refuse_cell_confidence
from mpfcad.pipeline.plan.departure import Departure
from mpfcad.pipeline.plan.plan import Plan, read_job_stack, read_plan
from mpfcad.pipeline.plan.printed.printable import printable_range
from mpfcad.pipeline.point.led import compile_for_cell, departure_of, trace_cell_point
from mpfcad.pipeline.point.thickness_limit import spread_lamps
from mpfcad.pipeline.point.tube import trace_tube_point
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import job_rules
from mpfcad.record.printing import PHOTOTOOL_ONLY
from mpfcad.store import work_key

#: Kind of entry of a point in the store.
POINT = "point"
_SEARCH = ("goal", "constraint", "search")
#: Fields of a plan that name files.
_NAMES = ("job", "input_file", "crossed", "where")
_TUBE_AXES = (FILL_AXIS, LAMP_AXIS, *REGISTRATION_AXES)
#: Fields of a point's job that name files beside the sweep.
_FILES = (
    ("map", "file"),
    ("process", "calibration"),
    ("stack", "file"),
    ("confidence", "covariance"),
)
#: Stands for the map until a design has found it.
_ANY_CURVATURE = 50.0


@dataclass(frozen=True)
class Point:
    """A point that can be traced by any process that sees the files it names.

    Attributes
    ----------
    coordinate
        value of each axis
    job
        document of its job, its files by absolute path
    where
        name of the sweep's file, for messages
    design
        document of the design that finds its map; None where the job has one
    half_width, path_limit
        when its trace ends
    """

    coordinate: dict[str, Any]
    job: dict[str, Any]
    where: str
    half_width: float
    path_limit: int
    design: dict[str, Any] | None = None

    def plan(self) -> Plan:
        """Return everything that is made of it.

        Raises
        ------
        InputError
            naming the point and what is wrong.
        """
        file = Path(self.where)
        try:
            job = with_covariance(build_job(self.job, self.where), file)
            stack = read_job_stack(job, file)
            if job.wants_confidence:
                refuse_cell_confidence(stack)
            if stack.period.along > 0:
                return read_plan(job, file, self._departure(stack))
            _refuse_led_axes(self.coordinate, self.where)
            return read_plan(job, file)
        except InputError as error:
            raise InputError(f"{error} (at {describe_coordinate(self.coordinate)})") from None

    def _departure(self, stack: Stack) -> Departure:
        if self.design is not None:
            raise InputError(
                f"{self.where}: design: LEDs light the stack {stack.name}: expected a map, or "
                "mpfcad design with kind 'leds'"
            )
        return departure_of(stack, self.coordinate, self.where)

    @property
    def is_cell(self) -> bool:
        """Whether LEDs light it."""
        return self.plan().stack.period.along > 0

    def key(self) -> str:
        """Return the key of its result: its plan and settings by value, files by their content."""
        plan = self.plan()
        return work_key(
            "point",
            {
                "coordinate": self.coordinate,
                "plan": [_resolved(film) for film in plan.films],
                "stack_files": plan.stack.files(),
                "job": {k: _without_paths(v) for k, v in plan.job.document().items()},
                "trace": [self.half_width, self.path_limit],
                "design": self.design and {k: self.design[k] for k in _SEARCH if k in self.design},
            },
        )


def _resolved(plan: Plan) -> dict[str, Any]:
    """Return a plan by what is in it.

    Not the path of a file: what is in it stands in the plan, and the sweep's own file also names
    the other points.
    """
    return {f.name: getattr(plan, f.name) for f in fields(plan) if f.name not in _NAMES}


def _refuse_led_axes(coordinate: dict[str, Any], where: str) -> None:
    wrong = [axis for axis in coordinate if axis in LED_AXES and axis not in _TUBE_AXES]
    if wrong:
        raise InputError(
            f"{where}: axis {wrong[0]}: tubes light the stack: expected table.field of a job or "
            f"one of {', '.join(_TUBE_AXES)}"
        )


def _without_paths(table: Any) -> Any:
    if not isinstance(table, dict):
        return table
    return {k: v for k, v in table.items() if k not in ("file", "calibration", "measured_file")}


def describe_coordinate(coordinate: dict[str, Any]) -> str:
    """Return the values of the axes as text."""
    return ", ".join(
        f"{name} = {value:g}" if isinstance(value, float) else f"{name} = {value}"
        for name, value in coordinate.items()
    )


def build_point(sweep: Sweep, file: Path, coordinate: dict[str, Any]) -> Point:
    """Return a point of a sweep."""
    with guarded(file, "a sweep of a job's values"):
        return _build_point(sweep, file, coordinate)


def _build_point(sweep: Sweep, file: Path, coordinate: dict[str, Any]) -> Point:
    document = sweep.job_document(coordinate)
    if "confidence" in document:
        limit = sweep.contrast_limit
        least = min(limit, GateTable().contrast_pass)
        document["gates"] = {"contrast_pass": least, "contrast_marginal": limit}
    for table, key in _FILES:
        name = document.get(table, {}).get(key)
        if isinstance(name, str):
            document[table][key] = str((file.parent / name).resolve())
    if FILL_AXIS in coordinate:
        groove = validate(FilmTable, document.get("film", {}), f"{file}: film").groove
        fill = coordinate[FILL_AXIS]
        if not 0 <= fill < 1:
            raise InputError(f"{file}: axis.{FILL_AXIS}: {fill:g}: expected 0 up to below 1")
        document["map"] = {"curvature_per_mm": float(groove.curvature_of_fill(fill))}
    if LAMP_AXIS in coordinate:
        _spread_lamps(document, file, coordinate[LAMP_AXIS])
    design = None
    if sweep.design is not None:
        tables = sweep.design.model_dump(mode="json", exclude_unset=True)
        design = {**document, **tables}
        document = {**document, "map": {"curvature_per_mm": _ANY_CURVATURE}}
    trace = sweep.trace
    limit = round(trace.paths_million * 1e6)
    return Point(coordinate, document, str(file), trace.half_width, limit, design)


def _spread_lamps(document: dict[str, Any], file: Path, count: float) -> None:
    """Write so many lamps, evenly over the panel's width, into a job's document."""
    if count < 1 or count != int(count):
        raise InputError(
            f"{file}: axis.{LAMP_AXIS}: {count:g}: expected a whole number of 1 or more"
        )
    job = build_job({**document, "map": {"curvature_per_mm": _ANY_CURVATURE}}, str(file))
    stack = read_job_stack(job, file)
    if stack.period.along > 0:
        departure_of(stack, {LAMP_AXIS: count}, str(file))
    width = stack.panel_width
    override = document.setdefault("stack", {}).setdefault("override", {})
    override.update(spread_lamps(width, int(count)))


def conventional_point(like: Point, seed: int) -> Point:
    """Return the conventional stack with a plain BEF, an empty groove, traced as long as `like`."""
    empty = Groove(0.050, 0.025).curvature_empty
    job = {
        "schema": 1,
        "name": "conventional",
        "seed": seed,
        "map": {"curvature_per_mm": empty},
        "stack": {"preset": "thesis-32in-conventional"},
    }
    return Point({}, job, like.where, like.half_width, like.path_limit)


def describe_point_screen(plan: Plan) -> str | None:
    """Return the screen that prints a point's film, or why it does not; None: no print makes it."""
    if plan.process is None:
        return None
    job = plan.job
    if job.mask.mesh is None:
        return PHOTOTOOL_ONLY
    rules = job_rules(job, plan.field_film or plan.panel, plan.process, plan.where)
    assert rules.mesh is not None  # the job names one
    try:
        low, high = printable_range(plan.process, rules, job.gates, job.name)
    except InputError as error:
        return f"not printed: {error}"
    curvature = plan.curvature
    found = curvature[plan.panel.groove.takes_resin(curvature)]
    if found.size and (found.min() < low or found.max() > high):
        return (
            f"not printed by {rules.mesh.name}: C {found.min():.4g} … {found.max():.4g} /mm: "
            f"expected {low:.4g} … {high:.4g}"
        )
    return rules.mesh.name


def compile_for(point: Point) -> None:
    """Compile what traces a point, if it is not there yet."""
    from mpfcad.optics.engine import compile_tracer

    plan = point.plan()
    if plan.stack.period.along > 0:
        compile_for_cell(plan)
    else:
        compile_tracer()


def trace_point(point: Point, threads: int = 1) -> dict[str, Any]:
    """Return the figures of a point, in outside names."""
    with tempfile.TemporaryDirectory() as temporary:
        searched, plan = _search(point, Path(temporary), threads)
    is_cell = plan.stack.period.along > 0
    curvature = plan.curvature if is_cell else plan.piece.curvature
    said = {
        "coordinate": point.coordinate,
        "curvature_min_per_mm": float(curvature.min()),
        "curvature_max_per_mm": float(curvature.max()),
        "search": searched,
        "screen": describe_point_screen(plan),
    }
    limits = point.half_width, point.path_limit
    if is_cell:
        departure = departure_of(plan.stack, point.coordinate, point.where)
        return {**said, **trace_cell_point(plan, departure, *limits, threads)}
    return {**said, **trace_tube_point(plan, point.coordinate, *limits, threads)}


def _search(point: Point, folder: Path, threads: int) -> tuple[dict[str, Any] | None, Plan]:
    """Return what a search of the point's map found, if there is one, and the plan with it."""
    from mpfcad.job.design import Design
    from mpfcad.job.reader import validate
    from mpfcad.pipeline.design.reach import describe_reach
    from mpfcad.pipeline.design.work import DesignWork

    if point.design is None:
        return None, point.plan()
    design = validate(Design, point.design, point.where)
    work = DesignWork(design, Path(point.where), threads, SILENT)
    done = work.search_maps(design.goal.contrast_target)
    reach = describe_reach(work, done) if design.search.method == "response" else None
    work.write_map(folder / "map.csv", np.array(work.best(done).rows))
    job = {**point.job, "map": {"file": str(folder / "map.csv"), "extent": "pitch"}}
    searched = {
        "series_per_mm": list(work.best(done).series),
        "paths": sum(one.paths for one in done),
        "reach": reach,
    }
    return searched, replace(point, job=job).plan()
