"""From a job to everything that is made of it: the panel film, its CAD piece, process and stack."""

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack, read_stack
from mpfcad.errors import InputError
from mpfcad.film import (
    FieldFilm,
    PanelFilm,
    PrismFilm,
    Process,
    write_curvature_field,
    write_curvature_map,
)
from mpfcad.job import Job
from mpfcad.pipeline.plan.cell import (
    crossed_layer,
    even_cells,
    refuse_cell_map,
    turned_job,
    with_crossed,
)
from mpfcad.pipeline.plan.cell_map import read_cell_film_map
from mpfcad.pipeline.plan.departure import AS_DESIGNED, Departure
from mpfcad.pipeline.plan.field import has_field, read_field_film, refuse_window
from mpfcad.pipeline.plan.groove_map import read_map
from mpfcad.pipeline.plan.made import Drawn, read_measured
from mpfcad.pipeline.plan.named_file import check_job_files
from mpfcad.pipeline.plan.panel_map import FieldMap, GrooveMap, PanelMap, as_written, asked_of
from mpfcad.pipeline.plan.printed.process import read_job_process, with_reason
from mpfcad.pipeline.plan.printed.propose import with_screen
from mpfcad.pipeline.plan.printed.screen import with_own_catalogue
from mpfcad.pipeline.plan.size import groove_count

CURVATURE_FILE = "curvature.csv"


@dataclass(frozen=True, eq=False)
class Plan:
    """A job with every input read.

    Attributes
    ----------
    job
        the job as validated
    process
        the printing process; None for an `ideal` film, which no print can make, and for cells
    stack
        the backlight with the film's slot
    panel
        the film over the whole panel, x from the panel's left edge; where the curvature varies
        along the grooves too, its section at the piece's lower end
    piece
        the part that film.step and film.stl hold, as designed, cut from `panel`
    drawn
        what they hold: `piece` itself, or as the job says it is made, of cells, or of grooves whose
        curvature varies along them
    field_film
        the film over the panel, where its curvature varies along the grooves too
    first_groove
        groove of `panel` that is the first of `piece`
    calibration
        text of the process calibration that the job names, if it does
    measured
        (k, 2) float64 [mm], mean groove of the stylus trace that the job names, if it does
    along
        (n, m) float64 [1/mm], C along y of cells that have two, over one cell of LEDs
    input_file
        path of every file read, by its name in the job
    crossed
        under LEDs, the plan of the printed film that lies across this one, in its own axes
    suffix
        what the names of this film's files have after `mask`, `film` and `curvature`
    where
        what a refusal begins with: the job's file, or the export
    """

    job: Job
    process: Process | None
    stack: Stack
    panel: PrismFilm
    piece: PrismFilm
    drawn: Drawn
    first_groove: int
    field_film: FieldFilm | None = None
    calibration: str | None = None
    measured: NDArray[np.float64] | None = None
    along: NDArray[np.float64] | None = None
    input_file: dict[str, Path] = field(default_factory=dict)
    crossed: "Plan | None" = None
    suffix: str = ""
    where: str = "job"

    @property
    def films(self) -> "tuple[Plan, ...]":
        """The plan of each film that is made, this one first."""
        return (self,) if self.crossed is None else (self, self.crossed)

    def lit_stack(self, folder: Path) -> Stack:
        """Return the stack as it is traced, the other films' meshes in the export `folder`."""
        stack = self.stack.with_files_in(folder)
        if self.crossed is None:
            return stack
        return with_crossed(stack, folder / self.crossed.file("film", "3mf"))

    def file(self, name: str, ending: str) -> str:
        """Return the name of a file of this film: `mask`, `film` or `curvature` by its ending."""
        return f"{name}{self.suffix}.{ending}"

    @property
    def printed(self) -> PanelFilm:
        """The film over the panel as its mask prints it."""
        return self.field_film or self.panel

    @property
    def lamp_position(self) -> float:
        """Position [mm] on the panel of the lamp that the traced pitch starts at."""
        return self.stack.origin[0]

    @property
    def offset(self) -> float:
        """Position [mm] of the traced piece's left edge from that lamp's axis."""
        if self.stack.period.along > 0:
            return 0.0  # a cell begins at its LED; on the panel, at the groove next to it
        return self.piece.origin - self.lamp_position

    @property
    def angle_tolerance(self) -> float:
        """Largest angle [rad] between a facet of its files and the surface it stands for."""
        return self.job.cad.angle_tolerance

    @property
    def curvature(self) -> NDArray[np.float64]:
        """Every curvature [1/mm] that its screens have to print, one axis."""
        return np.concatenate([np.ravel(film.printed.content[-1]) for film in self.films])

    @property
    def is_printable(self) -> bool:
        """Whether a mask can be made."""
        return self.process is not None

    def write_curvature(self, folder: Path) -> None:
        """Write the table of the panel's grooves, or its map in both directions."""
        if self.field_film is not None:
            path = folder / self.file("curvature", "npz")
            along = None if self.along is None else np.ascontiguousarray(self.along.T)
            write_curvature_field(path, self.field_film.field, along)
            return
        ratio = None
        if self.process is not None:
            ratio = self.process.aperture_ratio_of_curvature(self.panel.curvature)
        write_curvature_map(
            folder / CURVATURE_FILE,
            self.panel.groove_position,
            self.panel.curvature,
            groove=self.panel.groove,
            profile=self.panel.profile,
            aperture_ratio=ratio,
        )


