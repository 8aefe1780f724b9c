"""Other processors and plainly compiled kernels give the bits of this one.

Vectors are cut to what a processor has, never computed otherwise.
"""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from harness import CONCAVE, crossed_mesh, film_mesh, section_mesh, single_paths

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.element import Film, Sheet
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMPS, Source


def digests(folder: Path) -> list[str]:
    """Return the digests of some paths' radiance and flows, one a scene."""
    crossed, extruded = crossed_mesh(folder), film_mesh(folder, [CONCAVE])
    source = Source(EYE, np.array([0.1]), 0.05, 0.2, 0.1, 0.5)
    cases = [
        ([Sheet(0.36, 1.49, 0.98), Film(mesh, 1.5, accelerator=way)], source)
        for mesh, way in (
            (extruded, "chain"), (section_mesh(folder, "undercut"), "section"),
            (crossed, "grid"), (crossed, "bvh"),
        )
    ]  # fmt: skip
    stack = read_stack("thesis-32in-mpf")
    for kind in (EYE, LAMPS):
        cases.append((lower_stack(stack, extruded), Source(kind, np.zeros(1), 0.5)))
    found = []
    for elements, source in cases:
        radiance, flow = np.empty(2048), np.zeros(len(FLOWS) + len(elements))
        scene = build_scene(elements, below=1.0) if len(elements) == 2 else build_scene(elements)
        single_paths(scene, source, 1, 0, radiance, flow)
        assert flow.any()
        found.append(hashlib.sha256(radiance.tobytes() + flow.tobytes()).hexdigest())
    return found


@pytest.mark.slow
@pytest.mark.parametrize("features", ["", "+avx"], ids=["SSE2", "AVX"])
def test_a_processor_without_vectors_of_eight_gives_the_same_bits(tmp_path, features):
    plain = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": features}
    assert elsewhere(tmp_path, plain) == digests(tmp_path)


@pytest.mark.slow
def test_plainly_compiled_kernels_give_the_same_bits(tmp_path):
    assert elsewhere(tmp_path, {"MPFCAD_KERNELS": "plain"}) == digests(tmp_path)


def elsewhere(folder, environment):
    """Return the digests that a process finds whose kernels are compiled otherwise."""
    path = os.pathsep.join([str(Path(__file__).parent), str(Path(__file__).parents[1]), *sys.path])
    command = "import sys, pathlib; from test_processors import digests as d; "
    command += "print(*d(pathlib.Path(sys.argv[1])))"
    child = subprocess.run(
        [sys.executable, "-c", command, str(folder)], capture_output=True, text=True, check=True,
        env={**os.environ, **environment, "PYTHONPATH": path},
    )  # fmt: skip
    return child.stdout.split()
