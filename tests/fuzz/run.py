"""Runs mutated files through readers: each is read, or refused in one short line with its name.

Guided by what comes of a file: one with a new outcome (a place in the code that raised, a kind of
message) joins the files that are mutated further.
"""

import faulthandler
import multiprocessing
import random
import re
import resource
import signal
import time
import traceback
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import psutil

from mpfcad.cli.stream import one_line
from mpfcad.errors import ExportError, InputError

from .kind import Reader
from .mutate import mutate

#: Longest time of one file [s], and memory of the process [bytes].
TIME_LIMIT, MEMORY_LIMIT = 10.0, 6_000_000_000
_POOL = 400
#: Files that one process reads with a library in C++, and how long it may take of a processor, and
#: of the clock, for one of them [s]: on a busy machine it may wait, a deadlock has no end.
_CHUNK, _BUSY, _SILENT = 5000, TIME_LIMIT, 600.0


class TooSlowError(BaseException):
    """A file took longer than its time on a processor."""


@dataclass
class Tally:
    """What came of a reader's files."""

    read: int = 0
    refused: int = 0
    crashed: int = 0
    outcomes: int = 0
    slowest: float = 0.0
    slowest_file: bytes = b""
    faults: list[tuple[str, bytes]] = field(default_factory=list)


def limit_memory() -> None:
    """Have a file that asks for too much memory raise instead of taking the machine's."""
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, hard))


def fuzz(reader: Reader, count: int, seed: int, folder: Path, seconds: float) -> Tally:
    """Return what came of up to `count` mutated files within `seconds`."""
    work = Work(reader, random.Random(f"{seed} {reader.name}"), folder / f"in{reader.suffix}")
    end = time.monotonic() + seconds
    if reader.native:
        _warm(work)
    while work.done < count and time.monotonic() < end:
        chunk = min(_CHUNK, count - work.done)
        work = _apart(work, chunk, end) if reader.native else work.go(chunk, end)
    work.tally.outcomes = len(work.known)
    return work.tally


def _warm(work: "Work") -> None:
    """Read a file to begin from, so that a process after a crash need not load its libraries."""
    work.path.write_bytes(work.pool[0])
    with suppress(InputError, ExportError):
        work.reader.read(work.path)


def _apart(work: "Work", count: int, end: float) -> "Work":
    """Go on in a process of its own, so that a crash or an endless call is a fault of its file."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    alive = context.Value("q", 0)

    def run() -> None:
        faulthandler.disable()  # a crash is counted, its stack is nobody's concern
        there.send(work.go(count, end, alive))

    child = context.Process(target=run, daemon=True)
    before = work.done
    child.start()
    there.close()
    seen, since, busy = -1, time.monotonic(), _processor_time(child.pid)
    trouble = ""
    while not here.poll(0.5):
        if alive.value != seen:
            seen, since, busy = alive.value, time.monotonic(), _processor_time(child.pid)
        if not child.is_alive() and not here.poll(0.1):
            trouble = f"crash: exit code {child.exitcode}"
            break
        if _processor_time(child.pid) - busy > _BUSY or time.monotonic() - since > _SILENT:
            trouble = f"no end within {_BUSY:g} s of a processor, {_SILENT:g} s of the clock"
            child.kill()
            break
    if not trouble:
        try:
            found = here.recv()
            child.join()
            return found
        except EOFError:
            child.join()
            trouble = f"crash: exit code {child.exitcode}"
    child.join()
    data = work.path.read_bytes() if work.path.exists() else b""
    if work.reader.apart:  # the program stops it as well
        work.tally.crashed += 1
    else:
        work.tally.faults.append((trouble, data))
    work.tally.refused += max(alive.value - before - 1, 0)
    work.done = max(alive.value, before + 1)
    work.rng.seed(f"{work.done} {work.reader.name}")
    return work


def _processor_time(pid: int | None) -> float:
    """Return the time [s] that a process has had of a processor; of one that has ended, 0."""
    with suppress(psutil.Error):
        times = psutil.Process(pid).cpu_times()
        return times.user + times.system
    return 0.0


@dataclass
class Work:
    """A reader's files so far: what is mutated further, what came of them."""

    reader: Reader
    rng: random.Random
    path: Path
    pool: list[bytes] = field(default_factory=list)
    known: set[str] = field(default_factory=set)
    tally: Tally = field(default_factory=Tally)
    done: int = 0
    whole: int = 0

    def __post_init__(self) -> None:
        self.pool = list(self.reader.seeds)
        self.whole = len(self.pool)

    def __getstate__(self) -> dict:
        return {**self.__dict__, "reader": self.reader.name}

    def __setstate__(self, state: dict) -> None:
        from .reader import readers

        self.__dict__ = state
        (self.reader,) = (reader for reader in readers() if reader.name == state["reader"])

    def go(self, count: int, end: float, alive: object = None) -> "Work":
        """Read so many more files, until a moment; `alive` is told the number of each."""
        before = signal.signal(signal.SIGVTALRM, _too_slow)
        try:
            for _ in range(count):
                if time.monotonic() > end:
                    break
                self.done += 1
                if alive is not None:
                    alive.value = self.done
                self._next()
        finally:
            signal.setitimer(signal.ITIMER_VIRTUAL, 0)
            signal.signal(signal.SIGVTALRM, before)
        return self

    def _next(self) -> None:
        # Half of them from a file that is read whole: most others are refused at their first line.
        whole = self.pool[: self.whole] if self.rng.random() < 0.5 else self.pool
        data = mutate(self.rng, self.rng.choice(whole), self.rng.choice(self.pool))
        outcome = _one(self.reader, self.path, data, self.tally)
        if outcome not in self.known:
            self.known.add(outcome)
            if len(self.pool) < _POOL and len(data) < 80_000:
                self.pool.append(data)


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
    except (InputError, ExportError) as error:
        tally.refused += 1
        outcome = _kind(error)
        fault = _fault(reader.named or path.name, str(error))
        if fault:
            tally.faults.append((f"{fault}: {error}"[:500], data))
    except (TooSlowError, Exception) as error:
        outcome = _kind(error)
        text = "".join(traceback.format_exception(error)[-2:])
        tally.faults.append((f"{type(error).__name__}: {text}"[:800], data))
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    took = time.process_time() - start
    if took > tally.slowest:
        tally.slowest, tally.slowest_file = took, data
    with suppress(FileNotFoundError):
        path.unlink()
    return outcome


def _fault(name: str, text: str) -> str | None:
    """Return what is wrong with a refusal."""
    line = one_line(text)
    if name not in line:
        return "does not name the file"
    if not line.isprintable() or len(line) > 292:
        return "no short line"
    return None


def _kind(error: BaseException) -> str:
    where = traceback.extract_tb(error.__traceback__)[-1]
    words = re.sub(r"[-\d.]+|'[^']*'", "#", str(error))[-60:]
    return f"{Path(where.filename).name}:{where.lineno} {words}"
