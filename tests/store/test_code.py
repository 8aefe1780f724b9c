"""The code's hash moves with every file of the package; the kernels' with every kernel."""

import shutil
from functools import cache
from pathlib import Path

import pytest
from test_layering import INNER, LAYER, imports_of, package_of

import mpfcad
from mpfcad.store import code, versions, work_key
from mpfcad.store.keep import KINDS


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


@pytest.fixture
def keys(monkeypatch):
    """Return what gives the key of one piece of work of each kind, by the code in a folder."""

    def found(folder):
        with monkeypatch.context() as patch:
            patch.setattr(code, "_PACKAGE", folder)
            for name in ("code_hash", "kernel_hash", "work_hash"):
                patch.setattr(code, name, cache(getattr(code, name).__wrapped__))
            patch.setattr("mpfcad.store.digest.work_hash", code.work_hash)
            return {kind: work_key(kind, ["scene"]) for kind in KINDS}

    return found


@pytest.mark.parametrize(
    ("file", "moved"),
    [
        ("report/template/report/film.html.j2", set()),
        ("report/drawing/plot.py", set()),
        ("cli/make/run.py", set()),
        ("api/job.py", set()),
        ("pipeline/point/trace.py", {"figure", "point", "design"}),
        ("mask/rule.py", {"figure", "point", "design"}),
        ("measure/contrast/fit.py", {"trace", "fit", "figure", "point", "design"}),
        ("backlight/preset/thesis-32in.toml", {"trace", "fit", "figure", "point", "design"}),
        ("film/groove.py", {"trace", "fit", "figure", "point", "design"}),
        ("optics/search/grid/walk.py", set(KINDS)),
        ("optics/search/new/part.py", set(KINDS)),
        ("units.py", set(KINDS)),
    ],
)
def test_kept_work_depends_on_what_lies_below_it(package, keys, file, moved):
    path, before = package / file, {kind: work_key(kind, ["scene"]) for kind in KINDS}
    text = path.read_bytes() if path.exists() else None
    try:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes((text or b"") + b"\n# edited\n")
        after = keys(package)
    finally:
        path.unlink() if text is None else path.write_bytes(text)
    assert {kind for kind in KINDS if after[kind] != before[kind]} == moved


def test_the_code_of_a_trace_is_all_that_measure_imports():
    """Kept here, so that a new import of `measure` cannot be forgotten there."""
    known, waiting = set(), {"mpfcad.measure"}
    graph = {module: imports_of(module) for module in INNER}
    while waiting:
        name = waiting.pop()
        known.add(package_of(name))
        here = [module for module in INNER if package_of(module) == package_of(name)]
        waiting |= {
            n for m in here for n in graph[m] if n != "mpfcad" and package_of(n) not in known
        }
    stated = {name.removesuffix(".py") for name in code.TRACE}
    assert stated == known


def test_what_shows_results_is_above_all_that_is_kept():
    kept = [name for name in LAYER if name not in (*code.SHOWN, "mpfcad")]
    assert {"report", "cli", "api"} == set(code.SHOWN) and {"pipeline", "measure"} <= set(kept)


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
