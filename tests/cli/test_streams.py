"""Closed, full and narrow streams, names that are no UTF-8, two interruptions, two runs at once."""

import os
import signal
import subprocess
import sys
import time

import pytest
from command import SMALL_STACK, called, content, mpfcad

from mpfcad.cli.stream import one_line
from mpfcad.export import check_manifest

CODE = "from mpfcad.cli import main; main()"
COMMAND = [sys.executable, "-c", CODE]
WHOLE = 'name = "a"\n[map]\ncurvature_per_mm = 60.0\n'
JOB = WHOLE + SMALL_STACK


def shell(line, cwd, **environment):
    """Run a line of bash, where `mpfcad` is the command, with bash's own pipe status."""
    script = f'mpfcad() {{ "{sys.executable}" -c "{CODE}" "$@"; }}\n{line}'
    return subprocess.run(
        ["bash", "-c", script], cwd=cwd, capture_output=True, text=True, timeout=300,
        env={**os.environ, **environment}, errors="backslashreplace",
    )  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "job.toml").write_text(JOB)
    return tmp_path


def test_a_reader_that_goes_away_changes_neither_code_nor_errors(folder):
    result = shell("mpfcad stacks | head -1; echo ${PIPESTATUS[0]}", folder)
    assert result.stdout.splitlines()[-1] == "0" and result.stderr == ""
    result = shell("mpfcad --help | true; echo ${PIPESTATUS[0]}", folder)
    assert result.stdout.splitlines()[-1] == "0" and result.stderr == ""
    # A wrong job ends with 2 although nobody reads its error.
    result = shell("mpfcad mask no.toml 2>&1 | true; echo ${PIPESTATUS[0]}", folder)
    assert result.stdout.splitlines()[-1] == "2"


@pytest.mark.parametrize("closed", [pytest.param("2>&-", marks=pytest.mark.slow), "<&- >&- 2>&-"])
def test_streams_that_are_closed_from_the_start(folder, closed):
    result = shell(f"mpfcad mask job.toml --format oas {closed}; echo $?", folder)
    assert result.stdout.splitlines()[-1] == "0"
    whole = content(folder / "exports" / "a-mask")
    assert called("mask", "job.toml", "--format", "oas", "--out", "b", cwd=folder).returncode == 0
    assert content(folder / "b") == whole
    result = shell(f"mpfcad mask no.toml {closed}; echo $?", folder)
    assert result.stdout.splitlines()[-1] == "2"


def test_a_full_disk_under_the_output_is_said(folder):
    result = shell("mpfcad stacks > /dev/full", folder)
    assert result.returncode == 3
    assert result.stderr == (
        "mpfcad: standard output: No space left on device: what was to be printed is lost\n"
    )


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "utf-8"])
def test_signs_that_the_encoding_lacks_are_escaped(folder, encoding):
    result = shell("mpfcad stacks; mpfcad mask 'no-≥-µ.toml'", folder, PYTHONIOENCODING=encoding)
    assert "Traceback" not in result.stderr and "mpfcad: no-" in result.stderr
    assert result.returncode == 2


def test_a_bare_locale(folder):
    result = shell("mpfcad mask job.toml --format oas", folder, LANG="C", LC_ALL="C")
    assert result.returncode == 0, result.stderr
    result = shell("PYTHONUTF8=0 PYTHONCOERCECLOCALE=0 mpfcad stacks", folder, LC_ALL="C")
    assert result.returncode == 0 and "Traceback" not in result.stderr


def test_a_name_that_is_no_utf8(folder):
    name = os.fsdecode(b"job-\xff\xb5m.toml")
    (folder / name).write_text(JOB)
    result = mpfcad("mask", name, "--format", "oas", cwd=folder)
    assert result.returncode == 0, result.stderr
    (folder / name).write_text("oops = 1\n" + JOB)
    result = mpfcad("mask", name, cwd=folder)
    assert result.returncode == 2 and "oops" in result.stderr and "Traceback" not in result.stderr


def test_two_interruptions_are_as_one(folder):
    # Of a panel whose files take a while, so that no trace has begun.
    (folder / "job.toml").write_text(WHOLE)
    process = subprocess.Popen(
        [*COMMAND, "run", "job.toml", "--effort", "final"], cwd=folder, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    line = ""
    while "film.stl" not in line:
        line = process.stderr.readline()
        assert line, "the run ended before it wrote film.stl"
    for _ in range(3):
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
    rest = process.communicate(timeout=120)[1]
    assert process.returncode == 130, rest
    assert "Traceback" not in rest and "Exception ignored" not in rest
    assert [line for line in rest.splitlines() if line.startswith("mpfcad: ")] == [
        "mpfcad: interrupted"
    ]
    assert list((folder / "exports").iterdir()) == []


def test_two_runs_at_once_leave_one_whole_export(folder):
    # Of a panel that takes each of them a while to write.
    text = JOB.replace("panel_width_mm = 4.0", "panel_width_mm = 100.0")
    (folder / "job.toml").write_text(text)
    command = [*COMMAND, "mask", "job.toml", "--format", "oas"]
    both = [subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE) for _ in range(2)]
    assert [process.wait(timeout=120) for process in both] == [0, 0]
    for process in both:
        process.stderr.close()
    assert [path.name for path in (folder / "exports").iterdir()] == ["a-mask"]
    check_manifest(folder / "exports" / "a-mask")


@pytest.mark.parametrize(
    "text", ["a\x1b[31mb", "a\nb\tc\r", "\x00\x07\x7f\x80", "\u202eab", "x" * 5000]
)
def test_a_line_has_no_control_character_and_an_end(text):
    line = one_line(f"job.toml: map.file: {text}: expected a file")
    assert line.isprintable() and len(line) <= 292
    assert line.startswith("job.toml: map.file: ") and line.endswith("expected a file")
