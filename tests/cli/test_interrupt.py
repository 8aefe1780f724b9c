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
