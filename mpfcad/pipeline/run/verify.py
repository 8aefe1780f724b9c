"""`verify_export`: hash every file, then find every figure again from the files, bit for bit."""

import json
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.boundary import guarded
from mpfcad.errors import ExportError, InputError, MpfcadError
from mpfcad.export import MANIFEST, canonical_json, check_manifest
from mpfcad.export.text import encoded
from mpfcad.measure import Checkpoints
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.run.run import PRINTED, REPORT, VERIFICATION, write_run_order
from mpfcad.record import Rounded, compare_records
from mpfcad.store import Store, code_hash, versions


def verify_export(
    folder: Path,
    *,
    threads: int | None = None,
    progress: Progress = SILENT,
    rounded: list[Rounded] | None = None,
) -> dict[str, Any]:
    """Return verification.json of an export after finding it again from its files.

    `rounded` gets the figures whose last bits are other ones here: what goes through a library's
    linear algebra or trigonometry rounds otherwise on another processor.

    Raises
    ------
    InputError
        when `folder` is no export of `mpfcad run`.
    ExportError
        naming the file that is changed, missing or foreign, or the figure that differs.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder: expected an export of mpfcad run")
    progress.stage("hashing every file")
    manifest = check_manifest(folder)
    if VERIFICATION not in manifest["files"]:
        raise InputError(f"{folder}: holds no {VERIFICATION}: every hash holds, nothing to trace")
    stored = read_record(folder / VERIFICATION)
    if PRINTED in manifest["files"]:
        progress.note(f"{PRINTED}: what it shows is not compared: a browser printed {REPORT}")
    with checked_record(folder, stored):
        for key, expected in (("schema", 1), ("name", stored["name"]), ("kind", "run")):
            if json.dumps(manifest[key]) != json.dumps(expected):
                raise ExportError(
                    f"{folder / MANIFEST}: {key}: {manifest[key]!r}: expected {expected!r}"
                )
        _check(folder, stored, set(manifest["files"]), threads, progress, rounded)
    return dict(stored)


@contextmanager
def checked_record(folder: Path, stored: dict[str, Any]) -> Iterator[None]:
    """Have whatever a record makes fail be an `ExportError` that says which versions made it."""
    path = folder / VERIFICATION
    try:
        with guarded(path, "the record of a run", ExportError):
            yield
    except MpfcadError as error:
        given = stored.get("provenance")
        maker = _maker(given if isinstance(given, dict) else {})
        where = "" if isinstance(error, ExportError) else f"{path}: "
        raise ExportError(f"{where}{error}{maker}") from error


def read_record(path: Path) -> dict[str, Any]:
    """Return what is in verification.json.

    Raises
    ------
    ExportError
        when it is no JSON table.
    """
    try:
        stored = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise ExportError(f"{path}: no JSON: {error}") from None
    if not isinstance(stored, dict):
        raise ExportError(f"{path}: {type(stored).__name__}: expected a table")
    return stored


def _check(
    folder: Path,
    stored: dict[str, Any],
    names: set[str],
    threads: int | None,
    progress: Progress,
    rounded: list[Rounded] | None,
) -> None:
    """Find maps, record and pages again, and compare; `names` are those of the export's files."""
    plan = _restore(folder, stored)
    maps = _compare_maps(folder, plan)
    found, draw = _find_again(folder, plan, stored, threads, progress)
    comparison = compare_records(stored, json.loads(canonical_json(found)))
    if comparison.difference:
        raise ExportError(f"{folder / VERIFICATION}: {comparison.difference}")
    if (folder / VERIFICATION).read_bytes() != encoded(canonical_json(stored)):
        # A key that stands twice, say: another reader takes the other one.
        raise ExportError(
            f"{folder / VERIFICATION}: its figures are as found, but not written as a run does"
        )
    if rounded is not None:
        rounded += comparison.rounded
    # Of the stored record: where the last bits are another processor's, the page has them too.
    pages = draw(stored)
    _compare_names(folder, names, {*maps, *made_files(plan), *pages})
    _compare_pages(folder, pages)


def _restore(folder: Path, stored: dict[str, Any]) -> Plan:
    from mpfcad.pipeline.plan.restored import restore_plan

    return restore_plan(folder, stored["job"])


