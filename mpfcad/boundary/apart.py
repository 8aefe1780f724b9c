"""Calls in a process of their own: a file that makes a library in C++ crash takes only that along.

What the libraries print there is dropped; what goes wrong is one line that names the file. A call
that does not end is stopped, where the system counts a process's time: not on Windows.
"""

import importlib
import math
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from mpfcad.boundary.file import guarded
from mpfcad.errors import InputError, MpfcadError

Value = TypeVar("Value")
_CHILD = "from mpfcad.boundary.apart import serve; serve()"
#: Time of a processor that a call may take once its libraries are loaded, and more of it for what
#: it reads [s, s a megabyte]: ten times what checking a film of a lamp pitch takes.
_PATIENCE, _PATIENCE_MB = 10.0, 60.0
_told: Callable[[str], None] | None = None


def apart(
    where: object,
    expected: str,
    function: Callable[..., Value],
    *arguments: Any,
    kind: type[MpfcadError] = InputError,
    stage: Callable[[str], None] | None = None,
    libraries: tuple[str, ...] = (),
) -> Value:
    """Return what a function of a module gives for these arguments, called in another process.

    `stage` is called with what the function tells by `tell_stage`; the last one stands in the line
    of a crash. `libraries` are modules that are slow to load; that is none of the call's time.

    Raises
    ------
    InputError
        or `kind`, when the process ends without an answer, or not at all: beginning with `where`.
    """
    patience = _patience(arguments)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    child = subprocess.Popen(
        [sys.executable, "-c", _CHILD], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, env=environment,
    )  # fmt: skip
    last = ""
    try:
        assert child.stdin is not None and child.stdout is not None
        with suppress(BrokenPipeError), child.stdin as call:
            pickle.dump((libraries, patience), call)
            pickle.dump((str(where), expected, function, arguments, kind), call)
        while True:
            try:
                word, value = pickle.load(child.stdout)
            except (EOFError, pickle.UnpicklingError):
                break
            if word == "answer":
                return value
            if word == "error":
                raise value
            last = f" while {value}"
            if stage is not None:
                stage(value)
    finally:
        child.kill()
        child.wait()
    end = _end(child.returncode)
    trouble = f"crashed{last} ({end})"
    if end == "SIGXCPU":
        trouble = f"did not end within {patience} s of a processor{last}"
    raise kind(f"{where}: its reader {trouble}: expected {expected}")


def _patience(arguments: tuple[Any, ...]) -> int:
    """Return how long a call may take, by the size of the files and folders that it is given."""
    size = 0
    for path in (entry for entry in arguments if isinstance(entry, Path)):
        files = path.iterdir() if path.is_dir() else (path,)
        size += sum(file.stat().st_size for file in files if file.is_file())
    return round(_PATIENCE + _PATIENCE_MB * size / 1e6)


def _limit_time(seconds: int) -> None:
    """Have the system end this process after so much more time of a processor."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        ends = seconds + math.ceil(time.process_time())
        resource.setrlimit(resource.RLIMIT_CPU, (ends, most))


def tell_stage(text: str) -> None:
    """Tell the process that asked what begins; nobody where the call is not apart."""
    if _told is not None:
        _told(text)


def serve() -> None:
    """Answer the one call that comes on standard input."""
    global _told
    # Libraries print on descriptor 1; the answer has one of its own.
    answer = os.fdopen(os.dup(1), "wb")
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    libraries, patience = pickle.load(sys.stdin.buffer)
    for library in libraries:
        with suppress(ImportError):  # the call says what is missing
            importlib.import_module(library)
    where, expected, function, arguments, kind = pickle.load(sys.stdin.buffer)
    _limit_time(patience)

    def tell(word: str, value: object) -> None:
        answer.write(pickle.dumps((word, value)))
        answer.flush()

    _told = lambda text: tell("stage", text)  # noqa: E731
    try:
        with guarded(where, expected, kind):
            tell("answer", function(*arguments))
    except MpfcadError as error:
        tell("error", type(error)(str(error)))


def _end(code: int) -> str:
    with suppress(ValueError):
        return signal.Signals(-code).name
    return f"exit code {code}"
