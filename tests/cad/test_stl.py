"""STL files: written, read back, and refused once tampered with."""

from pathlib import Path

import numpy as np
import pytest

from mpfcad.cad import check_stl, write_stl
from mpfcad.cad.check.mesh_check import check_closed
from mpfcad.cad.file.stl import FACET
from mpfcad.errors import ExportError, InputError
from mpfcad.gate import demand
from mpfcad.units import deg

TOLERANCE = 0.5 * deg


@pytest.mark.parametrize(
    ("curvature", "profile"),
    [(c, "filled") for c in (0, 15, 40, 40.0001, 45, 57, 60, 79.6, 79.69, 79.99, 80)]
    + [(c, "ideal") for c in (0, 60, 81, 100)],
)
def test_written_films_read_back(make_film, tmp_path, curvature, profile):
    film = make_film(curvature, profile, count=5)
    path = tmp_path / "film.stl"
    write_stl(film, path, TOLERANCE)
    check = check_stl(path, film, TOLERANCE)
    assert check.watertight
    assert abs(check.volume_error) < 2e-5
    assert check.normal_error_rms < 0.005 * deg
    assert check.normal_error_max <= TOLERANCE
    assert check.height_error_max < 1e-7
    assert check.triangle_count == (path.stat().st_size - 84) // 50
    # Resin narrower than a sliver (C > 79.68) is meshed as none, and that is as much C as it has.
    np.testing.assert_allclose(check.curvature, curvature, atol=1e-4)
    assert all(gate.outcome == "PASS" for gate in check.gates)


def test_a_varied_film_of_a_pitch_reads_back(make_film, tmp_path):
    film = make_film(60 + 19 * np.cos(np.arange(654) / 654 * 2 * np.pi))
    path = tmp_path / "film.stl"
    write_stl(film, path, TOLERANCE)
    check = check_stl(path, film, TOLERANCE)
    assert check.normal_error_max <= TOLERANCE
    np.testing.assert_allclose(check.curvature, film.curvature, atol=1e-4)


@pytest.mark.slow
def test_every_groove_of_a_panel_has_the_profiles_slopes(make_film, tmp_path):
    """The slopes of facets are those of secants, by area, in the worst groove too."""
    film = make_film(60 + 19 * np.cos(np.arange(7846) / 653.8 * 2 * np.pi))
    path = tmp_path / "film.stl"
    write_stl(film, path, TOLERANCE)
    check = check_stl(path, film, TOLERANCE)
    assert check.secant_error_rms < 0.0005 * deg
    assert check.secant_error_groove < 0.001 * deg
    assert check.tip_error_max <= np.spacing(np.float32(film.width))
    np.testing.assert_allclose(check.curvature, film.curvature, atol=1e-4)


def test_a_thick_plate_reads_back(tmp_path, make_film):
    from dataclasses import replace

    film = replace(make_film(60.0), base=2.0)
    path = tmp_path / "plate.stl"
    write_stl(film, path, TOLERANCE)
    assert check_stl(path, film, TOLERANCE).normal_error_max <= TOLERANCE


def test_same_film_same_bytes_and_header(make_film, tmp_path):
    film = make_film([60.0, 20.0, 80.0])
    for name in ("a.stl", "b.stl"):
        write_stl(film, tmp_path / name, TOLERANCE, name="patterned-16mm")
    data = (tmp_path / "a.stl").read_bytes()
    assert data == (tmp_path / "b.stl").read_bytes()
    assert b"mm" in data[:80]
    assert b"patterned-16mm" in data[:80]
    assert not data.startswith(b"solid")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.stl", "b.stl"]


def test_refused_films_leave_nothing(make_film, tmp_path):
    with pytest.raises(InputError):
        write_stl(make_film(-1.0), tmp_path / "film.stl", TOLERANCE)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def written(make_film, tmp_path):
    film = make_film([60.0, 45.0, 70.0])
    path = tmp_path / "film.stl"
    write_stl(film, path, TOLERANCE)
    return film, path, np.fromfile(path, FACET, offset=84)


def save(path, facets):
    """Write the facets over the file's own."""
    header = path.read_bytes()[:80]
    count = np.uint32(len(facets)).astype("<u4").tobytes()
    path.write_bytes(header + count + facets.tobytes())


def move(facets, corner, by):
    """Move a corner everywhere it occurs, keeping the mesh closed and its normals right."""
    here = np.all(facets["corner"] == corner, axis=2)
    facets["corner"][here] += np.asarray(by, np.float32)
    corners = facets["corner"].astype(float)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facets["normal"] = normal / np.linalg.norm(normal, axis=1, keepdims=True)


def test_untampered_passes(written):
    film, path, facets = written
    save(path, facets)
    check_stl(path, film, TOLERANCE)


@pytest.mark.parametrize(
    ("tamper", "word"),
    [
        (lambda f: f.__setitem__("corner", f["corner"][:, ::-1]), "stored normal"),
        (lambda f: f["normal"].__setitem__(7, -f["normal"][7]), "stored normal"),
        (lambda f: f["corner"].__setitem__((7, 0, 2), 0.2), "."),
        (lambda f: move(f, f["corner"][40, 0].copy(), [0, 0, 2e-6]), "normal error"),
        (lambda f: move(f, f["corner"][40, 0].copy(), [0, 1e-3, 0]), "extent|normal"),
        (lambda f: f["corner"].__imul__(np.float32(25.4)), "."),
        (lambda f: f["corner"].__setitem__((0, 0, 0), np.nan), "finite"),
    ],
    ids=["all-flipped", "normal", "torn", "height", "lean", "inch", "nan"],
)
def test_tampered_files_are_refused(written, tamper, word):
    film, path, facets = written
    tamper(facets)
    save(path, facets)
    with pytest.raises(ExportError, match=word):
        demand(check_stl(path, film, TOLERANCE).gates)


