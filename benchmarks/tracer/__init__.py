"""The tracer beside other renderers: meshes, scenes there, races; `trace.py` beside is the command.

The tests' small films are used here too.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))
