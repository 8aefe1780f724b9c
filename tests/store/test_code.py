"""The code's hash moves with every file of the package; the kernels' with every kernel."""

import shutil
from pathlib import Path

import pytest

import mpfcad
from mpfcad.store import code, versions


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    copy = tmp_path_factory.mktemp("copy") / "mpfcad"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(Path(mpfcad.__file__).parent, copy, ignore=ignored)
    return copy


@pytest.fixture
def hashes(package, monkeypatch):
    monkeypatch.setattr(code, "_PACKAGE", package)
    return lambda: (code.code_hash.__wrapped__(), code.kernel_hash.__wrapped__())


@pytest.mark.parametrize(
    ("file", "of_kernels"),
    [
        ("optics/base/fresnel.py", True),
        ("optics/search/chain_walk.py", True),
        ("optics/sheet.py", True),
        ("design/passage.py", True),
        ("mask/pattern/dither.py", True),
        ("units.py", True),
        ("film/groove.py", False),
        ("backlight/lower.py", False),
        ("backlight/preset/thesis-32in.toml", False),
        ("measure/contrast/fit.py", False),
        ("pipeline/point/trace.py", False),
        ("report/film/page.py", False),
    ],
)
def test_an_edit_of_any_file_moves_the_hash(package, hashes, file, of_kernels):
    path, before = package / file, hashes()
    text = path.read_bytes()
    try:
        path.write_bytes(text + b"\n# edited\n")
        after = hashes()
    finally:
        path.write_bytes(text)
    assert after[0] != before[0]
    assert (after[1] != before[1]) == of_kernels
    assert hashes() == before


def test_compiled_leftovers_do_not_count(package, hashes):
    before = hashes()
    cache = package / "optics" / "__pycache__"
    cache.mkdir()
    (cache / "engine.cpython-311.pyc").write_bytes(b"x")
    assert hashes() == before


def test_a_copy_elsewhere_has_the_same_hash(package, hashes):
    assert hashes() == (mpfcad.store.code_hash(), mpfcad.store.kernel_hash())


def test_versions_name_what_figures_come_from():
    found = versions()
    assert found["mpfcad"] == mpfcad.__version__
    assert {"python", "numpy", "numba"} <= set(found)
    assert "not installed" not in found.values()
