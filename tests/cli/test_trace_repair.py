"""`mpfcad trace --repair`: only when asked, into a file of its own, and both hashes in the JSON."""

import hashlib
import json

import numpy as np
import pytest
from harness import BARE, CONCAVE, extruded, row, write_facets
from solid import drawn

from mpfcad.cli import run_app
from mpfcad.optics.solid.mesh import read_film_mesh

FILM = extruded(*row([CONCAVE] * 2, 0.2), 0.4)
BROKEN = np.r_[FILM[:5, ::-1], FILM[5:-4]]


def run(capsys, *arguments):
    code = run_app(["trace", *map(str, arguments), "--effort", "quick", "--threads", "1"])
    out, err = capsys.readouterr()
    return code, out, err


@pytest.fixture
def short(monkeypatch):
    from mpfcad.pipeline.effort import TraceSetting
    from mpfcad.pipeline.measure import trace as module

    setting = {"quick": TraceSetting(half_width_goal=1.0, path_limit=1)}
    monkeypatch.setattr(module, "TRACE_SETTINGS", setting)


def test_a_mesh_is_repaired_only_when_asked(tmp_path, capsys, short):
    path = write_facets(tmp_path / "film.stl", BROKEN)
    before = path.read_bytes()
    code, out, err = run(capsys, path)
    assert code == 2 and out == "" and len(err.splitlines()) == 1 and " mm: " in err
    assert [p.name for p in tmp_path.iterdir()] == ["film.stl"]
    code, out, err = run(capsys, path, "--repair", "--json")
    assert code == 0 and "repaired into film-repaired.stl: turned facets 5, filled holes 2" in err
    assert path.read_bytes() == before
    fixed = tmp_path / "film-repaired.stl"
    traced = json.loads(out)["traced"]
    assert traced["sha256"] == hashlib.sha256(fixed.read_bytes()).hexdigest()
    assert traced["repaired_from"]["sha256"] == hashlib.sha256(before).hexdigest()
    assert traced["repaired_from"]["turned_facets"] == 5
    mesh, sound = read_film_mesh(fixed), write_facets(tmp_path / "sound.stl", FILM)
    assert mesh.size == read_film_mesh(sound).size
    # Again: the same file is there already; a sound one is traced as it is.
    assert run(capsys, path, "--repair", "--json")[1] == out
    code, again, err = run(capsys, sound, "--repair", "--json")
    assert code == 0 and "nothing to repair" in err
    assert json.loads(again)["traced"]["file"] == "sound.stl"
    assert len(list(tmp_path.iterdir())) == 3


def test_what_cannot_be_repaired_is_refused_and_nothing_written(tmp_path, capsys):
    x, z = row([BARE] * 2, 0.0)
    outline = [(0, 0), (0.1, 0), *zip(x[::-1], z[::-1], strict=True)]
    path = write_facets(tmp_path / "film.stl", drawn(outline, fan=True))
    code, out, err = run(capsys, path, "--repair")
    assert code == 2 and out == "" and len(err.splitlines()) == 1
    assert "cannot be repaired: touches itself at (0.0" in err
    assert [p.name for p in tmp_path.iterdir()] == ["film.stl"]


def test_another_file_is_never_overwritten(tmp_path, capsys):
    path = write_facets(tmp_path / "film.stl", BROKEN)
    (tmp_path / "film-repaired.stl").write_text("mine")
    code, _, err = run(capsys, path, "--repair")
    assert code == 2 and "film-repaired.stl: exists and is another mesh" in err
    assert (tmp_path / "film-repaired.stl").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 2