def test_a_flipped_facet_is_refused(written):
    film, path, facets = written
    facets["corner"][5] = facets["corner"][5][::-1].copy()
    facets["normal"][5] *= -1
    save(path, facets)
    with pytest.raises(ExportError, match="closed"):
        demand(check_stl(path, film, TOLERANCE).gates)


def test_an_inside_out_mesh_is_refused(written):
    film, path, facets = written
    facets["corner"] = facets["corner"][:, ::-1].copy()
    facets["normal"] *= -1
    save(path, facets)
    with pytest.raises(ExportError, match="inward"):
        demand(check_stl(path, film, TOLERANCE).gates)


def test_missing_or_doubled_facets_are_refused(written):
    film, path, facets = written
    for wrong in (np.delete(facets, 11), np.append(facets, facets[11]), np.tile(facets, 2)):
        save(path, wrong)
        with pytest.raises(ExportError, match="closed"):
            demand(check_stl(path, film, TOLERANCE).gates)


def test_a_second_body_is_refused(written):
    film, path, facets = written
    other = facets.copy()
    other["corner"][:, :, 2] *= np.float32(1e-3)
    other["corner"][:, :, 2] += np.float32(0.05)
    move(other, np.zeros(3, np.float32) - 1, [0, 0, 0])
    save(path, np.concatenate([facets, other]))
    with pytest.raises(ExportError):
        demand(check_stl(path, film, TOLERANCE).gates)


def bodies_of(*bodies):
    """Return corners (t, 3, 3) and normals of manifold3d's bodies as one mesh."""
    meshes = [body.to_mesh64() for body in bodies]
    corner = np.concatenate([m.vert_properties[:, :3][m.tri_verts] for m in meshes])
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return corner, normal / np.linalg.norm(normal, axis=1, keepdims=True)


def test_one_body_without_a_hole_is_closed_and_no_other():
    """A ring is refused, and so is one beside a block: their Euler numbers add up to a block's."""
    import manifold3d

    block = manifold3d.Manifold.cube((1.0, 1.0, 1.0))
    ring = manifold3d.Manifold.cube((3.0, 3.0, 1.0)).translate((4.0, 0.0, 0.0))
    ring -= manifold3d.Manifold.cube((1.0, 1.0, 3.0)).translate((5.0, 1.0, -1.0))
    assert check_closed(Path("a.stl"), *bodies_of(block)) == pytest.approx(1.0)
    with pytest.raises(ExportError, match="not one simple solid"):
        check_closed(Path("a.stl"), *bodies_of(ring))
    with pytest.raises(ExportError, match="more than one body"):
        check_closed(Path("a.stl"), *bodies_of(block, ring))


def test_a_stored_normal_turned_a_little_is_refused(written):
    film, path, facets = written
    facets["normal"][7] += np.float32([2e-5, 0, 0])
    save(path, facets)
    with pytest.raises(ExportError, match="stored normal"):
        check_stl(path, film, TOLERANCE)


def far_end(facets, axis, by):
    """Move the corners of the far end along y (of its top, if `axis` is 2) by so much [mm]."""
    corner = facets["corner"]
    here = corner[:, :, 1] == corner[:, :, 1].max()
    if axis == 2:
        here &= corner[:, :, 2] > 0
    corner[..., axis][here] += np.float32(by)
    away = np.full(3, np.nan, np.float32)
    move(facets, away, [0, 0, 0])


@pytest.mark.parametrize(
    ("tamper", "gate"),
    [
        (lambda f: move(f, f["corner"][40, 0].copy(), [0, 0, 1e-6]), "mesh_height_error_um"),
        (lambda f: far_end(f, 1, 5e-4), "mesh_extent_error_um"),
        (lambda f: far_end(f, 1, 5e-4), "mesh_volume_error"),
        (lambda f: far_end(f, 2, -0.02), "mesh_normal_error_deg"),
    ],
    ids=["height", "extent", "volume", "lean"],
)
def test_a_little_too_much_fails_its_gate(written, tamper, gate):
    """A nanometre of height, half a micrometre of 2 mm, half a degree of lean along the grooves."""
    film, path, facets = written
    tamper(facets)
    save(path, facets)
    gates = {found.name: found.outcome for found in check_stl(path, film, TOLERANCE).gates}
    assert gates[gate] == "FAIL"


def test_a_kink_three_nanometres_off_its_place_is_seen(make_film, tmp_path):
    """C 0.005 /mm larger moves the contact point by 2.8 nm: a wall's end there is no parabola's."""
    write_stl(make_film(60.0), tmp_path / "film.stl", TOLERANCE)
    check = check_stl(tmp_path / "film.stl", make_film(60.005), TOLERANCE)
    failed = {gate.name for gate in check.gates if gate.outcome == "FAIL"}
    assert "mesh_normal_error_deg" in failed


def test_a_cut_short_file_is_refused(written):
    film, path, _ = written
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(ExportError, match="binary STL"):
        demand(check_stl(path, film, TOLERANCE).gates)


def test_another_film_is_refused(written, make_film):
    _, path, _ = written
    with pytest.raises(ExportError):
        demand(check_stl(path, make_film([60.0, 45.2, 70.0]), TOLERANCE).gates)
    with pytest.raises(ExportError, match="normal error"):
        demand(check_stl(path, make_film([60.0, 45.0, 70.0]), TOLERANCE / 2).gates)
