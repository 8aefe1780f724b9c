"""One film in one stack, ready to trace, from whatever the user names."""

import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from mpfcad.backlight import Quantity, Stack, is_stack_file, read_stack
from mpfcad.errors import ExportError, InputError
from mpfcad.export import check_manifest
from mpfcad.job import CadTable, Job, read_job
from mpfcad.measure import Lit, light_film
from mpfcad.pipeline.confidence.find import Asked
from mpfcad.pipeline.confidence.subject import GivenFilm, Subject
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.progress import SILENT

DEFAULT_STACK = "thesis-32in-mpf"


@dataclass(frozen=True, eq=False)
class Case:
    """A film in a stack, ready to trace.

    Attributes
    ----------
    name
        of the film, as the user named it
    film
        what the mesh is: its file, or words
    lit
        the mesh in its stack
    lay
        puts the files of stack and film into a folder where they lie nowhere else; returns the
        stack and the film's mesh
    subject
        finds what is known of the film besides its mesh
    """

    name: str
    film: str
    lit: Lit
    lay: Callable[[Path], tuple[Stack, Path | None]]
    subject: Callable[[], Subject]

    @contextmanager
    def variants(self, subject: Subject, asked: Asked) -> Iterator[Variants]:
        """Give its scenes with the inputs changed."""
        with tempfile.TemporaryDirectory() as temporary:
            stack, mesh = self.lay(Path(temporary))
            yield Variants(subject, stack, Path(temporary), asked.table, mesh)


def read_case(
    source: str,
    stack: str | None = None,
    thickness: float | None = None,
    offset: float = 0.0,
    *,
    alone: bool = False,
) -> Case:
    """Return the case of a mesh, an export folder, a job, or a stack with a plain BEF in it.

    A stack is a preset's name or a stack file.

    `stack`: a preset or stack file in place of the export's or job's own; `thickness` [mm] of the
    stack in place of its own; `offset` [mm] of a mesh's left edge from a lamp's axis; `alone`: of
    two printed films the first, the other's prisms bare.

    Raises
    ------
    InputError
        when there is no such thing, or it is wrong.
    """
    path = Path(source)
    is_job = path.suffix == ".toml"
    if path.is_file() and not is_job:
        return mesh_case(path, read_stack(stack or DEFAULT_STACK, thickness=thickness), offset)
    if offset:
        raise InputError(f"--offset-mm: {offset:g}: of {source}: expected a mesh, or no offset")
    if path.is_dir():
        return _read_export(path, stack, thickness, alone)
    if path.is_file() and not is_stack_file(path):
        return job_case(read_job(path), path, stack, thickness, alone=alone)
    if not path.is_file() and (path.suffix or path.name != source):
        raise InputError(
            f"{source}: no such file: expected a closed mesh in mm, a job, an export or a stack"
        )
    own = read_stack(source, thickness=thickness)
    if stack is not None:
        raise InputError(
            f"--stack: {stack}: {source} is a stack itself: expected a mesh, a job or an export"
        )
    return plain_case(own)


def mesh_case(mesh: Path | None, stack: Stack, offset: float) -> Case:
    """Return the case of a mesh in a stack, or of a stack without a film's mesh."""
    lit = light_film(stack, mesh, offset)
    name, film = ("no film", "none") if mesh is None else (mesh.stem, mesh.name)
    own = GivenFilm(offset, CadTable().angle_tolerance)
    path = None if mesh is None else mesh.resolve()
    return Case(name, film, lit, lambda _: (stack, path), lambda: own)


def baseline_case(polarised: bool = False) -> Case:
    """Return a plain BEF in the conventional stack, in like light: what cases are compared with."""
    from mpfcad.pipeline.run.examine import BASELINE_PRESET

    return plain_case(replace(read_stack(BASELINE_PRESET), polarised=polarised))


def write_plain(stack: Stack, mesh: Path) -> None:
    """Write the plain BEF that a stack is traced with."""
    from mpfcad.cad import write_stl
    from mpfcad.pipeline.run.examine import baseline_film

    write_stl(baseline_film(stack), mesh, CadTable().angle_tolerance)


