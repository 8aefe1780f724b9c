"""Kernels are compiled plainly where numba is not inside as expected, and that is said once."""

import numba
import pytest
from numba import njit

from mpfcad.optics.base import gathered, kernel
from mpfcad.store.notice import listeners


@pytest.fixture
def said():
    found = []
    listeners.append(found.append)
    yield found
    listeners.remove(found.append)


def test_this_numba_is_as_expected():
    assert gathered.trouble() is None
    if "MPFCAD_KERNELS" not in kernel.os.environ:
        assert kernel.FLAVOUR == "gathered"


@pytest.mark.parametrize(
    ("part", "name"),
    [
        (gathered.JITCodeLibrary, "_get_module_for_linking"),
        (gathered.Compiler, "compile_extra"),
        (gathered.CPUContext, "insert_user_function"),
        (gathered.Dispatcher, "get_call_template"),
    ],
)
def test_what_is_missing_inside_is_named_and_kernels_are_plain(part, name, monkeypatch, said):
    for owner in part.__mro__:
        if name in vars(owner):
            monkeypatch.delattr(owner, name)
    assert gathered.trouble() == f"{part.__name__} has no {name}"
    assert kernel._choose() is None
    (line,) = said
    assert f"{part.__name__} has no {name}" in line and "figures are the same" in line
    assert numba.__version__ in line


def test_an_untried_version_is_tried_once(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    tries = []
    monkeypatch.setattr(gathered, "_try", lambda: tries.append(1))
    assert gathered.trouble("0.99.1") is None and gathered.trouble("0.99.1") is None
    assert len(tries) == 1
    monkeypatch.setattr(gathered, "_try", lambda: tries.append(1) or "it ends with a crash")
    assert gathered.trouble("1.0.0") == gathered.trouble("1.0.0") == "it ends with a crash"
    assert len(tries) == 2


def test_the_trial_passes_here_and_says_what_fails(monkeypatch):
    assert gathered._try() is None
    monkeypatch.setattr(gathered, "_PROBE", "import os; os.abort()")
    assert "exit code -6" in gathered._try()
    monkeypatch.setattr(gathered, "_PROBE", "raise TypeError('no such flag')")
    assert "TypeError: no such flag" in gathered._try()


def test_a_plain_kernel_divides_as_ieee_and_gives_the_same_bits(monkeypatch):
    def body(x, y):
        return (x / y) * x - y

    found = []
    for plain in (False, True):
        if plain:
            monkeypatch.setattr(kernel, "_gathered", None)
        inner = kernel.kernel(body)
        outer = njit(error_model="numpy", _nrt=False)(lambda x, y: inner(x, y) + 1.0)  # noqa: B023
        found.append([outer(x, y).hex() for x, y in ((1.1, 0.3), (1.0, 0.0), (-1e300, 1e-300))])
    assert found[0] == found[1]
    assert found[0][1] == "inf"
