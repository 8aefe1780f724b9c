"""Compiled kernels come from the store, and never those of another text."""

import importlib.util
import re
from pathlib import Path

import numba
import pytest

import mpfcad
from mpfcad import compiling
from mpfcad.store import kernel
from mpfcad.store.notice import listeners

_SOURCE = """
from mpfcad.optics.base.kernel import entry, kernel


@kernel
def inner(x):
    return {factor} * x


@entry
def outer(x):
    return inner(x) + 1.0
"""


@pytest.fixture
def told():
    """Return what is compiled, and what is said of the store, during the test."""
    compiled, said = [], []
    compiling.watchers.append(compiled.append)
    listeners.append(said.append)
    yield compiled, said
    compiling.watchers.remove(compiled.append)
    listeners.remove(said.append)


@pytest.fixture
def load(tmp_path, monkeypatch):
    """Return a way to write and import a module whose kernel multiplies by a factor."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))

    def module(factor, text="same"):
        path = tmp_path / "few_kernels.py"
        path.write_text(_SOURCE.format(factor=factor))
        monkeypatch.setattr(kernel, "kernel_hash", lambda: text)
        spec = importlib.util.spec_from_file_location("few_kernels", path)
        made = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(made)
        return made

    return module


def entries(folder):
    return sorted((folder / "kept" / "kernel").iterdir())


def test_a_kernel_is_compiled_once(tmp_path, load, told):
    assert load(2.0).outer(3.0) == 7.0
    assert load(2.0).outer(3.0) == 7.0
    assert told == (["outer", None], [])
    assert len(entries(tmp_path)) == 1


def test_an_edit_below_the_entry_compiles_it_anew(load, told):
    assert load(2.0).outer(3.0) == 7.0
    assert load(5.0, "edited").outer(3.0) == 16.0
    assert told[0] == ["outer", None] * 2


def test_no_kernel_is_left_to_numbas_own_cache():
    """That looks at the function's own file alone: after an edit below the old code would run."""
    files = Path(mpfcad.__file__).parent.rglob("*.py")
    own = [path.name for path in files if re.search(r"jit\([^)]*cache=", path.read_text("utf-8"))]
    assert own == []


def test_a_damaged_kernel_is_compiled_anew(tmp_path, load, told):
    assert load(2.0).outer(3.0) == 7.0
    (path,) = entries(tmp_path)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 4
    path.write_bytes(content)
    assert load(2.0).outer(3.0) == 7.0
    compiled, said = told
    assert compiled == ["outer", None] * 2
    assert len(said) == 1 and "computed again" in said[0]
    assert [p.suffix for p in entries(tmp_path)] == [".damaged", ".kept"]


def test_without_a_place_for_kernels_they_are_compiled_and_that_is_said(tmp_path, load, told):
    (tmp_path / "kept").write_text("in the way")
    assert load(2.0).outer(3.0) == 7.0
    assert any("not kept" in line for line in told[1])


def test_where_numba_is_otherwise_inside_its_own_cache_is_named_for_the_text(
    tmp_path, load, told, monkeypatch
):
    monkeypatch.setattr(kernel, "is_numba_as_expected", lambda: False)
    assert load(2.0).outer(3.0) == 7.0
    assert load(2.0).outer(3.0) == 7.0
    assert load(2.0, "edited").outer(3.0) == 7.0
    assert told[0] == ["outer", None] * 2
    assert str(tmp_path / "kept") == numba.config.CACHE_DIR
    folders = sorted(path.name for path in (tmp_path / "kept" / "numba").iterdir())
    assert folders == ["editedgathered", "samegathered"]
