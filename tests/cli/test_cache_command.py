"""`mpfcad cache` shows and prunes what is kept, and nothing else."""

import pytest

from mpfcad.cli import run_app
from mpfcad.store import Store


@pytest.fixture
def store(tmp_path, monkeypatch):
    for name in ("MPFCAD_CACHE", "NUMBA_CACHE_DIR"):
        monkeypatch.setenv(name, str(tmp_path))
    store = Store(tmp_path)
    store.keep_json("point", "ab" * 32, [1.0])
    store.write("kernel", "cd" * 32, bytes(3_000_000))
    return store


def test_it_shows_what_is_kept(store, capsys):
    assert run_app(["cache"]) == 0
    total, points, kernels = capsys.readouterr().out.splitlines()
    assert total == f"{store.folder}: 2 files, 3.00 MB"
    assert points.split()[:4] == ["points", "of", "sweeps", "1"]
    assert "compiled kernels" in kernels and "3.00 MB last used 0.0 to 0.0 days ago" in kernels


def test_it_removes_what_this_version_cannot_use(store, capsys):
    path = store.path("point", "ab" * 32)
    path.write_bytes(path.read_bytes().replace(b'"code": "', b'"code": "0'))
    assert run_app(["cache"]) == 0
    assert "points of sweeps (of another version)" in capsys.readouterr().out
    assert run_app(["cache", "--prune"]) == 0
    assert "removed 1 files, 0.00 MB" in capsys.readouterr().out
    assert not path.exists() and store.path("kernel", "cd" * 32).exists()
    assert run_app(["cache", "--prune", "--all"]) == 0
    assert "removed 1 files, 3.00 MB" in capsys.readouterr().out


def test_an_empty_or_missing_folder_is_no_trouble(tmp_path, monkeypatch, capsys):
    for name in ("MPFCAD_CACHE", "NUMBA_CACHE_DIR"):
        monkeypatch.setenv(name, str(tmp_path / "none"))
    assert run_app(["cache", "--prune"]) == 0
    assert "0 files" in capsys.readouterr().out
    assert not (tmp_path / "none").exists()


def test_options_without_prune_are_refused(capsys):
    assert run_app(["cache", "--all"]) == 2
    assert "expected together with --prune" in capsys.readouterr().err
