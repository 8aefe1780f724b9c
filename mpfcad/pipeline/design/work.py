"""The search of a design's map: constraints and model from its tables, full traces on demand."""

import tempfile
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.design import (
    ROWS,
    Grid,
    Iteration,
    Operators,
    Response,
    Traced,
    best_of,
    search_by_inversion,
    search_by_response,
)
from mpfcad.export import write_text
from mpfcad.job import build_job
from mpfcad.job.design import Design
from mpfcad.pipeline.confidence.variant import FULL
from mpfcad.pipeline.design.aim import design_constraint, design_goal
from mpfcad.pipeline.design.kept_traces import KeptTraces, trace_seed
from mpfcad.pipeline.design.operators import model_operators
from mpfcad.pipeline.design.screen import with_design_screen
from mpfcad.pipeline.effort import NO_GOAL
from mpfcad.pipeline.plan.plan import Plan, read_job_stack
from mpfcad.pipeline.plan.printed.process import read_job_process
from mpfcad.pipeline.plan.printed.screen import screen_mesh
from mpfcad.pipeline.plan.tube import read_tube_plan
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.run.make import write_cad
from mpfcad.pipeline.run.stack_mesh import write_stack_meshes
from mpfcad.record.printing import PHOTOTOOL_ONLY
from mpfcad.store import Store

#: Largest distance [1/mm] of the curvatures at which the film is traced alone.
_NODE_STEP = 6.0
_UNIFORM_FILMS = 7
#: Resin of a print over what is meant, at most.
_MORE_RESIN = 2.0
#: Fields of a design that name files beside it.
_FILES = (("process", "calibration"), ("stack", "file"), ("confidence", "covariance"))
#: Half the distance [mm] between the two rows at a step of a map of levels.
_STEP = 1e-6


