"""What the tests of the command line share: a run in a process of its own, what comes of it."""

import subprocess
import sys

#: The smallest panel: one lamp, 80 grooves.
SMALL_STACK = """[stack.override]
lamp_count = 1
lamp_pitch_mm = 4.0
lamp_radius_mm = 0.2
lamp_height_mm = 0.5
panel_width_mm = 4.0
panel_length_mm = 2.0
"""


def mpfcad(*arguments, cwd, timeout=600):
    """Run the command line in its own process."""
    code = "from mpfcad.cli import main; main()"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, timeout=timeout)


def content(folder):
    """Return the bytes of each file by its name."""
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def refused(result, *words):
    """Assert that a run ended with code 2 and one line that holds all these words."""
    assert result.returncode == 2, result.stderr
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("mpfcad: ")]
    for word in words:
        assert word in line