def _find_again(
    folder: Path, plan: Plan, stored: dict[str, Any], threads: int | None, progress: Progress
) -> tuple[dict[str, Any], Callable[[dict[str, Any]], dict[str, bytes]]]:
    """Return the record as this version finds it, and what draws the pages of a record."""
    from mpfcad.pipeline.effort import TraceSetting
    from mpfcad.pipeline.run.examine import examine, write_pictures
    from mpfcad.pipeline.run.make import plan_mask
    from mpfcad.pipeline.run.provenance import restore_provenance
    from mpfcad.pipeline.run.record import build_record, gather_evidence
    from mpfcad.report import build_page

    setting = TraceSetting(**stored["job"]["trace"])
    provenance = restore_provenance(plan, stored["provenance"])
    with Checkpoints(Store.open(progress.note)) as checkpoints:
        masks = [plan_mask(film) for film in plan.films]
        findings = examine(
            folder, plan, masks, setting, threads, checkpoints, progress, foreign=True
        )
        record = build_record(folder, plan, findings, setting, provenance)

    def draw(record: dict[str, Any]) -> dict[str, bytes]:
        progress.stage("drawing the report again")
        with tempfile.TemporaryDirectory() as temporary:
            write_pictures(plan, masks, findings, Path(temporary), source=folder)
            write_run_order(Path(temporary), plan, masks, record, progress, source=folder)
            pages = {path.name: path.read_bytes() for path in sorted(Path(temporary).iterdir())}
        evidence = gather_evidence(folder, plan, masks[0], findings)
        pages[REPORT] = build_page(record, evidence).encode()
        return pages

    return record, draw


def _compare_maps(folder: Path, plan: Plan) -> list[str]:
    """Compare all that a map states with what its curvatures give; return the names of the maps."""
    from mpfcad.pipeline.run.make import write_curvature

    with tempfile.TemporaryDirectory() as temporary:
        write_curvature(plan, Path(temporary))
        found = sorted(Path(temporary).iterdir())
        for path in found:
            content = _arrays if path.suffix == ".npz" else Path.read_bytes
            if content(folder / path.name) != content(path):
                raise ExportError(
                    f"{folder / path.name}: differs from what its own curvatures and the job give"
                )
        return [path.name for path in found]


def _arrays(path: Path) -> dict[str, tuple[str, tuple[int, ...], bytes]]:
    """Return type, shape and bytes of each array: the archive around them is a library's."""
    with np.load(path, allow_pickle=False) as arrays:
        return {name: (a.dtype.str, a.shape, a.tobytes()) for name, a in arrays.items()}


def made_files(plan: Plan) -> set[str]:
    """Return the names of the files that a run makes of a plan, but for maps and pages."""
    from mpfcad.backlight import PRISM_FILE, stack_file
    from mpfcad.pipeline.kind import kind_of
    from mpfcad.pipeline.run.make import mask_names

    names = {VERIFICATION, *map(stack_file, plan.stack.files())}
    if plan.stack.needs_prism:
        names.add(PRISM_FILE)
    for film in plan.films:
        names |= {film.file("film", s) for s in kind_of(plan.drawn, plan.job.cad).run_formats}
        if film.process is not None:
            names |= set(mask_names(film, plan.job.mask.formats))
    return names


def _compare_names(folder: Path, names: set[str], made: set[str]) -> None:
    """Compare which files there are: one that no run makes is found though it has its entry."""
    for name in sorted(names - made - {PRINTED}):
        raise ExportError(f"{folder / name}: is no file of this export, though it is in {MANIFEST}")
    for name in sorted(made - names):
        raise ExportError(f"{folder / name}: missing, and not in {MANIFEST} either")


def _compare_pages(folder: Path, pages: dict[str, bytes]) -> None:
    """Compare what a person looks at, byte for byte: a forged page may carry a true hash."""
    for name, content in pages.items():
        if (folder / name).read_bytes() != content:
            raise ExportError(
                f"{folder / name}: differs from what the record and the files give, though every "
                "figure came out the same and its hash is that of the manifest"
            )


def _maker(made: dict[str, Any]) -> str:
    """Return which versions made an export, where they are not those that verify it."""
    here, there = versions(), made.get("versions")
    there = there if isinstance(there, dict) else {}
    other = [
        f"{name} {version} (here {here.get(name, 'not used')})"
        for name, version in there.items()
        if here.get(name) != version
    ]
    code = str(made.get("code_sha256", "not stated"))
    if not other and code != code_hash():
        other = [f"mpfcad {there.get('mpfcad')} of code {code[:12]} (here {code_hash()[:12]})"]
    return f"; the export was made by {', '.join(other)}" if other else ""
