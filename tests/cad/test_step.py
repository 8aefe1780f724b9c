"""STEP files: written, read back, and refused when they are another film's."""

import re
import subprocess
import sys

import numpy as np
import pytest

from mpfcad.cad import check_step, write_step
from mpfcad.cad.step.grooves import COLOURS
from mpfcad.errors import ExportError, InputError
from mpfcad.film import Groove, PrismFilm
from mpfcad.gate import demand


@pytest.mark.parametrize(
    ("curvature", "profile"),
    [(c, "filled") for c in (0, 1e-4, 15, 40, 40.0001, 45, 57, 60, 79.96, 79.99, 80)]
    + [(c, "ideal") for c in (0, 40.0001, 60, 79.99, 81, 100)],
)
def test_written_films_read_back(make_film, tmp_path, curvature, profile):
    film = make_film(curvature, profile)
    path = tmp_path / "film.step"
    write_step(film, path)
    check = check_step(path, film)
    assert check.valid
    assert check.unit == "mm"
    assert check.volume_error < 1e-7
    assert check.bodies["BEF"] == pytest.approx(film.prism_volume, rel=1e-7)
    assert sum(check.bodies.values()) == pytest.approx(film.volume, rel=1e-7)
    assert set(check.bodies) == ({"BEF", "fill"} if curvature < 79.68 else {"BEF"})
    np.testing.assert_allclose(check.low, 0, atol=1e-9)
    np.testing.assert_allclose(check.high, [film.width, film.length, film.thickness], atol=1e-9)


def test_blocks_pieces_and_mixed_grooves(make_film, tmp_path):
    """More grooves than one cap face takes, with empty, covered and partly filled ones."""
    film = make_film(np.tile([60.0, 80.0, 20.0, 79.99, 0.0, 40.0, 55.5], 5))
    path = tmp_path / "film.step"
    write_step(film, path)
    assert check_step(path, film).solid_count == {"BEF": 1, "fill": 25}


@pytest.mark.parametrize("curvature", [0, 15, 40, 57, 79.99, 80])
@pytest.mark.parametrize("profile", ["filled", "ideal"])
def test_fused_film_is_one_body_of_the_whole_volume(make_film, tmp_path, curvature, profile):
    film = make_film([curvature, 60.0, curvature], profile)
    path = tmp_path / "film.step"
    write_step(film, path, bodies="fused")
    check = check_step(path, film, bodies="fused")
    assert check.solid_count == {"film": 1}
    assert check.bodies["film"] == pytest.approx(film.volume, rel=1e-9)
    with pytest.raises(ExportError):
        demand(check_step(path, film).gates)


@pytest.mark.slow
@pytest.mark.parametrize("depth", [0.025, 0.0213])
def test_far_from_the_origin_volumes_hold_to_1e_9(tmp_path, depth):
    groove = Groove(0.050, depth)
    curvature = np.full(7846, groove.curvature_empty)
    curvature[7800:] = groove.curvature_empty * np.linspace(0.2, 0.9, 46)
    film = PrismFilm(groove, 0.2, 2.0, "filled", curvature)
    path = tmp_path / "film.step"
    write_step(film, path)
    assert check_step(path, film).volume_error < 1e-9


def test_resin_and_prism_share_their_walls(make_film, tmp_path):
    """Two planes a groove, besides the sides, the ends and the underside."""
    path = tmp_path / "film.step"
    write_step(make_film([60.0, 50.0, 70.0]), path)
    assert path.read_text().count("=PLANE(") == 2 * 3 + 5


def colours_read(path):
    """Return each part's name and the colours of its solids, from OCCT's document of products."""
    from OCP.collections import Sequence_TDF_Label
    from OCP.Quantity import Quantity_Color
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFDoc import XCAFDoc_ColorSurf, XCAFDoc_ColorTool, XCAFDoc_DocumentTool
    from OCP.XCAFDoc import XCAFDoc_ShapeTool as Shapes

    reader, document = STEPCAFControl_Reader(), TDocStd_Document(TCollection_ExtendedString("x"))
    reader.ReadFile(str(path))
    assert reader.Transfer(document)
    roots, parts = Sequence_TDF_Label(), Sequence_TDF_Label()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    assert roots.Length() == 1
    Shapes.GetComponents_s(roots.Value(1), parts)
    found = {}
    for use in (parts.Value(i) for i in range(1, parts.Length() + 1)):
        part, name, solids = TDF_Label(), TDataStd_Name(), Sequence_TDF_Label()
        Shapes.GetReferredShape_s(use, part)
        part.FindAttribute(TDataStd_Name.GetID_s(), name)
        Shapes.GetSubShapes_s(part, solids)
        labels = [solids.Value(i) for i in range(1, solids.Length() + 1)] or [part]
        colours = found.setdefault(name.Get().ToExtString(), [])
        for label in labels:
            colour = Quantity_Color()
            assert XCAFDoc_ColorTool.GetColor_s(label, XCAFDoc_ColorSurf, colour)
            linear = (colour.Red(), colour.Green(), colour.Blue())
            srgb = [Quantity_Color.Convert_LinearRGB_To_sRGB_s(value) for value in linear]
            colours.append(tuple(np.round(srgb, 4)))
    return found


