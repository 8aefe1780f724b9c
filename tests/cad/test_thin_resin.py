"""Resin too thin for the CAD files: left out of all of them, and told."""

import re

import numpy as np
import pytest

from mpfcad.cad import write_step, write_stl
from mpfcad.cli import run_app
from mpfcad.film import CellFilm, Imperfection, MadeFilm
from mpfcad.film.field.library import build_library
from mpfcad.film.field.piece import FieldPiece
from mpfcad.film.imperfection import resin_reach
from mpfcad.job import CadTable
from mpfcad.pipeline.kind import kind_of
from mpfcad.units import deg

CURVATURES = [60.0, 79.6, 79.7, 79.9, 79.99, 80.0]


def told(film):
    return kind_of(film, CadTable()).left_out()


def test_what_is_told_is_what_the_step_lacks(make_film, tmp_path):
    film = make_film(CURVATURES)
    write_step(film, tmp_path / "film.step")
    solids = (tmp_path / "film.step").read_text().count("=MANIFOLD_SOLID_BREP(")
    assert solids == 1 + 2  # the prisms, and the resin of the first two grooves
    words = told(film)
    assert "resin narrower than 0.2 µm (thinner than 0.1 µm, C above 79.68 /mm)" in words
    assert words.endswith(": 3 of 6 grooves hold no more")


def test_a_trace_of_thin_resin_is_that_of_none(make_film, tmp_path):
    for name, curvature in (("thin", 79.9), ("bare", 80.0), ("resin", 79.5)):
        write_stl(make_film([curvature] * 4), tmp_path / name, 0.5 * deg, name="film")
    thin, bare, resin = ((tmp_path / name).read_bytes() for name in ("thin", "bare", "resin"))
    assert thin == bare != resin
    assert told(make_film([79.5] * 4)) is None
    assert told(make_film([80.0] * 4)) is None
    assert "4 of 4 grooves" in told(make_film([79.9] * 4))


def test_a_mould_has_no_resin(make_film):
    assert told(make_film([79.9] * 4, "ideal")) is None


@pytest.mark.parametrize(
    "made",
    [Imperfection(), Imperfection(tip_radius=1e-3), Imperfection(contact_angle=20 * deg),
     Imperfection(valley_radius=1e-3)],
)  # fmt: skip
def test_films_as_made_are_asked_for_what_they_draw(make_film, made):
    """A round valley holds resin over a wider surface, and an arc reaches as far with less."""
    film = MadeFilm(make_film(CURVATURES), made)
    sliver = 1e-4
    drawn = resin_reach(film.film, made, sliver)
    reach = resin_reach(film.film, made, 1e-5)
    missing = int(np.sum((reach > 0) & (drawn == 0)))
    assert np.all((drawn == reach) | (reach < sliver))
    words = told(film)
    assert (words is None) == (missing == 0)
    if missing:
        assert f"{missing} of 6 grooves" in words
    if made == Imperfection():
        assert missing == 3


def test_every_kind_tells(make_film):
    groove = make_film(60.0).groove
    along, curvature = np.array([0.0, 0.5, 1.0]), np.array([[60.0, 79.9, 80.0]])
    field = told(FieldPiece(groove, 0.2, "filled", (0.0, 0.0), along, curvature))
    assert field.startswith("meshes, not the STEP, leave out") and "1 of 3 places" in field
    cells = CellFilm(groove, 0.2, "pyramid", "filled", 79.9, (2, 3))
    assert "6 of 6 cells" in told(cells)
    library = build_library(groove, 0.2, 0.05, np.array([[60.0, 79.9], [79.9, 60.0]]), 2)
    assert "2 of 4 places" in told(library)


def test_cells_without_their_thin_resin_pass_their_gates(make_film, tmp_path):
    """STEP and STL failed for the resin that they leave out."""
    kind = kind_of(
        CellFilm(make_film(60.0).groove, 0.2, "pyramid", "filled", 79.9, (2, 3)), CadTable()
    )
    for name in ("film.step", "film.stl"):
        kind.write(tmp_path / name, "film")
        check = kind.check(tmp_path / name)
        assert {gate.outcome for gate in check.gates} == {"PASS"}


def test_cad_says_it(tmp_path, capsys):
    (tmp_path / "small.toml").write_text(
        'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 20.0\npanel_length_mm = 5.0\n'
        "lamp_count = 2\nlamp_pitch_mm = 8.01\n"
    )
    (tmp_path / "job.toml").write_text(
        'name = "thin"\n[map]\ncurvature_per_mm = 79.9\n[stack]\nfile = "small.toml"\n'
        '[film]\nprofile = "filled"\n[cad]\nlength_mm = 0.5\n'
    )
    job, out = str(tmp_path / "job.toml"), str(tmp_path / "out")
    assert run_app(["cad", job, "--out", out]) == 0
    (line,) = [t for t in capsys.readouterr().err.splitlines() if "leave out" in t]
    assert re.search(r"film: solids and meshes leave out .* (\d+) of \1 grooves hold no more", line)
    assert len(line) <= 300
