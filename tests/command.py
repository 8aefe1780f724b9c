"""What the tests of the command line share: a run in a process of its own or here, and its end."""

import contextlib
import io
import subprocess
import sys

from mpfcad.cli import run_app

#: The smallest panel: one lamp, 80 grooves.
SMALL_STACK = """[stack.override]
lamp_count = 1
lamp_pitch_mm = 4.0
lamp_radius_mm = 0.2
lamp_height_mm = 0.5
panel_width_mm = 4.0
panel_length_mm = 2.0
"""


def mpfcad(*arguments, cwd=None, timeout=600):
    """Run the command line in its own process: for what only a process has, as it is slow."""
    code = "from mpfcad.cli import main; main()"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=timeout)


def called(*arguments, cwd=None):
    """Run the command line in this process, where no process of its own is looked at."""
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.chdir(cwd or "."),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        code = run_app([*map(str, arguments)])
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), err.getvalue())


def content(folder):
    """Return the bytes of each file by its name."""
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def refused(result, *words):
    """Assert that a run ended with code 2 and one line that holds all these words."""
    assert result.returncode == 2, result.stderr
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("mpfcad: ")]
    for word in words:
        assert word in line
