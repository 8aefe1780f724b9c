"""3MF and PLY files: written, read back with another library, and refused when wrong."""

import zipfile

import numpy as np
import pytest

from mpfcad.cad import check_3mf, check_ply, write_3mf, write_ply
from mpfcad.cad.check.section_file import check_section_3mf, check_section_ply
from mpfcad.cad.file.ply import write_section_ply
from mpfcad.cad.file.threemf import write_3mf_meshes
from mpfcad.cad.shape.section_mesh import build_section_mesh
from mpfcad.errors import ExportError
from mpfcad.film import Imperfection, MadeFilm
from mpfcad.units import deg

TOLERANCE = 0.5 * deg
CURVATURES = (0, 15, 40, 45, 57, 60, 79, 80)


@pytest.mark.parametrize(
    ("curvature", "profile"), [(c, "filled") for c in CURVATURES] + [(60, "ideal"), (90, "ideal")]
)
def test_3mf_reads_back_with_lib3mf(make_film, tmp_path, curvature, profile):
    film = make_film([curvature, 60.0, 30.0], profile)
    path = tmp_path / "film.3mf"
    write_3mf(film, path, TOLERANCE)
    check = check_3mf(path, film)
    assert set(check.volume) == ({"BEF", "fill"} if profile == "filled" else {"film"})
    assert sum(check.volume.values()) == pytest.approx(film.volume, rel=5e-5)


def test_3mf_states_unit_names_components_and_no_time(make_film, tmp_path):
    film = make_film([60.0, 30.0])
    for name in ("a.3mf", "b.3mf"):
        write_3mf(film, tmp_path / name, TOLERANCE, name="patterned & 16mm")
    assert (tmp_path / "a.3mf").read_bytes() == (tmp_path / "b.3mf").read_bytes()
    text = zipfile.ZipFile(tmp_path / "a.3mf").read("3D/3dmodel.model").decode()
    assert 'unit="millimeter"' in text
    assert text.count("<component ") == 2
    assert text.count('transform="1 0 0 0 1 0 0 0 1 0 0 0"') == 2
    assert 'name="BEF"' in text
    assert 'name="fill"' in text
    assert "patterned &amp; 16mm" in text


def test_empty_film_has_no_fill_in_3mf(make_film, tmp_path):
    write_3mf(make_film(80.0), tmp_path / "film.3mf", TOLERANCE)
    assert set(check_3mf(tmp_path / "film.3mf", make_film(80.0)).volume) == {"BEF"}


def rewritten(path, old, new):
    """Replace text in the model of a 3MF file."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name).decode() for name in archive.namelist()}
    assert old in parts["3D/3dmodel.model"]
    parts["3D/3dmodel.model"] = parts["3D/3dmodel.model"].replace(old, new, 1)
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in parts.items():
            archive.writestr(name, text)


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('unit="millimeter"', 'unit="inch"', "mm"),
        ('name="fill" pid', 'name="resin" pid', "bodies"),
        ("1 0 0 0 1 0 0 0 1 0 0 0", "1 0 0 0 1 0 0 0 1 0 0 5", "place"),
        ("</triangles>", '<triangle v1="0" v2="1" v3="2"/></triangles>', "."),
        ('y="2"', 'y="3"', "volume"),
    ],
)
def test_tampered_3mf_is_refused(make_film, tmp_path, old, new, word):
    film = make_film([60.0])
    path = tmp_path / "film.3mf"
    write_3mf(film, path, TOLERANCE)
    rewritten(path, old, new)
    with pytest.raises(ExportError, match=word):
        check_3mf(path, film)


@pytest.mark.parametrize(
    ("curvature", "profile"), [(c, "filled") for c in (*CURVATURES, 79.9)] + [(60, "ideal")]
)
def test_ply_reads_back_with_trimesh(make_film, tmp_path, curvature, profile):
    film = make_film([curvature, 60.0, 30.0], profile)
    path = tmp_path / "film.ply"
    write_ply(film, path, TOLERANCE)
    check = check_ply(path, film)
    assert check.volume["film"] == pytest.approx(film.volume, rel=5e-5)


def test_ply_of_a_wide_film_is_as_exact_at_its_end(make_film, tmp_path):
    film = make_film(np.tile([60.0, 45.0, 70.0], 300))
    write_ply(film, tmp_path / "film.ply", TOLERANCE)
    check_ply(tmp_path / "film.ply", film)


def test_another_film_is_refused(make_film, tmp_path):
    film = make_film([60.0, 45.0, 70.0])
    write_ply(film, tmp_path / "film.ply", TOLERANCE)
    write_3mf(film, tmp_path / "film.3mf", TOLERANCE)
    for other in (make_film([60.0, 45.0, 60.0]), make_film(60.0, count=4)):
        with pytest.raises(ExportError):
            check_ply(tmp_path / "film.ply", other)
        with pytest.raises(ExportError):
            check_3mf(tmp_path / "film.3mf", other)
    with pytest.raises(ExportError, match="read"):
        check_ply(tmp_path / "film.3mf", film)
    with pytest.raises(ExportError, match="read"):
        check_3mf(tmp_path / "film.ply", film)


def test_section_files_of_another_film_are_refused(make_film, tmp_path):
    films = [MadeFilm(make_film(c), Imperfection(tip_radius=0.0015)) for c in (60.0, 55.0)]
    sections = [made.section(1e-4) for made in films]
    angle = np.radians(0.5)
    mesh = build_section_mesh(sections[0], angle)
    write_3mf_meshes({"film": mesh}, tmp_path / "a.3mf", "a")
    write_section_ply(sections[0], tmp_path / "a.ply", angle)
    assert check_section_3mf(tmp_path / "a.3mf", sections[0]).volume["film"] > 0
    found = check_section_ply(tmp_path / "a.ply", sections[0])
    assert found.volume["film"] == pytest.approx(sections[0].volume, rel=1e-4)
    for check, name in ((check_section_3mf, "a.3mf"), (check_section_ply, "a.ply")):
        with pytest.raises(ExportError, match="volume"):
            check(tmp_path / name, sections[1])
