"""Kinds of film are told apart by `pipeline/kind` alone; the library of pieces is one of them."""

import ast
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

import mpfcad
from mpfcad.errors import ExportError, InputError
from mpfcad.film import Groove, build_library
from mpfcad.job import CadTable
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.kind.registry import KINDS
from mpfcad.report.page.environment import render
from mpfcad.report.page.led_page import ShownFilm, write_led_page

ROOT = Path(mpfcad.__file__).parent
#: Films over the panel are films too, those that the tracer knows, and the masks made of them.
FILMS = {
    *(kind.__name__ for kind in KINDS), "FieldFilm", "CurvatureField", "Film", "LibraryFilm",
    *("GrooveMask", "DitherMask", "LevelMask", "GrooveMap", "FieldMap", "CellFilmMap"),
}  # fmt: skip
ASKING = sorted(
    path
    for package in ("mask", "pipeline", "report", "measure")
    for path in (ROOT / package).rglob("*.py")
    if ROOT / "pipeline" / "kind" not in path.parents
)


def kinds_asked(source: str) -> list[str]:
    """Return the classes of film that a source asks for: isinstance, type(x) is, match."""
    found = []
    for node in ast.walk(ast.parse(source)):
        asked: list[ast.AST] = []
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in (
            "isinstance", "issubclass",
        ):  # fmt: skip
            asked = node.args[1:]
        elif isinstance(node, ast.Compare) and "type(" in ast.unparse(node):
            asked = [node]
        elif isinstance(node, ast.MatchClass):
            asked = [node.cls]
        for part in asked:
            for name in ast.walk(part):
                word = getattr(name, "attr", None) or getattr(name, "id", None)
                if word in FILMS:
                    found.append(word)
    return found


@pytest.mark.parametrize(
    "source",
    [
        "isinstance(film, CellFilm)",
        "isinstance(film, PrismFilm | MadeFilm)",
        "isinstance(film, (int, film.FieldPiece))",
        "type(film) is PieceLibrary",
        "match film:\n    case FieldFilm():\n        pass",
    ],
)
def test_a_film_that_is_asked_for_its_kind_is_seen(source):
    assert kinds_asked(source)
    assert not kinds_asked("film.varies_along and isinstance(film.curvature, float)")


def test_no_film_is_asked_for_its_kind():
    found = {str(path.relative_to(ROOT)): kinds_asked(path.read_text("utf-8")) for path in ASKING}
    asked = {path: names for path, names in found.items() if names}
    assert len(found) > 100
    assert not asked, f"{asked}: expected a method of `pipeline.kind.Kind`"


def test_every_kind_has_words_a_view_and_its_own_template():
    for kind in KINDS.values():
        assert kind.view_words and kind.section_title and kind.no_mask and kind.formats
        assert {"extent", "view", "film_section", "as_grooves"} <= set(dir(kind))
    assert len({kind.__name__ for kind in KINDS.values()}) == len(KINDS)


@pytest.fixture(scope="module")
def pieces():
    """Return a library of 5 different pieces at 6 × 4 places, and its kind."""
    wanted = 60 + 12 * np.cos(np.linspace(0, 5, 6))[:, None] * np.cos(np.linspace(0, 3, 4))
    library = build_library(Groove(0.05, 0.025), 0.15, 0.1, wanted, 5)
    return library, kind_of(library, CadTable())


def rewritten(source, target, change):
    """Copy a 3MF with its model's text changed."""
    with zipfile.ZipFile(source) as read, zipfile.ZipFile(target, "w") as write:
        for name in read.namelist():
            content = read.read(name)
            if name.endswith(".model"):
                content = change(content.decode()).encode()
            write.writestr(name, content)
    return target


def test_a_library_is_written_checked_and_shown(pieces, tmp_path):
    library, kind = pieces
    path = tmp_path / "film.3mf"
    kind.write(path, "film")
    check = kind.check(path)
    used = np.unique(library.chosen)
    assert list(check.volume) == [f"C {c:.6f} /mm" for c in library.curvature[used]]
    for number, volume in zip(used, check.volume.values(), strict=True):
        assert volume == pytest.approx(library.piece(int(number)).volume, rel=1e-4)
    assert kind.extent == "0.3 × 0.4 × 0.175 mm, 5 pieces at 6 × 4 places"
    # Three grooves in the middle, one piece of 0.1 mm long: x from 0 to 0.15 mm.
    (body,) = kind.view(path).data
    assert (min(body.x), max(body.x)) == (0.0, 150.0) and max(body.y) == pytest.approx(100.0)
    shown = kind.film_section(library.piece(0), np.empty(0), None, None)
    page = render(shown["template"], film=shown, record={"process": None})
    assert "5 different ones" in page and "6 × 4 places" in page
    assert "lower left corner is x = y = 0, where a lattice has an LED" in shown["caption"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text.replace('<item objectid="1"', '<item objectid="2"', 1), "is piece"),
        (lambda text: re.sub(r"<item [^>]*/>", "", text, count=1), "23 instances: expected"),
        (lambda text: text.replace(" 0.05 0 0", " 0.051 0 0", 1), "place of an instance"),
        (lambda text: re.sub(r"<triangle [^>]*/>", "", text, count=1), "not closed"),
    ],
)  # fmt: skip
def test_a_library_that_is_not_what_was_wanted_is_refused(pieces, tmp_path, change, words):
    _, kind = pieces
    kind.write(tmp_path / "film.3mf", "film")
    changed = rewritten(tmp_path / "film.3mf", tmp_path / "changed.3mf", change)
    with pytest.raises(ExportError, match=words):
        kind.check(changed)