def read_plan(job: Job, job_file: Path, departure: Departure = AS_DESIGNED) -> Plan:
    """Return the plan of a job, reading the files it names beside `job_file`.

    `departure`: under LEDs, how films and board are unlike the job's.

    Raises
    ------
    InputError
        when a file or a value in it is wrong.
    """
    job_file = Path(job_file)
    check_job_files(job, job_file)
    job = with_own_catalogue(job, job_file)
    folder = job_file.parent
    files = {
        name: folder / name
        for name in (
            job.map.file,
            None if job.crossed is None else job.crossed.file,
            job.process.calibration,
            job.stack.file,
            job.film.measured_file,
        )
        if name is not None
    }
    stack = departure.of_board(read_job_stack(job, job_file), str(job_file))
    _refuse_resin(job, stack, str(job_file))
    if job.gates.colour_max is not None and stack.bands is None:
        raise InputError(
            f"{job_file}: gates.colour_max: {job.gates.colour_max:g}: the stack {stack.name} "
            "states no light.bands: expected bands and a spectrum"
        )
    calibration = files.get(job.process.calibration or "")
    groove = job.film.groove
    count = groove_count(stack.panel_width, groove.pitch)
    panel_map: PanelMap
    if stack.period.along > 0 and job.film.cell != "groove" and not job.has_cells:
        panel_map = GrooveMap(even_cells(job, departure, count, str(job_file)))
    elif stack.period.along > 0:
        panel_map = read_cell_film_map(job, job_file, stack, departure)
    elif has_field(job, job_file):
        assert job.map.file is not None  # a map C(x, y) is a file
        map_file = folder / job.map.file
        panel_map = FieldMap(read_field_film(job, map_file, str(job_file), count, stack))
    else:
        refuse_window(job, str(job_file))
        refuse_cell_map(job, str(job_file))
        curvature = read_map(job, job_file, stack, job.map).on_grooves(
            (np.arange(count) + 0.5) * groove.pitch,
            stack.period.across,
            stack.origin[0],
        )
        panel_map = GrooveMap(as_written(curvature, groove))
    job, reason = with_screen(job, job_file, asked_of(panel_map), groove)
    process = read_job_process(job, calibration, groove, str(job_file))
    process = with_reason(process, reason)
    text = calibration.read_text("utf-8") if calibration else None
    plan = build_plan(job, stack, process, panel_map, read_measured(job, job_file), str(job_file))
    return replace(plan, calibration=text, input_file={job_file.name: job_file, **files})


#: A resin that light tells from the prisms.
_OWN = "scatters or is of another material"


def _refuse_resin(job: Job, stack: Stack, where: str) -> None:
    """Raise where light sees the prisms under the resin, and they are not known."""
    if not stack.needs_prism:
        return
    if job.film.profile != "filled":
        raise InputError(
            f"{where}: film.profile: ideal: has no resin of its own: expected 'filled'"
        )
    if not job.film.is_plain:
        raise InputError(
            f"{where}: resin: {_OWN}: expected grooves as designed, without imperfections"
        )


def build_plan(
    job: Job,
    stack: Stack,
    process: Process | None,
    panel_map: PanelMap,
    measured: NDArray[np.float64] | None,
    where: str,
) -> Plan:
    """Return the plan of what a job names, read already; a refusal begins with `where`."""
    laid = panel_map.lay(job, stack, measured, where)
    plan = Plan(
        job, process, stack, laid.panel, laid.piece, laid.drawn, laid.first_groove,
        laid.field_film, measured=laid.measured, along=laid.along, where=where,
    )  # fmt: skip
    if panel_map.crossed is None:
        return plan
    crossed_layer(stack, where)
    across = build_plan(turned_job(job), stack, process, panel_map.crossed, None, where)
    return replace(plan, crossed=replace(across, suffix="-crossed"))


def read_job_stack(job: Job, job_file: Path) -> Stack:
    """Return the backlight of a job, its overrides in place.

    Raises
    ------
    InputError
        when a file or a value in it is wrong.
    """
    overrides = dict(job.stack.override)
    index = job.film.refractive_index
    if index is not None:
        if "film_index" in overrides:
            raise InputError(
                f"{job_file}: stack.override.film_index: {overrides['film_index']}: "
                f"expected no such override beside film.refractive_index"
            )
        overrides["film_index"] = index
    overrides.update(job.resin.document() if job.resin else {})
    file = job.stack.file
    assert file is not None or job.stack.preset is not None  # the job has one of both
    source = job_file.parent / file if file is not None else job.stack.preset or ""
    try:
        stack = read_stack(source, thickness=job.stack.thickness, overrides=overrides)
    except InputError as error:
        raise InputError(f"{job_file}: {error}") from None
    if not stack.has_slot:
        raise InputError(f"{job_file}: stack: {source}: has no film: a job needs one to make")
    return stack
