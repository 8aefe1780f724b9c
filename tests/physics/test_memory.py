"""Memory: the whole panel's mesh in its finite stack, at any number of paths."""

import json
import subprocess
import sys

import pytest

#: Traces a panel of 7,846 grooves, 12 lamps and side walls; prints the peak after each in MiB.
TRACE = """
import json, resource, sys
from pathlib import Path
import numpy as np
from mpfcad.backlight import read_stack
from mpfcad.measure import light_film
from mpfcad.optics.engine import BLOCK, trace
from mpfcad.optics.source import EYE, Source

stack = read_stack("thesis-32in-mpf", overrides={"extent": "panel"})
lit = light_film(stack, Path(sys.argv[1]))
source = Source(EYE, np.linspace(0, 1, 33) * stack.period.across, 1.0)
peaks = []
for paths in (1e5, 1e6, 1e7):
    tally = trace(lit.scene, source, round(paths / (33 * BLOCK)), seed=61, threads=2)
    peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
assert tally.total_paths > 0.99e7 and tally.radiance.min() > 1000
print(json.dumps([stack["lamp_count"], lit.accelerator, *peaks]))
"""
WRITE = """
import sys
import numpy as np
from mpfcad.cad import write_stl
from mpfcad.film import Groove, PrismFilm
from mpfcad.units import deg

curvature = np.full(7846, 60.0)
film = PrismFilm(Groove(0.05, 0.025), 0.2, 697.68, "filled", curvature)
write_stl(film, sys.argv[1], 0.5 * deg)
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_paths_and_stays_below_a_gibibyte(tmp_path):
    path = tmp_path / "panel.stl"
    # Each in its own process: a peak is that of the process.
    subprocess.run([sys.executable, "-c", WRITE, path], check=True)
    assert path.stat().st_size > 100e6
    done = subprocess.run(
        [sys.executable, "-c", TRACE, path], check=True, capture_output=True, text=True
    )
    lamps, accelerator, few, more, most = json.loads(done.stdout)
    print(f"peak {few:.0f}, {more:.0f}, {most:.0f} MiB at 1e5, 1e6, 1e7 paths")
    assert (lamps, accelerator) == (12, "chain")
    assert most <= 1024
    # 2 MiB: what the allocator may round up; 1e7 paths' radiances alone would be 76 MiB.
    assert most - few <= 2
