"""Writes and reads the store's entries: each whole or absent, each with a checksum.

An entry is a line of JSON (kind, key, code, size, SHA-256 of what follows) and the content. It is
written beside its name, flushed to the disk and renamed. Reading makes the line anew from what
follows and compares both, so no change of any byte of the file goes unseen.
"""

import hashlib
import json
import os
import secrets
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from mpfcad.store.code import work_hash
from mpfcad.store.folder import cache_folder
from mpfcad.store.notice import say

Value = TypeVar("Value")

#: What is kept, and in words.
KINDS = {
    "trace": "half-done traces",
    "figure": "measured figures",
    "point": "points of sweeps",
    "fit": "traces of fits",
    "design": "traces and models of designs",
    "kernel": "compiled kernels",
}
SUFFIX, DAMAGED, PART = ".kept", ".damaged", ".part"

#: Kind and key of what this process has kept or taken.
_touched: set[tuple[str, str]] = set()


def is_work_kept() -> bool:
    """Tell whether this process has kept or taken work that a next one goes on with."""
    return any(kind != "kernel" for kind, _ in _touched)


def code_of(kind: str) -> str:
    """Return the hash of the code that an entry of a kind comes from, as its first line has it."""
    return work_hash(kind)[:16]


def _first_line(kind: str, key: str, content: bytes) -> bytes:
    line = {
        "store": 1,
        "kind": kind,
        "key": key,
        "code": code_of(kind),
        "bytes": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
    return json.dumps(line).encode() + b"\n"


class Store:
    """Finished work in a folder; `None` keeps nothing and finds nothing.

    `note` is told, in one line each, what was damaged and that nothing can be kept.
    """

    def __init__(self, folder: Path | None = None, note: Callable[[str], None] = say) -> None:
        self.folder = folder
        self._note = note
        self._refused = False

    @classmethod
    def open(cls, note: Callable[[str], None] = say) -> "Store":
        """Return the user's store."""
        return cls(cache_folder(), note)

    def path(self, kind: str, key: str) -> Path:
        """Return the file of an entry."""
        if self.folder is None:
            raise ValueError("a store without folder has no files")
        return self.folder / kind / f"{key[:40]}{SUFFIX}"

    def read(self, kind: str, key: str, decode: Callable[[bytes], Value]) -> Value | None:
        """Return what is kept under a key, decoded; None when there is nothing that verifies."""
        if self.folder is None:
            return None
        path = self.path(kind, key)
        try:
            line, found, content = path.read_bytes().partition(b"\n")
        except FileNotFoundError:
            return None
        except OSError as error:
            self._note(f"{path}: kept work cannot be read ({error.strerror}): computed again")
            return None
        if line + found != _first_line(kind, key, content):
            self._set_aside(path, "its checksum does not hold")
            return None
        try:
            value = decode(content)
        except Exception as error:
            self._set_aside(path, f"{type(error).__name__}: {error}")
            return None
        with suppress(OSError):
            os.utime(path)  # its age is counted from its last use
        _touched.add((kind, key))
        return value

    def write(self, kind: str, key: str, content: bytes) -> None:
        """Keep content under a key; where that fails, say so once and go on."""
        if self.folder is None:
            return
        path = self.path(kind, key)
        part = path.with_name(f".{path.stem}.{os.getpid()}.{secrets.token_hex(4)}{PART}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with part.open("xb") as file:
                file.write(_first_line(kind, key, content) + content)
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
            flush_folder(path.parent)
            _touched.add((kind, key))
        except OSError as error:
            if not self._refused:
                self._refused = True
                reason = error.strerror or error
                self._note(f"{self.folder}: {reason}: what is done now is not kept for a next run")
        finally:
            with suppress(OSError):
                part.unlink(missing_ok=True)

    def read_json(self, kind: str, key: str) -> Any:
        """Return the JSON value kept under a key, or None."""
        return self.read(kind, key, json.loads)

    def keep_json(self, kind: str, key: str, value: Any) -> Any:
        """Keep a JSON value, and return it as it will be read: fresh and kept are the same."""
        text = json.dumps(value, allow_nan=False)
        self.write(kind, key, text.encode())
        return json.loads(text)

    def drop(self, kind: str, key: str) -> None:
        """Remove an entry, if it is there."""
        if self.folder is not None:
            _touched.discard((kind, key))
            with suppress(OSError):
                self.path(kind, key).unlink(missing_ok=True)

    def _set_aside(self, path: Path, reason: str) -> None:
        aside = path.with_suffix(DAMAGED)
        try:
            path.replace(aside)
            where = f"set aside as {aside.name}"
        except OSError as error:
            where = f"left there ({error.strerror})"
        self._note(f"{path}: kept work does not verify ({reason}): {where}, computed again")


def flush_folder(folder: Path) -> None:
    """Have a folder's list of names on the disk, where the system can."""
    if os.name == "nt":
        return
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
