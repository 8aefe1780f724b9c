"""Light that forgets its polarisation at every interface is the plain tracer's."""

from dis import get_instructions
from types import FunctionType

import numpy as np
import pytest
from harness import film_mesh, groove, single_paths
from numba import njit

from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.base.sampling import RNG_SIZE
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.stokes import engine, interface
from mpfcad.optics.stokes.state import LIGHT_SHAPE, depolarise

_MEET = interface._meet_polarised


def _forgetful(cos_in, ratio, nx, ny, nz, dx, dy, dz, light, rng):
    mirrored, cos_out = _MEET(cos_in, ratio, nx, ny, nz, dx, dy, dz, light, rng)
    depolarise(light)
    return mirrored, cos_out


def rebuilt(kernel, swap):
    """Return a kernel compiled anew, with others in the place of some that it calls."""
    if kernel not in swap:
        function = kernel.py_func
        names = dict(function.__globals__)
        for name in {one.argval for one in get_instructions(function) if "GLOBAL" in one.opname}:
            called = names.get(name)
            if hasattr(called, "py_func"):
                names[name] = rebuilt(called, swap)
        copied = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
        swap[kernel] = njit(error_model="numpy", _nrt=False)(copied)
    return swap[kernel]


@pytest.mark.slow
def test_light_that_forgets_is_unpolarised_path_by_path(tmp_path):
    film = Film(film_mesh(tmp_path, [groove(60.0), groove(45.0)]), 1.55, offset=0.013, rotation=0.3)
    cavity = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
    stack = [cavity, Slab(1.49, 2.0, 0.3, 0.0036, 0.8), Sheet(0.3, 1.49, 0.98), film]
    source = Source(EYE, [0.1], 0.05, 0.2, acceptance=0.3)
    count = 20_000
    plain, light = np.empty(count), np.empty((count, 4))
    flow = np.zeros(len(FLOWS) + len(stack))
    single_paths(build_scene(stack), source, 1, 0, plain, flow)
    forget = njit(error_model="numpy", _nrt=False)(_forgetful)
    trace = rebuilt(engine.trace_polarised, {interface._meet_polarised: forget})
    trace(
        build_scene(stack, polarised=True), source, np.uint64(1), np.uint64(EYE), np.uint64(0),
        np.zeros(LIGHT_SHAPE), np.zeros(RNG_SIZE, np.uint64), light, flow,
    )  # fmt: skip
    # Formulas differ in their last bits, and that grows along a path from facet to facet. Of
    # plain paths whose start is moved by 64 last bits 0.1 % change by more than 1e-9, of those that
    # forget 0.06 %; of neither more than 0.01 % go another way.
    same = np.isclose(light[:, 0], plain, rtol=1e-9, atol=1e-6)
    assert np.mean(same) > 0.998
    assert np.isclose(light[:, 0], plain, rtol=1e-6, atol=1e-3).mean() > 0.9995
    difference = light[:, 0] - plain
    assert abs(difference.mean()) <= 4 * difference.std() / np.sqrt(count) + 1e-9
    # Of a single interface a plain meter reads some Q.
    assert np.abs(light[:, 1]).max() > 0
