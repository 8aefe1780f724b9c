"""`verify_export`: hash every file, then find every figure again from the files, bit for bit."""

import json
import tempfile
from pathlib import Path
from typing import Any

from mpfcad.errors import ExportError, InputError, MpfcadError
from mpfcad.export import canonical_json, check_manifest
from mpfcad.measure import Checkpoints
from mpfcad.pipeline.progress import SILENT, Progress
from mpfcad.pipeline.run.run import REPORT, VERIFICATION
from mpfcad.store import Store, code_hash, versions

#: Provenance that only the run itself could know; it is protected by the hash alone.
OF_THE_RUN = ("inputs_sha256", "versions", "code_sha256", "seed", "threads", "command")


def verify_export(
    folder: Path, *, threads: int | None = None, progress: Progress = SILENT
) -> dict[str, Any]:
    """Return verification.json of an export after finding it again from its files.

    Raises
    ------
    InputError
        when `folder` is no export of `mpfcad run`.
    ExportError
        naming the file that is changed, missing or foreign, or the figure that differs.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder: must be an export of mpfcad run")
    progress.stage("hashing every file")
    manifest = check_manifest(folder)
    if VERIFICATION not in manifest["files"]:
        raise InputError(f"{folder}: holds no {VERIFICATION}: every hash holds, nothing to trace")
    stored = json.loads((folder / VERIFICATION).read_text("utf-8"))
    try:
        found, pages = _find_again(folder, stored, threads, progress)
        found = json.loads(canonical_json(found))
    except (MpfcadError, LookupError, TypeError, ValueError) as error:
        maker = _maker(stored.get("provenance", {}))
        if not maker:
            raise
        reason = error if isinstance(error, MpfcadError) else f"not read by this version: {error!r}"
        raise ExportError(f"{folder / VERIFICATION}: {reason}{maker}") from error
    _compare(folder, stored, found)
    _compare_pages(folder, pages, _maker(stored["provenance"]))
    return stored


def _find_again(
    folder: Path, stored: dict[str, Any], threads: int | None, progress: Progress
) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the record, and the bytes of what is drawn from it, as this version makes them."""
    from mpfcad.pipeline.effort import TraceSetting
    from mpfcad.pipeline.plan.plan import restore_plan
    from mpfcad.pipeline.run.examine import examine
    from mpfcad.pipeline.run.make import plan_mask, write_mask_pictures
    from mpfcad.pipeline.run.record import build_record, gather_evidence
    from mpfcad.report import build_page

    plan = restore_plan(folder, stored["job"])
    setting = TraceSetting(**stored["job"]["trace"])
    with Checkpoints(Store.open(progress.note)) as checkpoints:
        mask = plan_mask(plan)
        findings = examine(folder, plan, mask, setting, threads, checkpoints, progress)
        given = stored["provenance"]
        provenance = {key: given[key] for key in OF_THE_RUN if key in given}
        record = build_record(folder, plan, findings, setting, provenance)
    progress.stage("drawing the report again")
    with tempfile.TemporaryDirectory() as temporary:
        write_mask_pictures(Path(temporary), findings.mask, mask, source=folder)
        pages = {path.name: path.read_bytes() for path in sorted(Path(temporary).iterdir())}
    evidence = gather_evidence(folder, plan, mask, findings)
    pages[REPORT] = build_page(json.loads(canonical_json(record)), evidence).encode()
    return record, pages


def _compare(folder: Path, stored: dict[str, Any], found: dict[str, Any]) -> None:
    from mpfcad.record import find_difference

    difference = find_difference(stored, found)
    if difference is None:
        return
    raise ExportError(f"{folder / VERIFICATION}: {difference}{_maker(stored['provenance'])}")


def _compare_pages(folder: Path, pages: dict[str, bytes], maker: str) -> None:
    """Compare what a person looks at, byte for byte: a forged page may carry a true hash."""
    for name, content in pages.items():
        if (folder / name).read_bytes() != content:
            raise ExportError(
                f"{folder / name}: differs from what the record and the files give, though its "
                f"hash is that of the manifest{maker}"
            )


def _maker(made: dict[str, Any]) -> str:
    """Return which versions made an export, where they are not those that verify it."""
    here, there = versions(), made.get("versions", {})
    other = [
        f"{name} {version} (here {here.get(name, 'not used')})"
        for name, version in there.items()
        if here.get(name) != version
    ]
    code = str(made.get("code_sha256", "not stated"))
    if not other and code != code_hash():
        other = [f"mpfcad {there.get('mpfcad')} of code {code[:12]} (here {code_hash()[:12]})"]
    return f"; the export was made by {', '.join(other)}" if other else ""