class DesignWork:
    """A design being searched."""

    def __init__(self, design: Design, file: Path, threads: int, progress: Progress) -> None:
        design, job = with_design_screen(design, file)
        self.design, self.file, self.threads, self.progress = design, file, threads, progress
        self.job = job
        self.stack = read_job_stack(job, file)
        self.groove = design.film.groove
        calibration = design.process.calibration
        self.process = read_job_process(
            job, None if calibration is None else file.parent / calibration, self.groove, str(file)
        )
        self.pitch = self.stack.period.across
        self.constraint = design_constraint(design, job, self.process, file)
        self.goal = design_goal(design)
        mesh = job.mask.mesh
        self.screen = PHOTOTOOL_ONLY if mesh is None else screen_mesh(mesh, str(file)).name
        self.store = Store.open(progress.note)
        self.state = KeptTraces(self.store, self.inputs())
        self.model: dict[str, Any] | None = None

    def inputs(self) -> list[Any]:
        """Return what the traces of given rows depend on, by value."""
        document = self.design.document()
        own = [document[table] for table in ("film", "cad")]
        search = [self.design.seed, self.design.search.paths_million]
        return [*own, *search, self.stack, self.stack.files(), self.process]

    def search_maps(self, contrast_target: float) -> list[Iteration]:
        """Return the traced maps; the interval of the last ends below the target, if one's does."""
        table, constraint = self.design.search, self.constraint
        stop: dict[str, Any] = {
            "iterations": table.iterations,
            "contrast_target": contrast_target,
            "finish": self.finished,
        }
        if table.method == "thesis":
            spread = np.linspace(constraint.curvature_min, constraint.curvature_max, _UNIFORM_FILMS)
            uniform = table.uniform_per_mm or [float(f"{c:.4g}") for c in spread]
            return search_by_inversion(uniform, constraint, self.pitch, self.trace, **stop)
        return search_by_response(
            self.response, constraint, self.goal, self.pitch, self.trace, **stop
        )

    @cached_property
    def response(self) -> Response:
        """The two-scale model of the backlight, estimated on first use."""
        operators = self.estimate(Grid())
        self.model = {
            "curvatures_per_mm": [float(c) for c in operators.node],
            "film_passages": operators.passages,
            "world_segments": operators.segments,
        }
        self.progress.stage("searching in the model")
        return Response(operators)

    def estimate(self, grid: Grid) -> Operators:
        """Return the operators of the two-scale model on a grid."""
        low, high = self._model_range()
        node = np.linspace(low, high, max(4, int(np.ceil((high - low) / _NODE_STEP)) + 1))
        return model_operators(
            self.store,
            self.stack,
            self.groove,
            self.design.film.base,
            self.design.film.profile,
            node,
            grid=grid,
            seed=self.design.seed,
            threads=self.threads,
            progress=self.progress.stage,
        )

    def _model_range(self) -> tuple[float, float]:
        """Return the least and largest C [1/mm] that the model is asked about."""
        low, high = self.constraint.curvature_min, self.constraint.curvature_max
        if self.design.goal.aim != "confidence" or self.design.film.profile != "filled":
            return low, high
        # A print with more or less resin than meant leaves the range of the map.
        fill = _MORE_RESIN * float(self.groove.fill_fraction(low))
        least = float(self.groove.curvature_of_fill(min(fill, FULL)))
        return min(low, least), self.groove.curvature_empty

    def finished(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return rows at the design's levels of aperture ratio (`ideal`: of curvature)."""
        levels = self.design.constraint.levels
        if levels is None:
            return rows
        process = self.process
        value = rows if process is None else process.aperture_ratio_of_curvature(rows)
        level = np.linspace(value.min(), value.max(), levels)
        value = level[np.argmin(np.abs(value[:, None] - level), axis=1)]
        return value if process is None else process.curvature(value)

    def trace(
        self, rows: NDArray[np.float64], label: str, number: int, shift: float = 0.0
    ) -> Traced:
        """Return what a full trace of the map's mesh says, from the kept traces if it is there.

        The film is shifted against the lamps by `shift` [mm], with the same random numbers.
        """
        kept = self.state.find(number, rows, shift)
        if kept is not None:
            return kept
        self.progress.stage(f"tracing {label}" + (f", shifted {shift:g} mm" if shift else ""))
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            plan = self.plan_of(folder, rows)
            write_cad(plan, folder, ("stl",), SILENT)
            write_stack_meshes(plan, folder, SILENT)
            traced = self._trace_mesh(folder / "film.stl", plan.offset + shift, number)
        self.state.keep(number, rows, shift, traced)
        return traced

    def _trace_mesh(self, mesh: Path, offset: float, number: int) -> Traced:
        from mpfcad.measure import TraceRun, light_film, luminance_over_pitch

        run = TraceRun(
            seed=trace_seed(self.design.seed, number),
            threads=self.threads,
            path_limit=round(self.design.search.paths_million * 1e6),
            progress=self.progress.trace,
        )
        lit = light_film(self.stack.with_files_in(mesh.parent), mesh, offset)
        found = luminance_over_pitch(lit, run, half_width_goal=NO_GOAL)
        contrast, mean = found.contrast, found.mean_luminance
        return Traced(
            contrast.value,
            contrast.low,
            contrast.high,
            mean.value,
            mean.standard_error,
            tuple(map(float, found.fit.coefficient)),
            found.paths,
        )

    def plan_of(self, folder: Path, rows: NDArray[np.float64]) -> Plan:
        """Return the plan of the job that a map would have."""
        file = folder / "map.csv"
        self.write_map(file, rows)
        document = self.design.job_document(str(file.resolve()))
        return read_tube_plan(build_job(document, str(self.file)), self.file)

    def write_map(self, file: Path, rows: NDArray[np.float64]) -> None:
        """Write rows of C [1/mm] as a curvature map over one lamp pitch."""
        position = np.linspace(0, self.pitch, ROWS)
        if self.design.constraint.levels is not None:
            edge = (position[1:] + position[:-1])[np.diff(rows) != 0] / 2
            after = rows[1:][np.diff(rows) != 0]
            before = rows[:-1][np.diff(rows) != 0]
            position = np.concatenate([position, edge - _STEP, edge + _STEP])
            rows = np.concatenate([rows, before, after])
            order = np.argsort(position, kind="stable")
            position, rows = position[order], rows[order]
        lines = [f"{x:.6f},{c:.6f}" for x, c in zip(position, rows, strict=True)]
        write_text(file, "\n".join(["position_mm,curvature_per_mm", *lines, ""]))

    def write_job(self, folder: Path, rows: NDArray[np.float64], back: str) -> None:
        """Write the job and its map; `back` leads from the folder to the design's own."""
        import tomli_w

        name = self.design.name
        self.write_map(folder / f"{name}.csv", rows)
        document = self.design.job_document(f"{name}.csv")
        for table, key in _FILES:
            file = document.get(table, {}).get(key)
            if file is not None:
                document[table][key] = str(Path(back) / file)
        build_job(document, str(self.file))
        lines = (f"Found by mpfcad design {self.file.name}", f"screen: {self.screen}",
                 f"mpfcad run {name}.toml")  # fmt: skip
        head = "".join(f"# {line}\n" for line in lines)
        write_text(folder / f"{name}.toml", head + tomli_w.dumps(document))

    def best(self, done: list[Iteration]) -> Iteration:
        """Return the best of the patterned maps."""
        return best_of([one for one in done if len(one.series) > 1], self.goal)
