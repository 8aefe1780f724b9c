"""Forges an export and has `verify_export` look at it, whole, in its own order.

Two steps of `verify` that cost seconds are taken from a memo that is keyed by all that they read:
`examine` (plan, setting, the bytes of masks and CAD files), and the pages (the same, the record). A
forgery that changes what one of them reads has it done again; of the trace then those blocks whose
scene, source or seed is another one.
"""

import json
import os
import pickle
import random
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from unittest import mock

from command import SMALL_STACK

from mpfcad.errors import ExportError, MpfcadError
from mpfcad.export import MANIFEST, check_manifest, write_manifest
from mpfcad.export.manifest import _sealed
from mpfcad.export.signature import check_signature, sign_export
from mpfcad.export.text import canonical_json, encoded
from mpfcad.job import read_job
from mpfcad.optics import engine
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting, run_job, verify_export
from mpfcad.pipeline.run import examine, file_check, verify
from mpfcad.store import value_hash

from .edit import MAP, PAGE, PICTURES, RECORD, SOLIDS, WAYS, Files, digest, edit_manifest, restated

JOB = 'name = "forged"\n[map]\ncurvature_per_mm = 60.0\n' + SMALL_STACK


@dataclass
class Outcome:
    """Forgeries found, by their way and by what said so; and those that passed."""

    found: Counter = field(default_factory=Counter)
    unsigned: int = 0
    passed: list[tuple[str, list[str], Files]] = field(default_factory=list)
    by_signature: int = 0
    traced: int = 0
    examined: int = 0


def make_export(folder: Path) -> Path:
    """Return an export of a short trace."""
    (folder / "job.toml").write_text(JOB)
    with mock.patch.dict(TRACE_SETTINGS, quick=TraceSetting(1.0, 20_000)):
        run_job(read_job(folder / "job.toml"), folder / "job.toml", folder / "e", effort="quick")
    return folder / "e"


def _content(folder: Path) -> tuple[bytes, ...]:
    """Return the hashes of the masks and the CAD files."""
    return tuple(digest((folder / name).read_bytes()) for name in SOLIDS)


