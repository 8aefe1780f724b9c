"""A job's mask and its screen, known before any file is made; of 1-D and of 2-D maps."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from mpfcad.backlight import Stack
from mpfcad.film import FieldFilm, Process, write_curvature_field
from mpfcad.gate import Gate
from mpfcad.job import Job
from mpfcad.mask import Mask, MaskCheck, Phototool
from mpfcad.mask.screen.printing import Printing
from mpfcad.pipeline.plan.field import FIELD_FILE, has_field, read_field_film
from mpfcad.pipeline.plan.named_file import check_job_files
from mpfcad.pipeline.plan.panel_map import FieldMap, asked_of
from mpfcad.pipeline.plan.plan import Plan, read_job_stack, read_plan
from mpfcad.pipeline.plan.printed.mask_need import mask_need
from mpfcad.pipeline.plan.printed.nearest import Asked
from mpfcad.pipeline.plan.printed.order import (
    ORDER,
    job_order,
    named,
    phototool,
    refuse_mask_formats,
    write_job_order,
)
from mpfcad.pipeline.plan.printed.printing import job_print_limits, plan_printing
from mpfcad.pipeline.plan.printed.process import read_job_process, with_reason
from mpfcad.pipeline.plan.printed.propose import propose, with_screen
from mpfcad.pipeline.plan.printed.screen import moire_setting, with_own_catalogue
from mpfcad.pipeline.plan.printed.trial import Proposal
from mpfcad.pipeline.plan.restored import describe_job, stored_job
from mpfcad.pipeline.plan.size import groove_count
from mpfcad.pipeline.run.make import mask_of, plan_mask, refuse_unprintable
from mpfcad.record import in_order
from mpfcad.record.printing import mask_gates, print_gates, printability


@dataclass(frozen=True, eq=False)
class MaskPlan:
    """A mask that can be made.

    Attributes
    ----------
    job
        the job as validated
    mask
        its apertures
    process
        the printing process
    stored
        the job with all that it names, for an export
    write_curvature
        writes the curvatures that the mask is made of into a folder
    crossed
        of the printed film that lies across, if there is one
    suffix
        what the names of its files have after `mask` and `order`
    """

    job: Job
    mask: Mask
    process: Process
    stored: dict[str, Any]
    write_curvature: Callable[[Path], None]
    crossed: "MaskPlan | None" = None
    suffix: str = ""

    @property
    def masks(self) -> "tuple[MaskPlan, ...]":
        """The plan of each mask that is made, this one first."""
        return (self,) if self.crossed is None else (self, self.crossed)

    @property
    def stem(self) -> str:
        """What the names of its mask files begin with."""
        return f"mask{self.suffix}"

    @property
    def order_file(self) -> str:
        """The name of its order sheet."""
        return named(ORDER, self.suffix)

    def describe(self) -> dict[str, Any]:
        """Return what screen maker and printer have to know, in outside names."""
        from mpfcad.mask.screen.screen import describe_screen

        setting = moire_setting(self.job.mask)
        return describe_screen(self.mask, self.process, setting, self._printing)

    def judge(self, checks: dict[str, MaskCheck]) -> dict[str, Any]:
        """Return the screen with its gates, from the files that were made."""
        gates = self.gates(checks)
        return {
            **self.describe(),
            "printability": printability(self._printing, gates),
            "gates": [gate.document() for gate in gates],
            "order": job_order(self.job, self.mask, self.process),
            "job": self.stored,
        }

    def judge_all(self, checks: Sequence[dict[str, MaskCheck]]) -> dict[str, Any]:
        """Return the screen with the gates of every mask, from the files of each."""
        screen = self.judge(checks[0])
        if self.crossed is None:
            return screen
        across = self.crossed.judge(checks[1])
        found = zip(self.masks, checks, strict=True)
        gates = in_order(gate for one, files in found for gate in one.gates(files))
        return {
            **screen,
            "printability": printability(self._printing, gates),
            "gates": [gate.document() for gate in gates],
            "crossed": {key: value for key, value in across.items() if key != "job"},
        }

    def gates(self, checks: dict[str, MaskCheck]) -> list[Gate]:
        """Return the gates of its mask files and screen."""
        limits = job_print_limits(self.job)
        return [*mask_gates(checks), *print_gates(self._printing, checks, limits)]

    @cached_property
    def _printing(self) -> Printing:
        return plan_printing(self.job, self.mask, self.process)

    def phototool(self) -> Phototool:
        """Return how the job wants its artwork."""
        return phototool(self.job, self.mask, self.process)

    def needs(self, formats: Sequence[str]) -> list[str]:
        """Return what the files of each mask take at most, a line each."""
        return [mask_need(one.mask, formats).words for one in self.masks]

    def refuse_formats(self, formats: Sequence[str], where: str, folder: Path) -> None:
        """Refuse formats that cannot hold a mask, and a frame too small, before anything is made.

        Raises
        ------
        InputError
            that begins with `where` and the job's field.
        """
        for one in self.masks:
            refuse_mask_formats(one.job, one.mask, formats, where, folder)

    def write_order(self, folder: Path, screen: dict[str, Any], formats: Sequence[str]) -> None:
        """Write order.pdf and the list of coupons for `mpfcad calibrate`."""
        screen = screen["crossed"] if self.suffix else screen
        order, printable = screen["order"], screen["printability"]
        write_job_order(folder, order, printable, formats, film=self.suffix)


def read_mask_plan(job: Job, job_file: Path) -> MaskPlan:
    """Return the mask of a job.

    Raises
    ------
    InputError
        when the job is wrong, or a groove or a mesh cannot be made.
    """
    job_file = Path(job_file)
    check_job_files(job, job_file)
    job = with_own_catalogue(job, job_file)
    if has_field(job, job_file) and job.map.extent != "cell":
        return _read_field(job, job_file)
    refuse_unprintable(job, str(job_file))
    plan = read_plan(job, job_file)
    found = mask_plan_of(plan)
    assert found is not None  # what no screen prints is refused
    return found


def mask_plan_of(plan: Plan) -> MaskPlan | None:
    """Return the mask of a whole plan; None for a film that no print can make."""
    mask, process = plan_mask(plan), plan.process
    if mask is None or process is None:
        return None
    crossed = None if plan.crossed is None else mask_plan_of(plan.crossed)
    stored, write = stored_job(plan), plan.write_curvature
    return MaskPlan(plan.job, mask, process, stored, write, crossed, plan.suffix)


def field_mask_plan(
    job: Job,
    film: FieldFilm,
    stack: Stack,
    process: Process | None,
    calibration: str | None,
    where: str,
) -> MaskPlan:
    """Return the mask of a map that varies along the grooves too; no piece of it is cut."""
    assert process is not None  # refuse_unprintable saw to that
    mask = mask_of(job, film, process, where)
    stored = describe_job(job, stack, calibration)

    def write_curvature(folder: Path) -> None:
        write_curvature_field(folder / FIELD_FILE, film.field)

    return MaskPlan(job, mask, process, stored, write_curvature)


def read_proposals(job: Job, job_file: Path) -> list[Proposal]:
    """Return the screens that print a job's map, best first; its own mesh does not matter.

    Raises
    ------
    InputError
        when the job is wrong, or no mesh prints any of the map.
    """
    refuse_unprintable(job, str(job_file))
    bare = job.model_copy(update={"mask": job.mask.model_copy(update={"mesh": None})})
    thesis = bare.process.model_copy(update={"model": None, "solids_fraction": 1.0})
    bare = bare.model_copy(update={"process": thesis})
    if has_field(job, job_file) and job.map.extent != "cell":
        asked = asked_of(_field_map(bare, job_file))
    else:
        plan = read_plan(bare, job_file)
        asked = Asked(plan.curvature, is_grooves=plan.field_film is None)
    if job.process.model == "thesis":
        process = job.process.model_copy(update={"model": "prior"})
        job = job.model_copy(update={"process": process})
    return propose(job, job_file, asked, job.film.groove)


def _field_map(job: Job, job_file: Path) -> FieldMap:
    """Return the map C(x, y) of a job, over the whole panel."""
    stack = read_job_stack(job, job_file)
    count = groove_count(stack.panel_width, job.film.groove.pitch)
    assert job.map.file is not None  # a map C(x, y) is a file
    map_file = job_file.parent / job.map.file
    return FieldMap(read_field_film(job, map_file, str(job_file), count, stack))


def _read_field(job: Job, job_file: Path) -> MaskPlan:
    refuse_unprintable(job, str(job_file))
    panel_map, groove = _field_map(job, job_file), job.film.groove
    film = panel_map.film
    file = job.process.calibration
    calibration = None if file is None else job_file.parent / file
    job, reason = with_screen(job, job_file, asked_of(panel_map), groove)
    process = with_reason(read_job_process(job, calibration, groove, str(job_file)), reason)
    text = None if calibration is None else calibration.read_text("utf-8")
    stack = read_job_stack(job, job_file)
    return field_mask_plan(job, film, stack, process, text, str(job_file))
