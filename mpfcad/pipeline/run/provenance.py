"""Where a record comes from: what cannot be found again from an export, and what of it is held."""

import hashlib
import re
from pathlib import Path
from typing import Any, TypeGuard

from mpfcad.errors import ExportError
from mpfcad.export import canonical_json, sha256
from mpfcad.job import Job
from mpfcad.pipeline.effort import TRACE_SETTINGS
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.store import code_hash, versions

_THREADS = "any: results do not depend on it"
_SHA256, _VERSION = re.compile("[0-9a-f]{64}"), re.compile(r"[\w.+!-]{1,40}")


def build_provenance(plan: Plan, job_file: Path, effort: str) -> dict[str, Any]:
    """Return what cannot be found again from the export: inputs' hashes, versions, command."""
    return {
        "inputs_sha256": {
            name: sha256(path) if path.is_file() else job_hash(plan.job)
            for name, path in sorted(plan.input_file.items())
        },
        "versions": versions(),
        "code_sha256": code_hash(),
        "seed": plan.job.seed,
        "threads": _THREADS,
        "command": f"mpfcad run {job_file.name} --effort {effort}",
    }


def restore_provenance(plan: Plan, given: dict[str, Any]) -> dict[str, Any]:
    """Return the provenance of a stored record: what follows from the job, and what it states.

    Hashes of inputs, versions and the hash of the code cannot be found again; they are protected by
    a signature alone, and have to be of their form.

    Raises
    ------
    ExportError
        when it is none that a run writes.
    """
    hashes, versions, code = (
        given.get(key) for key in ("inputs_sha256", "versions", "code_sha256")
    )
    command = re.fullmatch(r"mpfcad run (.+) --effort (\w+)", str(given.get("command")))
    if command is None or command[2] not in TRACE_SETTINGS:
        raise ExportError(
            f"provenance.command: {given.get('command')!r}: expected mpfcad run FILE --effort WORD"
        )
    formed = (
        _is_table(hashes, _SHA256) and command[1] in hashes and _is_table(versions, _VERSION)
        and _SHA256.fullmatch(str(code))
    )  # fmt: skip
    if not formed:
        raise ExportError(
            "provenance: expected hashes of the inputs, versions and the hash of the code"
        )
    return {
        "inputs_sha256": hashes,
        "versions": versions,
        "code_sha256": code,
        "seed": plan.job.seed,
        "threads": _THREADS,
        "command": command[0],
    }


def _is_table(value: Any, form: "re.Pattern[str]") -> TypeGuard[dict[str, str]]:
    return isinstance(value, dict) and all(form.fullmatch(str(v)) for v in value.values())


def job_hash(job: Job) -> str:
    """Return the SHA-256 of a job that is in no file: of its values as stated, as JSON."""
    return hashlib.sha256(canonical_json(job.given()).encode()).hexdigest()
