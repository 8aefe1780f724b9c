"""Ctrl-C and kill: exit code 130 (143), and neither an export nor a part of one is left."""

import os
import signal
import subprocess
import sys
import time

import pytest
from command import SMALL_STACK

RUN = (("run", "job.toml", "--effort", "final"), "tracing film.stl")
CAD = (("cad", "job.toml"), "writing film.step")
GOES_ON = ": a trace goes on where it was when the same command is given again"


@pytest.mark.parametrize(
    ("work", "number", "code", "word"),
    [
        (RUN, signal.SIGINT, 130, "interrupted"),
        pytest.param(RUN, signal.SIGTERM, 143, "terminated", marks=pytest.mark.slow),
        (CAD, signal.SIGTERM, 143, "terminated"),
    ],
    ids=["ctrl-c", "kill", "kill of a command without a trace"],
)
def test_interrupted_work_leaves_nothing(tmp_path, work, number, code, word):
    # Files of a narrow panel are soon made; a STEP file's making has to last.
    size = SMALL_STACK if work is RUN else ""
    (tmp_path / "job.toml").write_text(f'name = "a"\n[map]\ncurvature_per_mm = 60.0\n{size}')
    command = "from mpfcad.cli import main; main()"
    arguments, stage = work
    process = subprocess.Popen(
        [sys.executable, "-c", command, *arguments],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "MPFCAD_CACHE": str(tmp_path / "cache")},
    )
    line = ""
    while stage not in line:
        line = process.stderr.readline()
        assert line, "it ended before it was interrupted"
    assert list((tmp_path / "exports").glob(".a*.partial-*"))
    time.sleep(0.5 if work is RUN else 0.0)
    os.kill(process.pid, number)
    rest = process.communicate(timeout=60)[1]
    assert process.returncode == code, rest
    assert "Traceback" not in rest
    # That work goes on is said where some was kept.
    kept = list((tmp_path / "cache").glob("trace/*.kept"))
    assert rest.splitlines()[-1] == f"mpfcad: {word}{GOES_ON if kept else ''}"
    assert list((tmp_path / "exports").iterdir()) == []


def test_a_broken_import_is_no_verdict_of_a_runs_own_file(tmp_path):
    """OCCT's import raises this when Ctrl-C comes in the middle of it."""
    from mpfcad.errors import ExportError
    from mpfcad.pipeline.run.file_check import FileFindings, judged

    for foreign in (False, True):
        found = FileFindings(foreign=foreign)
        with pytest.raises(ImportError), judged(found, "g", tmp_path / "a"):
            raise ImportError("initialization failed")
        assert not found.gates
    own = FileFindings()
    with pytest.raises(ZeroDivisionError), judged(own, "g", tmp_path / "a"):
        raise ZeroDivisionError
    with judged(found, "g", tmp_path / "a"):
        raise ZeroDivisionError
    with judged(found, "g", tmp_path / "a"):
        raise ExportError("a: no outline")
    assert [gate.outcome for gate in found.gates] == ["FAIL", "FAIL"]
