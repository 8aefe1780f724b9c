"""Kills at random moments of run, design, sweep, correct and fit.

Each leaves the old export or the new one, whole; what it kept of its work reads back. The same
command is given again, to be killed again or to end with the same bytes. So that a kill costs a
second or two, each command runs in a fork of a warm process, on a small film with few paths, and
is killed after a share of the processor's time that it takes, however busy the machine is. Before
it there is an export of other content under the same name.
"""

import io
import os
import random
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np
import psutil
from command import SMALL_STACK, content
from few_paths import few_paths

from mpfcad.cli import run_app
from mpfcad.design.grid import Grid
from mpfcad.export import check_manifest
from mpfcad.pipeline.design import work
from mpfcad.pipeline.fit import tracer
from mpfcad.store import Store

RUN = 'name = "a"\nseed = {seed}\n[map]\ncurvature_per_mm = 60.0\n' + SMALL_STACK
SWEEP = """name = "a"
seed = {seed}
[axis]
"map.curvature_per_mm" = [50.0, 60.0]
[trace]
half_width = 0.0
paths_million = 0.02
"""
DESIGN = (
    """schema = 1
name = "a"
seed = {seed}
[goal]
contrast_target = 0.000001
[constraint]
curvature_min_per_mm = 55.0
curvature_max_per_mm = 62.0
harmonics = 1
[search]
iterations = 1
paths_million = 0.02
[mask]
period_um = 640.0
"""
    + SMALL_STACK
)
FIT = """name = "a"
seed = {seed}
values = ["reflector_reflectance"]
[stack]
preset = "thesis-32in-mpf"
[stack.override]
reflector_reflectance = { value = 0.9, sigma = 0.05 }
[case.mpf]
curvature_per_mm = 60.0
[case.bef]
[[measurement]]
case = "mpf"
over = "bef"
of = "luminance"
value = 0.94
sigma = 0.004
"""
COMMANDS = {
    "run": (RUN, ["run", "job.toml", "--effort", "quick", "--threads", "1"]),
    "sweep": (SWEEP, ["sweep", "job.toml", "--workers", "1"]),
    "design": (DESIGN, ["design", "job.toml", "--no-verify", "--threads", "1"]),
    "correct": (RUN, ["correct", "export", "--measured", "m.csv", "--threads", "1"]),
    "fit": (FIT, ["fit", "job.toml", "--effort", "quick", "--threads", "1"]),
}
#: What kills, in turn.
SIGNALS = (signal.SIGINT, signal.SIGKILL, signal.SIGTERM, signal.SIGKILL)
#: Time of a processor that no command takes [s].
LONGEST = 600.0
#: Share of the kills that come at a command's end, where it writes its files, and how much of its
#: time that is; share of the kills after which the command is let run to its end.
LATE, LAST, ENDS = 0.25, 0.15, 0.3
#: Parts of a second that the processor's time is looked at.
LOOK = 0.003


@contextmanager
def quick(cache: Path) -> Iterator[None]:
    """Trace as little as can be, and keep work in a folder of this test."""
    with (
        mock.patch.dict(os.environ, MPFCAD_CACHE=str(cache)),
        few_paths(),
        mock.patch.dict(tracer.ROUND_PATHS, quick=0.05),
        mock.patch.object(tracer, "_POSITION", np.linspace(0, 1, 17)),
        mock.patch.object(work, "Grid", lambda: Grid(cells=18, across=8, along=2)),
    ):
        yield


def warm(folder: Path) -> None:
    """Load libraries and kernels, which all forks then have."""
    (folder / "warm.toml").write_text(RUN.format(seed=3))
    job = [str(folder / "warm.toml"), "--out", str(folder / "warm")]
    with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        assert run_app(["run", *job, "--effort", "quick", "--threads", "1"]) in (0, 1)


def started(arguments, out):
    """Return the process that runs a command in a fork of this one."""
    child = os.fork()
    if child:
        return child
    code = 70
    try:
        null = os.open(os.devnull, os.O_RDWR)
        for descriptor in (0, 1, 2):
            os.dup2(null, descriptor)
        from mpfcad.cli import main

        sys.argv = ["mpfcad", *arguments, "--out", str(out)]
        main()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    finally:
        os._exit(code)


def ended(child, seconds, number):
    """Send a signal after so much time of a processor; return the status, and whether it was hit.

    What the process has taken in all [s] is the third value.
    """
    process, hit = psutil.Process(child), False
    while not hit:
        done, status, used = os.wait4(child, os.WNOHANG)
        if done:
            return status, False, used.ru_utime + used.ru_stime
        taken = process.cpu_times()
        hit = taken.user + taken.system >= seconds
        time.sleep(LOOK)
    os.kill(child, number)
    _, status, used = os.wait4(child, 0)
    return status, True, used.ru_utime + used.ru_stime


def forgotten(cache):
    """Remove the kept work, but for compiled kernels."""
    for path in cache.iterdir():
        if path.name != "kernel":
            shutil.rmtree(path, ignore_errors=True)


