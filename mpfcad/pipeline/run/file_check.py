"""Reads every file of an export back; one that does not read back is a gate that is not passed."""

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import guarded
from mpfcad.boundary.apart import apart, tell_stage
from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.cad.check.library import LibraryCheck
from mpfcad.errors import ExportError
from mpfcad.gate import Gate, yes_no
from mpfcad.mask import Mask, MaskCheck
from mpfcad.pipeline.kind import Kind, kind_of
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.printed.order import phototool
from mpfcad.pipeline.progress import Progress, Silent
from mpfcad.pipeline.run.make import check_masks, mask_names


class Solid(NamedTuple):
    """Volume [mm³] of a traced file, and C [1/mm] by its corners; None of a measured surface."""

    volume: float
    curvature: NDArray[np.float64] | None


@dataclass
class FileFindings:
    """What the files turned out to be.

    Attributes
    ----------
    mask
        check of each mask file by its name, of those that read back as masks
    step, mesh, agreement
        of film.step and film.stl; None where a file does not read back as one
    library
        of film.3mf, a film of instances
    gates
        of all of them
    foreign
        whether they were handed on, and not written by this very run
    """

    mask: dict[str, MaskCheck] = field(default_factory=dict)
    step: StepCheck | None = None
    mesh: MeshCheck | None = None
    agreement: Agreement | None = None
    library: LibraryCheck | None = None
    gates: list[Gate] = field(default_factory=list)
    foreign: bool = False

    @property
    def solid(self) -> Solid | None:
        """What the traced file bounds; None where it does not read back."""
        if self.library is not None:
            return Solid(self.library.solid, self.library.curvature)
        return None if self.mesh is None else Solid(self.mesh.volume, self.mesh.curvature)


def examine_files(
    folder: Path, plan: Plan, mask: Mask | None, progress: Progress, *, foreign: bool = False
) -> FileFindings:
    """Return what the masks and the CAD files of one film in `folder` hold."""
    found = FileFindings(foreign=foreign)
    if mask is not None:
        _examine_masks(found, folder, plan, mask, progress)
    drawing = kind_of(plan.drawn, plan.job.cad)
    if "stl" in drawing.run_formats:
        _examine_solid(found, folder, plan, drawing, progress)
    else:
        name = plan.file("film", drawing.run_formats[-1])
        with judged(found, "library_as_written", folder / name):
            progress.stage(f"checking {name}")
            check = drawing.check(folder / name)
            assert isinstance(check, LibraryCheck)  # that kind of film has no other
            found.library = check
            found.gates.append(yes_no("library_as_written", True))
    # Without the folder's name, which is another one when the export is verified.
    found.gates = [
        replace(gate, detail=gate.detail.replace(f"{folder}/", "")) for gate in found.gates
    ]
    return found


def _examine_solid(
    found: FileFindings, folder: Path, plan: Plan, drawing: Kind, progress: Progress
) -> None:
    """Examine film.step and film.stl, and compare them."""
    step, stl = (folder / plan.file("film", suffix) for suffix in ("step", "stl"))
    with judged(found, "step_valid", step):
        progress.stage("checking film.step")
        found.step = drawing.check_step(step)
        found.gates += found.step.gates
    with judged(found, "mesh_watertight", stl):
        progress.stage("checking film.stl")
        found.mesh = drawing.check_mesh(stl)
        found.gates += found.mesh.gates
    if found.step is not None and found.mesh is not None:
        progress.stage("comparing film.step with film.stl")
        found.agreement = drawing.compare(step, stl, sum(found.step.bodies.values()))
        found.gates += found.agreement.gates


def examine_foreign(
    folder: Path, plan: Plan, mask: Mask | None, progress: Progress
) -> FileFindings:
    """Return the same of a folder that was handed on, read in a process of its own.

    Raises
    ------
    ExportError
        naming what was read when a file made its reader crash.
    """
    return apart(
        folder, "an export as it was written", _examine, folder, plan, mask,
        kind=ExportError, stage=progress.stage, libraries=("OCP.STEPControl", "klayout.db"),
    )  # fmt: skip


class _Told(Silent):
    """Progress that the process that asked is told."""

    def stage(self, text: str) -> None:
        tell_stage(text)


def _examine(folder: Path, plan: Plan, mask: Mask | None) -> FileFindings:
    return examine_files(folder, plan, mask, _Told(), foreign=True)


def _examine_masks(
    found: FileFindings, folder: Path, plan: Plan, mask: Mask, progress: Progress
) -> None:
    if plan.process is None:
        return
    tool = phototool(plan.job, mask, plan.process)
    for name in mask_names(plan, plan.job.mask.formats):
        with judged(found, "mask_file_as_written", folder / name):
            checks = check_masks(mask, tool, folder, [name], progress)
            found.mask.update(checks)
            found.gates.append(yes_no("mask_file_as_written", True))


@contextmanager
def judged(found: FileFindings, gate: str, path: Path) -> Iterator[None]:
    """Take a file that does not read back as what it should be for a gate that is not passed.

    A foreign file may be anything: what no reader foresaw is such a gate. In a run's own files it
    is a fault of ours, and no verdict.
    """
    try:
        with (
            guarded(path, "the file as it was written", ExportError)
            if found.foreign
            else nullcontext()
        ):
            yield
    except ExportError as error:
        found.gates.append(yes_no(gate, False, str(error)))
