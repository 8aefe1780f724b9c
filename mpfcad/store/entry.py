"""What lies in a store: sizes and ages by kind, and what no run of this version can use."""

import json
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from mpfcad.store.keep import DAMAGED, KINDS, PART, SUFFIX, code_of

_DAY = 86400.0
#: A file that is being written is younger; one that a killed run left is not.
_PART_AGE = 3600.0
_LINE_LIMIT = 1000


@dataclass(frozen=True)
class Entry:
    """A file of the store.

    Attributes
    ----------
    kind
        one of `KINDS`
    state
        `kept`; `old`: of another version's code; `damaged`: set aside; `part`: left by a killed run
    size
        [bytes]
    age
        since its last use [days]
    """

    path: Path
    kind: str
    state: str
    size: int
    age: float


def list_entries(folder: Path) -> list[Entry]:
    """Return what lies in a store, by kind; files that are none of its own are left out."""
    return [entry for kind in KINDS for entry in _of_kind(folder / kind, kind)]


def _of_kind(folder: Path, kind: str) -> Iterator[Entry]:
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        with suppress(OSError):
            state, status = _state(path, kind), path.lstat()
            age = max(0.0, time.time() - status.st_mtime)
            if state and not (state == "part" and age < _PART_AGE) and path.is_file():
                yield Entry(path, kind, state, status.st_size, age / _DAY)


def _state(path: Path, kind: str) -> str | None:
    if path.suffix == DAMAGED:
        return "damaged"
    if path.suffix == PART and path.name.startswith("."):
        return "part"
    if path.suffix != SUFFIX:
        return None
    with path.open("rb") as file:
        line = file.readline(_LINE_LIMIT)
    try:
        return "kept" if json.loads(line)["code"] == code_of(kind) else "old"
    except (ValueError, TypeError, KeyError):
        return "damaged"


def prune(folder: Path, *, days: float | None = None, everything: bool = False) -> list[Entry]:
    """Remove what this version cannot use, or what is older than `days`, or all; return it.

    Only files that a store has written are touched.
    """
    gone = []
    for entry in list_entries(folder):
        old = days is not None and entry.age > days
        if everything or old or entry.state != "kept":
            with suppress(OSError):
                entry.path.unlink()
                gone.append(entry)
    return gone
