"""The export folder: it appears whole or not at all, and a manifest holds the hash of every file.

A job writes into a hidden sibling `.NAME.partial-PID`; when all is there each file is fsynced and
the folder takes its name in one step. An older export is exchanged for the new one in that same
step where the kernel can (`renameat2`), else moved aside first and put back by the next run if the
process dies between the two moves. Folders that killed runs left behind are removed by the next.
"""

import ctypes
import hashlib
import json
import os
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from mpfcad.errors import ExportError, InputError

if sys.platform != "win32":
    import fcntl

MANIFEST = "manifest.json"
_AT_FDCWD = -100
_RENAME_EXCHANGE = 2


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file as 64 hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def canonical_json(value: Any) -> str:
    """Return `value` as JSON with a fixed layout; floats round-trip exactly, NaN is refused."""
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def write_text(path: Path, text: str) -> None:
    """Write `text` as UTF-8 with bare line feeds on every system."""
    path.write_bytes(text.encode())


@contextmanager
def export_folder(out: Path, kind: str) -> Iterator[Path]:
    """Give an empty folder that becomes `out` when the block ends well, and vanishes otherwise.

    `kind` is that of the manifest to come: an export of another kind is not replaced.

    Raises
    ------
    InputError
        when `out` is something else than an export of this kind, or cannot be written.
    """
    out = Path(out).resolve()
    refuse_foreign(out, kind)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        _tidy(out)
        partial = out.parent / f".{out.name}.partial-{os.getpid()}"
        partial.mkdir()
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror or error}") from None
    lock = _lock(partial)
    try:
        yield partial
        _flush(partial)
        _publish(partial, out)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def refuse_foreign(out: Path, kind: str) -> None:
    """Refuse to replace anything but an older export of the same `kind`.

    Raises
    ------
    InputError
        when `out` is a file, or a folder with anything else in it.
    """
    if out.is_dir():
        if any(out.iterdir()) and _kind(out / MANIFEST) != kind:
            raise InputError(f"{out}: folder holds no {kind} export: must be empty or not exist")
    elif out.exists():
        raise InputError(f"{out}: is a file: must be a folder or not exist")


def _kind(manifest: Path) -> str | None:
    try:
        return json.loads(manifest.read_bytes())["kind"]
    except (OSError, ValueError, TypeError, KeyError):
        return None


def write_manifest(folder: Path, name: str, kind: str) -> None:
    """Write manifest.json: size and SHA-256 of every other file, and a hash of itself."""
    files = {
        path.name: {"sha256": sha256(path), "bytes": path.stat().st_size}
        for path in sorted(folder.iterdir())
        if path.name != MANIFEST
    }
    manifest = {"schema": 1, "name": name, "kind": kind, "files": files}
    write_text(folder / MANIFEST, canonical_json(_sealed(manifest)))


def check_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of `folder` after hashing every file in it.

    Raises
    ------
    InputError
        when there is no manifest.
    ExportError
        naming the first file that is changed, missing or not of the export.
    """
    path = folder / MANIFEST
    if not path.is_file():
        raise InputError(f"{path}: no such file: {folder} is no export of mpfcad")
    manifest = _read_sealed(path)
    for name, entry in manifest["files"].items():
        file = folder / name
        if not file.is_file():
            raise ExportError(f"{file}: missing")
        digest = sha256(file)
        if digest != entry["sha256"] or file.stat().st_size != entry["bytes"]:
            raise ExportError(f"{file}: changed: SHA-256 is {digest}, not {entry['sha256']}")
    for file in sorted(folder.iterdir()):
        if file.name != MANIFEST and file.name not in manifest["files"]:
            raise ExportError(f"{file}: not in the manifest")
    return manifest


def _sealed(manifest: dict[str, Any]) -> dict[str, Any]:
    body = {key: value for key, value in manifest.items() if key != "self_sha256"}
    return {**body, "self_sha256": hashlib.sha256(canonical_json(body).encode()).hexdigest()}


def _read_sealed(path: Path) -> dict[str, Any]:
    """Return a manifest whose bytes are exactly those that `write_manifest` writes."""
    content = path.read_bytes()
    try:
        manifest = json.loads(content)
        intact = canonical_json(_sealed(manifest)).encode() == content
        intact = intact and isinstance(manifest["files"], dict)
    except (ValueError, TypeError, KeyError, AttributeError):
        intact = False
    if not intact:
        raise ExportError(f"{path}: changed: it does not match its own self_sha256")
    return manifest


def _lock(folder: Path) -> int | None:
    """Hold a lock on `folder` for as long as the process lives; None where there is no flock."""
    if sys.platform == "win32":
        return None
    descriptor = os.open(folder, os.O_RDONLY)
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return descriptor


def _is_abandoned(folder: Path) -> bool:
    """Tell whether the run that made `folder` is dead: nobody holds its lock."""
    try:
        lock = _lock(folder)
    except OSError:
        return False
    if lock is None:
        return False
    os.close(lock)
    return True


def _tidy(out: Path) -> None:
    """Remove what killed runs left beside `out`, and put a stranded old export back."""
    for stale in out.parent.glob(f".{out.name}.old-*"):
        if not out.exists():
            stale.rename(out)
        elif _is_abandoned(stale):
            shutil.rmtree(stale, ignore_errors=True)
    for stale in out.parent.glob(f".{out.name}.partial-*"):
        if _is_abandoned(stale):
            shutil.rmtree(stale, ignore_errors=True)


def _flush(folder: Path) -> None:
    """Have every file of `folder`, and the folder itself, on the disk."""
    if sys.platform == "win32":
        return
    for path in (*folder.iterdir(), folder):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def _publish(partial: Path, out: Path) -> None:
    """Give `partial` the name `out`; what was there before is then in `partial` or gone."""
    if not out.exists():
        partial.rename(out)
    elif not _exchange(partial, out):
        old = partial.with_name(f".{out.name}.old-{os.getpid()}")
        out.rename(old)
        partial.rename(out)
        shutil.rmtree(old, ignore_errors=True)
    with suppress(OSError):
        _flush_folder(out.parent)


def _flush_folder(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _exchange(first: Path, second: Path) -> bool:
    """Swap two paths in one atomic step; False where the kernel or C library cannot."""
    if not sys.platform.startswith("linux"):
        return False
    rename = getattr(ctypes.CDLL(None), "renameat2", None)
    if rename is None:
        return False
    code = rename(_AT_FDCWD, os.fsencode(first), _AT_FDCWD, os.fsencode(second), _RENAME_EXCHANGE)
    return code == 0
