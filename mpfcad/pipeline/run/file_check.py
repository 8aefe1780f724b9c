"""Reads every file of an export back; one that does not read back is a gate that is not passed."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.errors import ExportError
from mpfcad.gate import Gate, yes_no
from mpfcad.mask import Mask, MaskCheck
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import Progress
from mpfcad.pipeline.run.make import check_masks
from mpfcad.pipeline.run.mask_order import phototool


@dataclass
class FileFindings:
    """What the files turned out to be.

    Attributes
    ----------
    mask
        check of each mask file by its name, of those that read back as masks
    step, mesh, agreement
        of film.step and film.stl; None where a file does not read back as one
    gates
        of all of them
    """

    mask: dict[str, MaskCheck] = field(default_factory=dict)
    step: StepCheck | None = None
    mesh: MeshCheck | None = None
    agreement: Agreement | None = None
    gates: list[Gate] = field(default_factory=list)


def examine_files(folder: Path, plan: Plan, mask: Mask | None, progress: Progress) -> FileFindings:
    """Return what the masks, film.step and film.stl in `folder` hold."""
    found = FileFindings()
    if mask is not None:
        _examine_masks(found, folder, plan, mask, progress)
    drawing = kind_of(plan.drawn, plan.job.cad)
    step, stl = folder / "film.step", folder / "film.stl"
    with _judged(found, "step_valid"):
        progress.stage("checking film.step")
        found.step = drawing.check_step(step)
        found.gates += found.step.gates
    with _judged(found, "mesh_watertight"):
        progress.stage("checking film.stl")
        found.mesh = drawing.check_mesh(stl)
        found.gates += found.mesh.gates
    if found.step is not None and found.mesh is not None:
        progress.stage("comparing film.step with film.stl")
        found.agreement = drawing.compare(step, stl, sum(found.step.bodies.values()))
        found.gates += found.agreement.gates
    # Without the folder's name, which is another one when the export is verified.
    found.gates = [
        replace(gate, detail=gate.detail.replace(f"{folder}/", "")) for gate in found.gates
    ]
    return found


def _examine_masks(
    found: FileFindings, folder: Path, plan: Plan, mask: Mask, progress: Progress
) -> None:
    if plan.process is None:
        return
    tool = phototool(plan.job, mask, plan.process)
    for suffix in plan.job.mask.formats:
        with _judged(found, "mask_file_as_written"):
            checks = check_masks(mask, tool, folder, [suffix], progress)
            found.mask.update(checks)
            found.gates.append(yes_no("mask_file_as_written", True))


@contextmanager
def _judged(found: FileFindings, gate: str) -> Iterator[None]:
    """Take a file that does not read back as what it should be for a gate that is not passed."""
    try:
        yield
    except ExportError as error:
        found.gates.append(yes_no(gate, False, str(error)))
