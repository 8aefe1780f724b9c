"""What is told while kernels are compiled, and that nothing is told when they are loaded."""

import importlib.util
import io

import numpy as np
import pytest

from mpfcad import compiling
from mpfcad.cli.terminal import Terminal
from mpfcad.optics import engine

_SOURCE = """
from numba import njit
from mpfcad.optics.base.kernel import kernel


@kernel
def inner(x):
    return 2.0 * x


@njit(cache=True, error_model="numpy", _nrt=False)
def outer(x):
    return inner(x) + 1.0
"""


def _module(path):
    spec = importlib.util.spec_from_file_location("few_kernels", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_kernel_by_itself_is_an_error_in_python(tmp_path):
    path = tmp_path / "few_kernels.py"
    path.write_text(_SOURCE)
    with pytest.raises(KeyError):
        _module(path).inner(3.0)


def test_a_line_says_that_the_tracer_is_compiled(capsys):
    with Terminal():
        compiling.tell("trace_paths")
        compiling.tell(None)
        compiling.tell("quickly_compiled")
        compiling.tell(None)
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "compiling the tracer for this processor, once: about" in lines[0]
    compiling.tell("trace_paths")
    assert capsys.readouterr().err == ""


def test_in_a_terminal_the_bar_says_it(monkeypatch):
    screen = io.StringIO()
    monkeypatch.setattr(screen, "isatty", lambda: True)
    monkeypatch.setattr("sys.stderr", screen)
    with Terminal() as terminal:
        terminal.stage("tracing film.stl")
        compiling.tell("trace_paths")
        assert "compiling the tracer" in terminal._bar.tasks[0].description
        compiling.tell(None)
        assert terminal._bar.tasks[0].description == "tracing film.stl"


def test_one_compiled_tracer_is_for_all_scenes():
    from mpfcad.optics.element import Cavity, Sheet
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.source import LAMPS, Source

    engine.compile_tracer()
    before = len(engine.trace_paths.signatures)
    cavity = Cavity(20.0, 30.0, 0.0, 5.0, 1.7, 1.0, 0.9, 0.9, 0.0)
    scene = build_scene([cavity, Sheet(0.1, 1.5, 1.0)])
    engine.trace(scene, Source(LAMPS, np.linspace(0, 1, 3), 1.0), 1)
    assert len(engine.trace_paths.signatures) == before == 1