def plain_case(stack: Stack) -> Case:
    """Return a plain BEF, written to a file and read back, in a stack."""
    if not stack.has_slot:
        return mesh_case(None, stack, 0.0)
    from mpfcad.pipeline.run.examine import baseline_film

    def lay(folder: Path) -> tuple[Stack, Path]:
        write_plain(stack, folder / "bef.stl")
        return stack.with_bare(folder / "bef.stl"), folder / "bef.stl"

    film = baseline_film(stack)
    own = GivenFilm(0.0, CadTable().angle_tolerance, film, film)
    return _laid("BEF", "plain BEF", lay, own)


def _laid(
    name: str,
    film: str,
    lay: Callable[[Path], tuple[Stack, Path]],
    subject: Subject,
) -> Case:
    """Return the case of a film whose files are laid into a folder while they are read."""
    with tempfile.TemporaryDirectory() as temporary:
        lit = light_film(*lay(Path(temporary)), subject.offset)
    return Case(name, film, lit, lay, lambda: subject)


def _read_export(folder: Path, stack: str | None, thickness: float | None, alone: bool) -> Case:
    from mpfcad.backlight.stored import restore_stack
    from mpfcad.pipeline.plan.cell import with_crossed
    from mpfcad.pipeline.plan.restored import restore_plan

    try:
        manifest = check_manifest(folder)
        if "verification.json" not in manifest["files"]:
            raise InputError(
                f"{folder}: holds no verification.json: expected an export of mpfcad run"
            )
        record = json.loads((folder / "verification.json").read_text("utf-8"))
    except ExportError as error:
        raise InputError(str(error)) from None
    own = restore_stack(record["job"]["stack"]).with_files_in(folder)
    placed = _placed(own, stack, thickness).with_prism(own.prism)
    across = folder / "film-crossed.3mf"
    if record.get("crossed") is not None and not alone:
        placed = with_crossed(placed, across)
    traced = record["provenance"]["traced"]
    file = folder / traced["file"]
    lit = light_film(placed, file, traced["offset_mm"])
    return Case(
        record["name"], file.name, lit, lambda _: (placed, file.resolve()),
        lambda: restore_plan(folder, record["job"]),
    )  # fmt: skip


def job_case(
    job: Job,
    job_file: Path,
    stack: str | None = None,
    thickness: float | None = None,
    *,
    alone: bool = False,
) -> Case:
    """Return the film of a job, written to a file and read back, without the rest of its export.

    `stack`, `thickness` and `alone` as in `read_case`; file names in the job are taken from beside
    `job_file`, which need not exist.

    Raises
    ------
    InputError
        when the job or a file it names is wrong.
    """
    from mpfcad.pipeline.confidence.covariance import with_covariance
    from mpfcad.pipeline.kind import kind_of
    from mpfcad.pipeline.plan.cell import with_crossed
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.run.make import write_cad
    from mpfcad.pipeline.run.stack_mesh import write_stack_meshes

    plan = read_plan(with_covariance(job, job_file), job_file)
    traced = kind_of(plan.drawn, plan.job.cad).run_formats[-1]

    def lay(folder: Path) -> tuple[Stack, Path]:
        write_cad(plan, folder, (traced,), SILENT)
        write_stack_meshes(plan, folder, SILENT)
        own = plan.stack.with_files_in(folder)
        placed = _placed(own, stack, thickness).with_prism(own.prism)
        if plan.crossed is not None and not alone:
            placed = with_crossed(placed, folder / plan.crossed.file("film", traced))
        return placed, folder / plan.file("film", traced)

    return _laid(job.name, job_file.name, lay, plan)


def _placed(own: Stack, stack: str | None, thickness: float | None) -> Stack:
    """Return the stack asked for, or the film's own."""
    if stack is not None:
        return read_stack(stack, thickness=thickness)
    if thickness is None:
        return own
    return own.with_values({"thickness_mm": Quantity(thickness, "given", "given by the user")})
