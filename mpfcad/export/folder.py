"""The export folder: it appears whole or not at all, and nothing of the user's is lost.

A job writes into a hidden sibling `.NAME.partial-PID`; when all is there each file is fsynced and
the folder takes its name in one step. An older export is exchanged for the new one in that same
step where the kernel can (`renameat2`), else moved aside first and put back by the next run if the
process dies between the two moves. Beside each hidden folder lies its lock, a file of its own: a
hidden folder without one is not ours and never touched, and one whose lock nobody holds was left
by a killed run and is cleared away by the next.

What lies in an older export and was not made by mpfcad, or was edited since, goes over into the new
one.
"""

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from mpfcad.boundary.out import refuse_file_above
from mpfcad.boundary.signals import signals_wait
from mpfcad.errors import ExportError, InputError
from mpfcad.export.exchange import exchange, flush
from mpfcad.export.manifest import MANIFEST, SIGNATURE, is_own, kind_of, read_entries
from mpfcad.store.notice import say

_LOCK = ".lock"
#: What the system says of a disk that takes no more.
_OF_DISKS = tuple(
    getattr(errno, name) for name in ("ENOSPC", "EDQUOT", "EIO", "EFBIG") if hasattr(errno, name)
)


@contextmanager
def export_folder(out: Path, kind: str) -> Iterator[Path]:
    """Give an empty folder that becomes `out` when the block ends well, and vanishes otherwise.

    `kind` is that of the manifest to come: an export of another kind is not replaced.

    Raises
    ------
    InputError
        when `out` is something else than an export of this kind, or cannot be written.
    ExportError
        when the disk gets full, or fails.
    """
    out = Path(out).resolve()
    refuse_foreign(out, kind)
    hidden: tuple[Path, FileLock] | None = None
    try:
        with signals_wait():
            hidden = _begun(out)
        yield hidden[0]
        flush(hidden[0])
        with signals_wait():
            _publish(hidden[0], out)
    except OSError as error:
        # numpy says how many numbers a full disk took, and no more.
        if error.errno not in _OF_DISKS and " requested and " not in str(error):
            raise
        reason = error.strerror or f"only a part of a file was written ({error})"
        raise ExportError(f"{_place(error, hidden, out)}: cannot be written: {reason}") from None
    finally:
        # Ctrl-C while an older export is cleared away leaves none of it either.
        with signals_wait():
            if hidden is not None:
                _clear(hidden[0], out)
                _release(hidden[1])


def _place(error: OSError, hidden: tuple[Path, FileLock] | None, out: Path) -> Path:
    """Return what could not be written: the export, or the file elsewhere that the error names."""
    if hidden is None or not isinstance(error.filename, str):
        return out
    path = Path(error.filename).resolve()
    return out if path.is_relative_to(hidden[0]) else path


def _begun(out: Path) -> tuple[Path, FileLock]:
    """Clear away what killed runs left beside `out`, and return a new hidden folder."""
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        _tidy(out)
        return _hidden(out, "partial")
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror or error}") from None


def refuse_foreign(out: Path, kind: str) -> None:
    """Refuse to replace anything but an older export of the same `kind`.

    Raises
    ------
    InputError
        when `out` is a file or leads through one, or is a folder with anything else in it.
    """
    if out.is_dir():
        if any(out.iterdir()) and kind_of(out) != kind:
            raise InputError(
                f"{out}: folder holds no {kind} export: expected an empty folder or none"
            )
    elif out.exists():
        raise InputError(f"{out}: is a file: expected a folder or nothing")
    refuse_file_above(out)


def _hidden(out: Path, what: str) -> tuple[Path, FileLock]:
    """Make a hidden folder beside `out` that this process holds the lock of."""
    for number in range(1000):
        name = f".{out.name}.{what}-{os.getpid()}" + (f"-{number}" if number else "")
        folder = out.with_name(name)
        if folder.exists() or folder.is_symlink():
            continue
        lock = FileLock(f"{folder}{_LOCK}")
        with suppress(Timeout, FileExistsError):
            lock.acquire(timeout=0)
            folder.mkdir()
            return folder, lock
        _release(lock)
    raise FileExistsError(f"no free name like .{out.name}.{what}-{os.getpid()}")


def _release(lock: FileLock) -> None:
    """Let go of a lock and remove its file."""
    if lock.is_locked:
        if os.name != "nt":
            Path(lock.lock_file).unlink(missing_ok=True)
        lock.release(force=True)
        with suppress(OSError):
            Path(lock.lock_file).unlink(missing_ok=True)


def _left_behind(out: Path, what: str) -> Iterator[tuple[Path, FileLock]]:
    """Give the hidden folders of `out` that a killed run has left, with their locks held."""
    pattern = re.compile(re.escape(f".{out.name}.{what}-") + r"\d+(-\d+)?")
    for folder in sorted(out.parent.iterdir()):
        own = pattern.fullmatch(folder.name) and Path(f"{folder}{_LOCK}").is_file()
        if not own or folder.is_symlink() or not folder.is_dir():
            continue
        lock = FileLock(f"{folder}{_LOCK}")
        try:
            lock.acquire(timeout=0)
        except (Timeout, OSError):
            continue
        try:
            yield folder, lock
        finally:
            _release(lock)


def _tidy(out: Path) -> None:
    """Clear away what killed runs left beside `out`, and put a stranded old export back."""
    for stale, _ in _left_behind(out, "old"):
        if not out.exists():
            stale.rename(out)
        else:
            _clear(stale, out)
    for stale, _ in _left_behind(out, "partial"):
        _clear(stale, out)


def _publish(partial: Path, out: Path) -> None:
    """Give `partial` the name `out`; what was there before is then in `partial` or gone."""
    if not out.exists():
        partial.rename(out)
    elif not exchange(partial, out):
        old, lock = _hidden(out, "old")
        try:
            old.rmdir()
            out.rename(old)
            partial.rename(out)
            _clear(old, out)
        finally:
            _release(lock)
    with suppress(OSError):
        flush(out.parent, files=False)


def _clear(folder: Path, out: Path) -> None:
    """Remove a hidden folder; what is not of mpfcad's making in it goes over into `out`."""
    if (folder / MANIFEST).exists() and out.is_dir():
        _rescue(folder, out)
    shutil.rmtree(folder, ignore_errors=True)


def _rescue(old: Path, out: Path) -> None:
    files, intact = read_entries(old / MANIFEST)
    for path in sorted(old.iterdir()):
        # A signature is of the old manifest alone.
        if (path.name in (MANIFEST, SIGNATURE) and intact) or is_own(path, files):
            continue
        edited = path.name in files or path.name == MANIFEST
        target, number = out / path.name, 0
        while target.exists() or target.is_symlink():
            number += 1
            target = out / f"{path.name}.kept-{number}"
        path.rename(target)
        why = "was edited since it was made" if edited else "is not of the export"
        say(f"{out / path.name}: {why}: kept as {target.name}")
