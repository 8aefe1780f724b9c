"""Runs mutated files through readers: each is read, or refused in one short line with its name.

Guided by what comes of a file: one with a new outcome (a place in the code that raised, a kind of
message) joins the files that are mutated further.
"""

import random
import re
import resource
import signal
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from mpfcad.cli.stream import one_line
from mpfcad.errors import ExportError, InputError

from .mutate import mutate
from .reader import Reader

#: Longest time of one file [s], and memory of the process [bytes].
TIME_LIMIT, MEMORY_LIMIT = 10.0, 6_000_000_000
_POOL = 400


class TooSlowError(BaseException):
    """A file took longer than its time on a processor."""


@dataclass
class Tally:
    """What came of a reader's files."""

    read: int = 0
    refused: int = 0
    outcomes: int = 0
    slowest: float = 0.0
    faults: list[tuple[str, bytes]] = field(default_factory=list)


def limit_memory() -> None:
    """Have a file that asks for too much memory raise instead of taking the machine's."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, hard))


def fuzz(reader: Reader, count: int, seed: int, folder: Path, seconds: float) -> Tally:
    """Return what came of up to `count` mutated files within `seconds`."""
    rng, tally = random.Random(f"{seed} {reader.name}"), Tally()
    pool, known = list(reader.seeds), set()
    path = folder / f"in{reader.suffix}"
    end = time.monotonic() + seconds
    before = signal.signal(signal.SIGVTALRM, _too_slow)
    try:
        for _ in range(count):
            if time.monotonic() > end:
                break
            data = mutate(rng, rng.choice(pool), rng.choice(pool))
            outcome = _one(reader, path, data, tally)
            if outcome not in known:
                known.add(outcome)
                if len(pool) < _POOL and len(data) < 40_000:
                    pool.append(data)
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)
    tally.outcomes = len(known)
    return tally


def _too_slow(number: int, frame: object) -> None:
    raise TooSlowError


def _one(reader: Reader, path: Path, data: bytes, tally: Tally) -> str:
    """Read one file; return what came of it, in few words."""
    path.write_bytes(data)
    start = time.process_time()
    signal.setitimer(signal.ITIMER_VIRTUAL, TIME_LIMIT)
    try:
        reader.read(path)
        tally.read += 1
        outcome = "read"
    except InputError as error:
        tally.refused += 1
        outcome = _kind(error)
        fault = _fault(path, str(error))
        if fault:
            tally.faults.append((f"{fault}: {error}"[:500], data))
    except ExportError as error:
        tally.refused += 1
        outcome = _kind(error)
    except (TooSlowError, Exception) as error:
        outcome = _kind(error)
        text = "".join(traceback.format_exception(error)[-2:])
        tally.faults.append((f"{type(error).__name__}: {text}"[:800], data))
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    tally.slowest = max(tally.slowest, time.process_time() - start)
    with suppress(FileNotFoundError):
        path.unlink()
    return outcome


def _fault(path: Path, text: str) -> str | None:
    """Return what is wrong with a refusal."""
    line = one_line(text)
    if path.name not in line:
        return "does not name the file"
    if not line.isprintable() or len(line) > 292:
        return "no short line"
    return None


def _kind(error: BaseException) -> str:
    where = traceback.extract_tb(error.__traceback__)[-1]
    words = re.sub(r"[-\d.]+|'[^']*'", "#", str(error))[-60:]
    return f"{Path(where.filename).name}:{where.lineno} {words}"