def test_pieces_of_another_curvature_are_refused(pieces, tmp_path):
    library, kind = pieces
    other = build_library(
        library.groove, library.base, library.length, library.curvature[library.chosen] + 0.02, 5
    )
    kind_of(other, CadTable()).write(tmp_path / "film.3mf", "film")
    with pytest.raises(ExportError, match="height error"):
        kind.check(tmp_path / "film.3mf")


def test_a_window_of_a_library_is_written_whole_and_piece_by_piece(pieces, tmp_path):
    _, kind = pieces
    for name in ("step", "stl", "csv"):
        path = tmp_path / f"film.{name}"
        kind.write(path, "film")
        check = kind.check(path)
        assert check is None or {gate.outcome for gate in check.gates} <= {"PASS"}
    check = kind.check_step(tmp_path / "film.step")
    # Each piece once more, beside the window.
    count = kind.window.chosen.size + len(np.unique(kind.window.chosen))
    assert sum(check.solid_count.values()) == count
    with pytest.raises(InputError, match="piece by piece"):
        kind.check_mesh(tmp_path / "film.stl")


def test_the_page_of_a_design_for_leds_shows_each_of_its_films(pieces, tmp_path):
    library, kind = pieces
    names = ("film.3mf", "film-crossed.3mf")
    films = [ShownFilm(kind, tmp_path / name, library.piece(0)) for name in names]
    for film in films:
        kind.write(film.file, "film")

    def found(value):
        return {"value": value, "standard_error": 0.1 * value, "ci95": [0.8 * value, 1.2 * value]}

    side = {"across_mm": 0.3, "along_mm": 0.4}
    record = {
        "name": "two <films>",
        "screen": "phototool only",
        "optical_distance_mm": 1.736,
        "height_over_pitch": 0.434,
        "found": {
            "cell": {**side, "luminance_cd_m2": [[1.0, 2.0], [2.0, 1.0]]},
            "lamp_mura_contrast": found(0.056),
            "mean_luminance_cd_m2": found(58313.0),
            "sigma_over_mean": found(0.019),
            "paths": 5_000_000,
        },
        "design": {"goal": {"contrast_target": 0.074}},
        "model_least": {"lamp_mura_contrast": 0.0123},
        "mould": {"lamp_mura_contrast": 0.0098},
        "printing": {"words": "no mesh prints it"},
        "range": None,
        "pilot": None,
        "bears": [
            {
                "departure": {"crossed_shift_x_mm": 0.16},
                "lamp_mura_contrast": found(0.06),
                "mean_luminance_cd_m2": found(58000.0),
                "outcome": "PASS",
            }
        ],
        "tried": [
            {
                "series_per_mm": [[68.0, 1.5], [-2.5, 0.25]],
                "lamp_mura_contrast": found(0.12),
                "paths": 300_000,
            }
        ],
    }
    write_led_page(tmp_path / "one.html", record, films)
    write_led_page(tmp_path / "two.html", record, films)
    page = (tmp_path / "one.html").read_text("utf-8")
    assert (tmp_path / "two.html").read_text("utf-8") == page
    words = (
        "two &lt;films&gt;",
        "0.0560 [0.0448, 0.0672]",
        "1.736",
        "0.434",
        "68",
        "2.5",
        "0.30",
        "0.0123",
    )
    assert all(word in page for word in (*words, *names, kind.extent))
    borne = ("film across: shift x 0.16 mm", "0.0600 [0.0480, 0.0720]", "target 0.074", "PASS")
    assert all(word in page for word in borne)
    write_led_page(tmp_path / "none.html", {**record, "bears": []}, films)
    assert "What it bears" not in (tmp_path / "none.html").read_text("utf-8")
    for name in ("light", "film-1", "view-1", "film-2", "view-2"):
        assert page.count(f'id="plot-{name}"') == 1