def test_occt_reads_the_names_and_colours_that_were_written(make_film, tmp_path):
    film, path = make_film([60.0, 30.0]), tmp_path / "film.step"
    write_step(film, path)
    expected = {"BEF": [COLOURS["BEF"]], "fill": [COLOURS["fill"]] * 2}
    assert colours_read(path) == expected
    write_step(film, path, bodies="fused")
    assert colours_read(path) == {"film": [COLOURS["film"]]}


def test_header_names_and_colours(make_film, tmp_path):
    film = make_film([60.0, 30.0])
    path = tmp_path / "film.step"
    write_step(film, path, name="patterned-16mm")
    text = path.read_text()
    assert "SI_UNIT(.MILLI.,.METRE.)" in text
    assert "AUTOMOTIVE_DESIGN" in text
    assert re.findall(r"=PRODUCT\('([^']*)'", text) == ["BEF", "fill", "patterned-16mm"]
    assert text.count("=COLOUR_RGB(") == 2
    assert text.count("=STYLED_ITEM(") == 3
    assert str(tmp_path) not in text
    assert "B_SPLINE" not in text
    assert "POLYLINE" not in text


def test_same_film_same_bytes_in_one_process_and_in_another(make_film, tmp_path):
    film = make_film([60.0, 30.0, 80.0])
    for name in ("a.step", "b.step"):
        write_step(film, tmp_path / name, name="twin")
    code = (
        "import sys, numpy as np\n"
        "from mpfcad.cad import write_step\n"
        "from mpfcad.film import Groove, PrismFilm\n"
        "film = PrismFilm(Groove(0.050, 0.025), 0.2, 2.0, 'filled', np.array([60.0, 30.0, 80.0]))\n"
        "write_step(film, sys.argv[1], name='twin')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "c.step")], capture_output=True, check=True
    )
    assert done.stdout == done.stderr == b""
    data = [(tmp_path / name).read_bytes() for name in ("a.step", "b.step", "c.step")]
    assert data[0] == data[1] == data[2]
    assert len(list(tmp_path.iterdir())) == 3


def test_the_colours_are_read_by_occt(make_film, tmp_path):
    from build123d import import_step

    film = make_film([60.0, 30.0])
    path = tmp_path / "film.step"
    write_step(film, path)
    parts = {part.label: part for part in import_step(path).children}
    assert set(parts) == {"BEF", "fill"}
    assert len(parts["fill"].solids()) == 2


@pytest.fixture
def written(make_film, tmp_path):
    film = make_film([60.0, 45.0, 70.0])
    path = tmp_path / "film.step"
    write_step(film, path)
    return film, path


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        (".MILLI.,.METRE.", "$,.METRE.", "length units"),
        ("PRODUCT('fill'", "PRODUCT('resin'", "products"),
        ("END-ISO-10303-21;", "", "whole"),
        ("=MANIFOLD_SOLID_BREP(", "=FACETED_BREP(", "solids"),
        (",0.00833333333333333)", ",0.00833334333333333)", "curvature error"),
    ],
)
def test_tampered_text_is_refused(written, old, new, word):
    film, path = written
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(ExportError, match=word):
        demand(check_step(path, film).gates)


def test_a_moved_corner_is_refused(written):
    film, path = written
    text = path.read_text()
    corner = "(0.15,2.,0.225)"
    assert corner in text
    path.write_text(text.replace(corner, "(0.151,2.,0.225)"))
    with pytest.raises(ExportError):
        demand(check_step(path, film).gates)


def test_a_face_turned_inside_out_is_refused_not_repaired(written):
    film, path = written
    text = path.read_text()
    turned = re.sub(r"(=ADVANCED_FACE\(.*),\.F\.\);", r"\1,.T.);", text, count=1)
    assert turned != text
    path.write_text(turned)
    with pytest.raises(ExportError, match="not valid"):
        demand(check_step(path, film).gates)


def test_a_missing_face_is_refused(written):
    film, path = written
    text = path.read_text()
    path.write_text(re.sub(r"CLOSED_SHELL\('',\(#\d+,", "CLOSED_SHELL('',(", text, count=1))
    with pytest.raises(ExportError):
        demand(check_step(path, film).gates)


def test_another_film_is_refused(written, make_film):
    _, path = written
    for other in (
        make_film([60.0, 45.0, 70.00001]),
        make_film([45.0, 60.0, 70.0]),
        make_film([60.0, 45.0, 80.0]),
        make_film([60.0, 45.0, 70.0], length=2.00001),
        make_film([60.0, 45.0, 70.0], "ideal"),
    ):
        with pytest.raises(ExportError):
            demand(check_step(path, other).gates)


def test_refused_films_leave_nothing(make_film, tmp_path):
    with pytest.raises(InputError, match="curvature of groove 0"):
        write_step(make_film(720.0, "ideal"), tmp_path / "film.step")
    assert list(tmp_path.iterdir()) == []


def test_importing_the_room_loads_no_cad_library():
    code = (
        "import sys, mpfcad.cad\n"
        "heavy = {'OCP', 'build123d', 'trimesh', 'manifold3d', 'scipy'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
