"""Moulds: what a tool leaves, its path, and every file read back; the same for rounded films."""

import ezdxf
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpfcad.cad import check_agreement
from mpfcad.cad.check.section import check_section_step, check_section_stl
from mpfcad.cad.file.dxf import check_dxf, rational_outline, write_dxf
from mpfcad.cad.file.stl import write_mesh
from mpfcad.cad.shape.mould import build_mould
from mpfcad.cad.shape.section_mesh import build_section_mesh
from mpfcad.cad.shape.turning import build_turning_table, write_turning_table
from mpfcad.cad.step.section import FILM_COLOUR, write_section_step
from mpfcad.errors import ExportError, InputError
from mpfcad.film import Imperfection, build_section
from mpfcad.gate import demand
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.units import deg

CURVATURES = np.array([20.0, 38.0, 41.0, 60.0, 79.0, 80.0])
PROFILES = pytest.mark.parametrize("profile", ["filled", "ideal"])
MADE = {
    "plain": Imperfection(),
    "tip": Imperfection(0.001),
    "both": Imperfection(0.003, 0.004),
}


@pytest.fixture(params=["filled", "ideal"])
def film(make_film, request):
    return make_film(CURVATURES, request.param, length=1.0)


def test_sharp_tool_leaves_nothing(film):
    mould = build_mould(film, shrinkage=0.01)
    assert mould.cut is mould.section
    assert mould.lost_area.max() == mould.lost_height.max() == 0
    assert mould.section.width == pytest.approx(film.width / 0.99)


def test_tool_leaves_what_a_circle_cannot_reach(make_film):
    """In a straight valley of 90° a nose of radius r leaves (1 - π/4) r² and (√2 - 1) r."""
    mould = build_mould(make_film(80.0), shrinkage=0.01, tool_radius=0.002)
    assert mould.lost_area == pytest.approx((1 - np.pi / 4) * 0.002**2, rel=1e-6)
    assert mould.lost_height == pytest.approx((np.sqrt(2) - 1) * 0.002, rel=1e-6)


def test_mould_is_mirrored(make_film):
    film = make_film([20.0, 60.0])
    mould = build_mould(film, tool_radius=0.001)
    x = np.linspace(0, film.width, 401)
    assert mould.section.height(film.width - x) == pytest.approx(film.thickness - film.height(x))
    # Less curved grooves have blunter tips: the loss is mirrored too.
    assert np.ptp(mould.lost_area) > 0 or np.ptp(mould.lost_height) >= 0


@settings(max_examples=15)
@given(radius=st.floats(0.0005, 0.004), shrinkage=st.floats(0, 0.02))
def test_tool_touches_and_never_gouges(radius, shrinkage):
    """No point of the surface is nearer to the nose's centre than its radius; one is as near."""
    from mpfcad.film import Groove, PrismFilm

    film = PrismFilm(Groove(0.05, 0.025), 0.2, 1.0, "filled", CURVATURES[[0, 3, 5]])
    cut = build_mould(film, tool_radius=radius, shrinkage=shrinkage).cut
    table = build_turning_table(cut, radius, 2 * deg)
    x = np.unique(np.concatenate([np.linspace(0, cut.width, 6001), table.x]))
    z = cut.height(x)
    for cx, cz in zip(table.tool_x[::7], table.tool_z[::7], strict=True):
        nearest = np.hypot(x - cx, z - cz).min()
        assert nearest >= radius * (1 - 1e-9)
        assert nearest <= radius * (1 + 1e-9) + 1e-12
    assert np.abs(np.diff(table.slope)).max() < 2 * deg * (1 + 1e-9)
    assert np.diff(table.x).min() >= 0


def test_turning_table_in_outside_units(film, tmp_path):
    mould = build_mould(film, tool_radius=0.001)
    table = build_turning_table(mould.cut, 0.001, 1 * deg)
    write_turning_table(table, tmp_path / "profile.csv")
    lines = (tmp_path / "profile.csv").read_text().splitlines()
    assert lines[0] == "x_um,z_um,slope_deg,tool_x_um,tool_z_um"
    x, z, slope, tool_x, tool_z = np.loadtxt(lines[1:], delimiter=",").T
    assert z == pytest.approx(mould.cut.height(x / 1000) * 1000, abs=1e-6)
    assert np.hypot(tool_x - x, tool_z - z) == pytest.approx(1.0, abs=1e-6)
    assert np.rad2deg(np.arctan2(x - tool_x, tool_z - z)) == pytest.approx(slope, abs=1e-4)


