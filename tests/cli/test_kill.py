"""Kills at random moments of run, design, sweep and correct: an old export or the new one, whole.

Each command runs in a fork of a warm process, so that a kill costs seconds. Before it there is an
export of other content under the same name.
"""

import json
import os
import random
import shutil
import signal
import sys
import time

import numpy as np
import pytest
from command import SMALL_STACK, content

from mpfcad.export import check_manifest
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting

RUN = 'name = "a"\nseed = {seed}\n[map]\ncurvature_per_mm = 60.0\n' + SMALL_STACK
SWEEP = """name = "a"
seed = {seed}
[axis]
"map.curvature_per_mm" = [50.0, 60.0]
[trace]
half_width = 0.0
paths_million = 0.02
"""
DESIGN = """schema = 1
name = "a"
seed = {seed}
[goal]
contrast_target = 0.000001
[constraint]
curvature_min_per_mm = 55.0
curvature_max_per_mm = 62.0
harmonics = 2
[search]
iterations = 1
paths_million = 0.02
[stack]
thickness_mm = 18.0
[mask]
period_um = 640.0
"""
COMMANDS = {
    "run": (RUN, ["run", "job.toml", "--effort", "quick", "--threads", "1"]),
    "sweep": (SWEEP, ["sweep", "job.toml", "--workers", "1"]),
    "design": (DESIGN, ["design", "job.toml", "--no-verify", "--threads", "1"]),
    "correct": (RUN, ["correct", "export", "--measured", "m.csv", "--threads", "1"]),
}
#: At most this long after the start [s]; a kill is at a random share of what the command takes.
LONGEST = 300.0


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
    """Send a signal after so long; return the status of the process, and whether it was hit."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return status, False
        time.sleep(0.005)
    os.kill(child, number)
    return os.waitpid(child, 0)[1], True


def forgotten(cache):
    """Remove the kept work, but for compiled kernels."""
    for path in cache.iterdir():
        if path.name != "kernel":
            shutil.rmtree(path, ignore_errors=True)


def measured(folder):
    x = np.arange(0.0, 4.0, 0.02)
    rows = np.stack([x, 6000 * (1 + 0.01 * np.cos(2 * np.pi * x / 4))], 1)
    np.savetxt(folder / "m.csv", rows, "%.4f", ",", header="position_mm,luminance", comments="")


def attack(folder, command, kills, seed):
    """Return how many kills hit; assert that each left an old or a new export, whole."""
    text, arguments = COMMANDS[command]
    arguments = [str(folder / a) if a in ("job.toml", "export", "m.csv") else a for a in arguments]
    out, job = folder / "exports" / "a", folder / "job.toml"
    job.write_text(RUN.format(seed=1))
    if command == "correct":
        measured(folder)
        assert not ended(started(["run", str(job), "--effort", "quick"], folder / "export"),
                         LONGEST, signal.SIGKILL)[1]  # fmt: skip
    versions = []
    for number in (1, 2):
        job.write_text(text.format(seed=number))
        place = ["--lamp-at-mm", str(number)] if command == "correct" else []
        chosen = [*arguments, *place]
        start = time.monotonic()
        status, hit = ended(started(chosen, out), LONGEST, signal.SIGKILL)
        took = time.monotonic() - start
        assert not hit and os.waitstatus_to_exitcode(status) in (0, 1), (command, status)
        versions.append(content(out))
        check_manifest(out)
        forgotten(folder / "cache")
    assert versions[0] != versions[1]
    rng, hits = random.Random(seed), 0
    for kill in range(kills):
        sent = signal.SIGKILL if kill % 3 else signal.SIGINT
        # Content 1 stands there, and 2 is on its way, from nothing but compiled kernels.
        forgotten(folder / "cache")
        shutil.rmtree(out)
        out.mkdir()
        for name, data in versions[0].items():
            (out / name).write_bytes(data)
        status, hit = ended(started(chosen, out), rng.random() * took, sent)
        hits += hit
        assert content(out) in versions, (command, kill)
        left = [path for path in out.parent.iterdir() if path != out]
        assert all(path.name.startswith(".a.") for path in left), left
        if sent == signal.SIGINT:
            assert not left or os.waitstatus_to_exitcode(status) == -signal.SIGINT, left
    # What the last kills left is cleared away by the next run.
    ended(started(chosen, out), LONGEST, signal.SIGKILL)
    assert content(out) == versions[1]
    assert [path.name for path in out.parent.iterdir()] == ["a"]
    return hits


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_a_hundred_kills_leave_no_mixed_export(tmp_path, monkeypatch, command):
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(1.0, 20_000))
    hits = attack(tmp_path, command, 100, seed=4)
    print(json.dumps({command: hits}))
    assert hits > 50
