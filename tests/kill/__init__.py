"""Commands killed at random moments: `python -m tests.kill --help`."""

import sys
from pathlib import Path

# What the tests share is found alike by `pytest` and by `python -m`.
sys.path.append(str(Path(__file__).parents[1]))