def forked(function, *arguments):
    """Return what a function gives in a fork of this process, which a crash ends alone."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        code = 1
        try:
            null = os.open(os.devnull, os.O_RDWR)
            os.dup2(null, 1), os.dup2(null, 2)
            try:
                answer = (True, function(*arguments))
            except MpfcadError as error:
                answer = (False, error)
            with os.fdopen(writing, "wb") as pipe:
                pickle.dump(answer, pipe)
            code = 0
        finally:
            os._exit(code)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        data = pipe.read()
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if not data:
        raise ExportError(f"{arguments[0]}: its reader crashed ({status})")
    good, answer = pickle.loads(data)
    if not good:
        raise answer
    return answer


@contextmanager
def memoised(outcome: Outcome, most: int = 40) -> Iterator[None]:
    """Take what is done again with the same input from a memo."""
    kept: dict[str, dict] = {"trace": {}, "examine": {}, "pages": {}}

    def take(kind, key, make):
        known = kept[kind]
        if key not in known:
            if len(known) >= most:  # the newest; what the export itself needs came first
                known.pop(list(known)[most // 2])
            known[key] = make()
        return known[key]

    def trace(scene, source, blocks, *, seed=1, first=0, threads=1, after_block=None):
        def make():
            outcome.traced += 1
            return own_trace(scene, source, blocks, seed=seed, first=first, threads=threads)

        return take("trace", value_hash([scene, source, blocks, seed, first]), make)

    def examine_foreign(folder, plan, mask, progress):
        return forked(file_check._examine, folder, plan, mask)

    def examine_all(folder, plan, masks, setting, *rest, **options):
        def make():
            outcome.examined += 1
            return own_examine(folder, plan, masks, setting, *rest, **options)

        key = (_content(folder), digest(pickle.dumps((plan, masks, setting))))
        return take("examine", key, make)

    def find_again(folder, plan, stored, threads, progress):
        record, draw = own_find_again(folder, plan, stored, threads, progress)
        key = (_content(folder), json.dumps(stored))
        return record, lambda given: take("pages", (*key, json.dumps(given)), lambda: draw(given))

    own_trace, own_examine = engine.trace, examine.examine
    own_find_again = verify._find_again
    with (
        mock.patch.object(engine, "trace", trace),
        mock.patch.object(examine, "examine", examine_all),
        mock.patch.object(examine, "examine_foreign", examine_foreign),
        mock.patch.object(verify, "_find_again", find_again),
    ):
        yield


def forge(rng: random.Random, original: Files) -> tuple[str, Files, int | None]:
    """Return a way, the forged files and, where the manifest is edited too, the seed of that."""
    way = rng.choice(WAYS)
    if way is edit_manifest:
        return "edit_manifest", dict(original), rng.getrandbits(32)
    forged = way(rng, original)
    return way.__name__, restated(original, forged) if rng.random() < 0.8 else forged, None


def lay(folder: Path, original: Files, forged: Files, seed: int | None) -> None:
    """Put forged files into the folder of the original ones, every hash computed anew."""
    for name in original.keys() - forged.keys():
        (folder / name).unlink()
    for name, data in forged.items():
        if data is None:
            (folder / name).unlink(missing_ok=True)
            (folder / name).symlink_to(folder.parent / "elsewhere")
        elif data != original.get(name):
            (folder / name).write_bytes(data)
    write_manifest(folder, "forged", "run")
    if seed is not None:
        manifest = json.loads((folder / MANIFEST).read_bytes())
        edit_manifest(random.Random(seed), manifest)
        (folder / MANIFEST).write_bytes(encoded(canonical_json(_sealed(manifest))))


def put_back(folder: Path, original: Files, sealed: dict[str, bytes], forged: Files) -> None:
    """Make the folder what it was."""
    for name in forged.keys() - original.keys():
        (folder / name).unlink()
    for name, data in original.items():
        if forged.get(name) != data:
            (folder / name).unlink(missing_ok=True)
            (folder / name).write_bytes(data)
    for name, data in sealed.items():
        (folder / name).write_bytes(data)


def is_found(check, *arguments) -> bool:
    """Tell whether a check refuses."""
    try:
        check(*arguments)
    except MpfcadError:
        return True
    return False


def _signed(folder: Path, key: Path) -> None:
    check_signature(folder, key)
    check_manifest(folder)


def attack(folder: Path, times: int, seed: int, seconds: float = 1e9) -> Outcome:
    """Forge an export so many times; it is signed, and as it was afterwards."""
    end, outcome, rng = time.monotonic() + seconds, Outcome(), random.Random(f"forge {seed}")
    with tempfile.TemporaryDirectory() as keys, memoised(outcome):
        key = Path(keys) / "key"
        command = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", "maker", "-f", str(key)]
        subprocess.run(command, check=True, capture_output=True)
        sign_export(folder, key)
        (folder.parent / "elsewhere").write_bytes(b"elsewhere")
        _signed(folder, key.with_suffix(".pub"))
        verify_export(folder, threads=1)
        sealed = {n: (folder / n).read_bytes() for n in (MANIFEST, f"{MANIFEST}.sig")}
        original: Files = {
            path.name: path.read_bytes() for path in folder.iterdir() if path.name not in sealed
        }
        outcome.traced = outcome.examined = 0
        for _ in range(times):
            if time.monotonic() > end:
                break
            way, forged, manifest = forge(rng, original)
            if forged == original and manifest is None:
                continue
            lay(folder, original, forged, manifest)
            try:
                outcome.by_signature += is_found(_signed, folder, key.with_suffix(".pub"))
                outcome.unsigned += 1
                if is_found(verify_export, folder):
                    outcome.found[way] += 1
                else:
                    changed = [n for n in {*forged, *original} if forged.get(n) != original.get(n)]
                    outcome.passed.append((way, sorted(changed), forged))
            finally:
                put_back(folder, original, sealed, forged)
    return outcome


def figures(record: bytes) -> dict:
    """Return a record without hashes and without what only the run could know."""
    found = json.loads(record)
    for key in ("sha256", "traced", "inputs_sha256", "versions", "code_sha256", "command"):
        found["provenance"].pop(key, None)
    return found


def shown(page: bytes, files: Files) -> bytes:
    """Return a page without the hashes of the files beside it."""
    for data in files.values():
        page = page.replace(digest(data or b""), b"")
    return page


def wrong(original: Files, way: str, changed: list[str], forged: Files) -> str | None:
    """Return what a forgery that passed has changed though it must not; None where nothing."""
    if forged.keys() != original.keys() or None in forged.values():
        return f"{way}: files"
    for name in (*PICTURES, MAP):
        if forged.get(name) != original.get(name):
            return f"{way}: {name}"
    if figures(forged[RECORD]) != figures(original[RECORD]):
        return f"{way}: a figure"
    if shown(forged[PAGE], forged) != shown(original[PAGE], original):
        before, after = (json.loads(f[RECORD])["provenance"] for f in (original, forged))
        if before == after:  # the page shows versions and command as well
            return f"{way}: the page"
    return None if changed else f"{way}: the manifest"
