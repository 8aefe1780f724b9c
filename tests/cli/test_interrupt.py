"""Ctrl-C and kill: exit code 130 (143), and neither an export nor a part of one is left."""

import os
import signal
import subprocess
import sys
import time

import pytest


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["ctrl-c", "kill"]
)
def test_interrupted_run_leaves_nothing(tmp_path, number, code):
    (tmp_path / "job.toml").write_text('name = "a"\n[map]\ncurvature_per_mm = 60.0\n')
    command = "from mpfcad.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", command, "run", "job.toml", "--effort", "final"],
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    line = ""
    while "tracing film.stl" not in line:
        line = process.stderr.readline()
        assert line, "the run ended before it traced"
    assert list((tmp_path / "exports").glob(".a.partial-*"))
    time.sleep(0.5)
    os.kill(process.pid, number)
    rest = process.communicate(timeout=60)[1]
    assert process.returncode == code, rest
    assert "Traceback" not in rest
    assert rest.splitlines()[-1].endswith(
        ": a trace goes on where it was when the same command is given again"
    )
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
