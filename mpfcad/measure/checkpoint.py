"""Half-done traces on disk: what an interrupted trace has tallied, so that it can go on.

A checkpoint is one small file, named for the hash of everything that the tally depends on: the
mesh's bytes, the scene's numbers, the meter, the seed, the goal, and the tracer's own code. It is
written after each round beside its name and renamed, so it is whole or absent; floats are kept bit
for bit, and rounds are always the same, so a trace that goes on ends with the same bits as one that
was never interrupted.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpfcad.errors import InputError

if TYPE_CHECKING:
    from mpfcad.optics.base.recorder import Tally

_ROOM = Path(__file__).parents[1]
#: The folders whose code a tally depends on.
_CODE = ("optics", "backlight", "measure")


@cache
def code_hash() -> str:
    """Return the SHA-256 of the code and library versions that a traced figure comes from."""
    digest = hashlib.sha256()
    for folder in _CODE:
        for path in sorted((_ROOM / folder).rglob("*.py")):
            digest.update(str(path.relative_to(_ROOM)).encode() + b"\0" + path.read_bytes())
    for package in ("numba", "numpy"):
        digest.update(f"{package} {version(package)}".encode())
    return digest.hexdigest()


def case_hash(case: Mapping[str, Any]) -> str:
    """Return the SHA-256 of plain values and arrays that say what is traced, and of the code."""
    plain = {key: v.tolist() if isinstance(v, np.ndarray) else v for key, v in case.items()}
    text = json.dumps({**plain, "code": code_hash()}, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def array_hash(values: Any) -> str:
    """Return the SHA-256 of arrays and numbers in nested tuples: all that the kernels read."""
    digest = hashlib.sha256()

    def add(value: Any) -> None:
        if isinstance(value, tuple):
            digest.update(f"({len(value)}".encode())
            for part in value:
                add(part)
        else:
            array = np.asarray(value)
            digest.update(f"{array.dtype}{array.shape}".encode() + array.tobytes())

    add(values)
    return digest.hexdigest()


class Checkpoints:
    """The checkpoints of one piece of work, in a folder; None keeps nothing.

    As a context manager it removes them when the work ends well, and leaves them otherwise.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = folder
        self._used: set[Path] = set()

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            for path in self._used:
                path.unlink(missing_ok=True)

    def _path(self, case: str) -> Path:
        return self.folder / f"{case[:32]}.npz"

    def read(self, case: str) -> "Tally | None":
        """Return the tally of a case by its hash, or None when there is none.

        Raises
        ------
        InputError
            when the file is damaged.
        """
        from mpfcad.optics.base.recorder import Tally

        if self.folder is None or not self._path(case).is_file():
            return None
        path = self._path(case)
        try:
            with np.load(path, allow_pickle=False) as stored:
                values = dict(stored)
            if str(values.pop("case")) != case:
                raise ValueError("of another case")
            whole = {name: int(values.pop(name)) for name in ("paths", "blocks")}
            tally = Tally(**values, **whole)
        except Exception as error:
            raise InputError(f"{path}: damaged checkpoint ({error}): delete it") from None
        self._used.add(path)
        return tally

    def write(self, case: str, tally: "Tally") -> None:
        """Keep the tally of a case's blocks so far."""
        if self.folder is None:
            return
        path = self._path(case)
        self._used.add(path)
        part = path.with_name(f".{path.name}.{os.getpid()}.part")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with part.open("wb") as file:
                np.savez(file, case=case, **tally._asdict())
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