def measured(folder):
    x = np.arange(0.0, 8.0, 0.02)  # a lamp pitch from wherever a lamp is
    rows = np.stack([x, 6000 * (1 + 0.01 * np.cos(2 * np.pi * x / 4))], 1)
    np.savetxt(folder / "m.csv", rows, "%.4f", ",", header="position_mm,luminance", comments="")


@dataclass
class Killed:
    """A command with two contents of its export, what stood there and what is on its way.

    `seconds` of a processor are what it takes from nothing but compiled kernels.
    """

    folder: Path
    arguments: list[str]
    versions: list[dict[str, bytes]]
    seconds: float

    @property
    def out(self) -> Path:
        """Where its export is."""
        return self.folder / "exports" / "a"

    @property
    def cache(self) -> Path:
        """Where its work is kept."""
        return self.folder / "cache"


def prepare(folder: Path, command: str) -> Killed:
    """Run a command twice, with another seed or place of the lamps each time."""
    text, arguments = COMMANDS[command]
    arguments = [str(folder / a) if a in ("job.toml", "export", "m.csv") else a for a in arguments]
    killed, job = Killed(folder, arguments, [], 0.0), folder / "job.toml"
    job.write_text(RUN.format(seed=1))
    if command == "correct":
        measured(folder)
        assert finished(["run", str(job), "--effort", "quick"], folder / "export")[0] in (0, 1)
    for number in (1, 2):
        job.write_text(text.replace("{seed}", str(number)))
        place = ["--lamp-at-mm", str(number)] if command == "correct" else []
        killed.arguments = [*arguments, *place]
        code, killed.seconds = finished(killed.arguments, killed.out)
        assert code in (0, 1), command
        killed.versions.append(content(killed.out))
        check_manifest(killed.out)
        forgotten(killed.cache)
    assert killed.versions[0] != killed.versions[1]
    return killed


def finished(arguments, out):
    """Return the exit code of a command that is not killed, and its time of a processor [s]."""
    status, hit, seconds = ended(started(arguments, out), LONGEST, signal.SIGKILL)
    assert not hit
    return os.waitstatus_to_exitcode(status), seconds


def refused_work(cache: Path) -> list[str]:
    """Return the entries of kept work that do not read back."""
    store, notes = Store(cache), []
    store._note = notes.append
    for path in sorted(cache.rglob("*.kept")):
        key = path.read_bytes().partition(b'"key": "')[2][:64].decode("ascii", "replace")
        if store.read(path.parent.name, key, lambda data: data) is None:
            notes.append(f"{path}: key {key}")
    return notes


def renew(killed: Killed) -> None:
    """Have content 1 stand there again, and nothing kept but compiled kernels."""
    forgotten(killed.cache)
    for left in killed.out.parent.iterdir():
        shutil.rmtree(left)
    killed.out.mkdir()
    for name, data in killed.versions[0].items():
        (killed.out / name).write_bytes(data)


def kill_once(killed: Killed, rng: random.Random, sent: int) -> bool:
    """Kill the command at a random moment; return whether the kill hit. All is whole after it."""
    share = 1 - LAST * rng.random() if rng.random() < LATE else rng.random()
    out = killed.out
    before = set(out.parent.iterdir())
    status, hit, _ = ended(started(killed.arguments, out), share * killed.seconds, sent)
    assert content(out) in killed.versions, killed.arguments
    left = [path for path in out.parent.iterdir() if path != out]
    assert all(path.name.startswith(".a.") for path in left), left
    if sent != signal.SIGKILL:
        own = set(left) - before
        code = os.waitstatus_to_exitcode(status)
        assert not own or code == -sent, (code, own)
    assert not refused_work(killed.cache)
    return hit


def end_once(killed: Killed) -> None:
    """Give the command again: it takes what was kept, and clears away what was left."""
    assert finished(killed.arguments, killed.out)[0] in (0, 1)
    assert content(killed.out) == killed.versions[1]
    assert [path.name for path in killed.out.parent.iterdir()] == ["a"]


def attack(
    folder: Path,
    command: str,
    kills: int,
    seed: int,
    seconds: float = 1e9,
    told: Callable[[str], None] = lambda line: None,
) -> tuple[int, int]:
    """Return how many kills were sent and how many hit.

    It ends with the hit number `kills`. `told` gets a line after each: how long the command takes,
    kills and hits so far.
    """
    rng = random.Random(f"kill {command} {seed}")
    with quick(folder / "cache"):
        warm(folder)
        killed = prepare(folder, command)
        renew(killed)
        sent, hits, end = 0, 0, time.monotonic() + seconds
        while hits < kills and time.monotonic() < end:
            hit = kill_once(killed, rng, SIGNALS[sent % len(SIGNALS)])
            sent, hits = sent + 1, hits + hit
            if not hit or rng.random() < ENDS:
                end_once(killed)
                renew(killed)
            told(f"{command}, {killed.seconds:.1f} s: {sent} kills, {hits} before its end")
        end_once(killed)
    return sent, hits