def test_tool_that_does_not_fit(film):
    with pytest.raises(InputError, match=r"tool radius: 90 µm: does not fit"):
        build_mould(film, tool_radius=0.09)


@pytest.mark.parametrize("made", MADE.values(), ids=MADE)
@pytest.mark.parametrize("side", ["film", "mould"])
def test_files_read_back(film, tmp_path, made, side):
    section = build_section(film, made, 1e-4)
    if side == "mould":
        section = build_mould(film, made, shrinkage=0.005, sliver=1e-4).section
    path = tmp_path / "body.step"
    write_section_step(section, path, name="job", body="film", colour=FILM_COLOUR)
    assert check_section_step(path, section, "film").volume_error < 1e-10
    first = path.read_bytes()
    write_section_step(section, path, name="job", body="film", colour=FILM_COLOUR)
    assert path.read_bytes() == first
    path = tmp_path / "body.stl"
    write_mesh(build_section_mesh(section, 0.5 * deg), path, "film")
    check = check_section_stl(path, section, 0.5 * deg)
    assert abs(check.volume_error) < 1e-5
    assert check.normal_error_rms < 0.03 * deg
    if side == "film":
        agreement = check_agreement(tmp_path / "body.step", path, section.volume)
        assert agreement.distance_max < 5e-8
        # The tracer takes it: it has a flat underside and repeats.
        assert read_film_mesh(path).size == pytest.approx(
            (section.width, section.length, section.thickness), rel=1e-6
        )


def test_another_film_is_noticed(film, tmp_path):
    section = build_section(film, Imperfection(0.001))
    other = build_section(film, Imperfection(0.0015))
    path = tmp_path / "body.step"
    write_section_step(section, path, name="job", body="film", colour=FILM_COLOUR)
    with pytest.raises(ExportError, match="volume"):
        demand(check_section_step(path, other, "film").gates)
    with pytest.raises(ExportError, match="bodies"):
        demand(check_section_step(path, section, "mould").gates)
    write_mesh(build_section_mesh(section, 0.5 * deg), tmp_path / "body.stl", "film")
    with pytest.raises(ExportError):
        demand(check_section_stl(tmp_path / "body.stl", other, 0.5 * deg).gates)


@pytest.mark.parametrize("made", MADE.values(), ids=MADE)
def test_dxf_is_exact_closed_and_in_mm(film, tmp_path, made):
    section = build_mould(film, made, shrinkage=0.005, sliver=1e-4).section
    path = tmp_path / "mould.dxf"
    write_dxf(section, path, 0.5 * deg)
    assert abs(check_dxf(path, section)) < 1e-5
    first = path.read_bytes()
    write_dxf(section, path, 0.5 * deg)
    assert path.read_bytes() == first
    document = ezdxf.readfile(path)
    assert document.header["$INSUNITS"] == 4
    spline = document.modelspace().query("SPLINE").first
    curve = spline.construction_tool()
    inner = np.linspace(0.01, section.piece_count - 0.01, 997)
    point = np.array([[p.x, p.y] for p in curve.points(inner)])
    assert point[:, 1] == pytest.approx(section.height(point[:, 0]), abs=1e-9)
    assert spline.control_points[0] == pytest.approx(spline.control_points[-1])


def test_dxf_off_the_surface_is_noticed(film, tmp_path):
    section = build_section(film)
    path = tmp_path / "film.dxf"
    write_dxf(section, path, 0.5 * deg)
    with pytest.raises(ExportError, match=r"off the surface|area"):
        check_dxf(path, build_section(film, Imperfection(0.0, 0.004)).scaled(1.0001))


def test_arc_weights_make_circles(make_film):
    section = build_section(make_film(80.0), Imperfection(0.002))
    points, weights, knots = rational_outline(section)
    assert len(knots) == len(points) + 3
    # A 90° tip turns by 90°: weight cos 45°; its halves at the film's ends cos 22.5°.
    assert weights[1] == pytest.approx(np.cos(np.pi / 8))
    assert np.cos(np.pi / 4) == pytest.approx(weights[1:-4:2].min())
