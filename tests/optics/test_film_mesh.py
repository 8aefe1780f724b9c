"""Reading a film mesh: what is taken, and that every refusal is one line that names the place."""

import numpy as np
import pytest
from harness import (
    BARE,
    CONCAVE,
    PITCH,
    SECTIONS,
    drawn,
    extruded,
    film_file,
    groove,
    row,
    section_mesh,
    write_facets,
)

from mpfcad.errors import InputError
from mpfcad.optics.solid.mesh import read_film_mesh


@pytest.fixture
def facets():
    return extruded(*row([BARE] * 2, 0.15), 0.1)


def refused(path):
    with pytest.raises(InputError) as caught:
        read_film_mesh(path)
    text = str(caught.value)
    assert "\n" not in text
    assert str(path) in text
    return text


def test_a_film_is_read_as_it_was_written(tmp_path):
    mesh = read_film_mesh(film_file(tmp_path / "a.stl", [CONCAVE] * 2))
    assert mesh.size == pytest.approx((0.1, 0.1, 0.175), abs=1e-8)
    assert len(mesh.top) == 2 * 2 * 24
    corner = mesh.vertex[mesh.top]
    up = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2]
    assert up.sum() / 2 == pytest.approx(0.01, rel=1e-6)


def test_a_moved_film_is_brought_back_to_the_origin(tmp_path, facets):
    moved = write_facets(tmp_path / "a.stl", facets + np.array([-8.0, 16.0, -0.5]))
    still = read_film_mesh(write_facets(tmp_path / "b.stl", facets))
    moved = read_film_mesh(moved)
    assert moved.vertex.min() == 0
    assert moved.size == pytest.approx(still.size, abs=2e-6)
    heights = [np.sort(m.vertex[m.top].reshape(-1, 3), axis=0) for m in (moved, still)]
    assert np.abs(heights[0] - heights[1]).max() < 2e-6


def test_negative_zeros_are_zeros(tmp_path, facets):
    signed = facets.astype("<f4")
    signed[::2][signed[::2] == 0] = -0.0
    assert np.signbit(signed[signed == 0]).any()
    mesh = read_film_mesh(write_facets(tmp_path / "a.stl", signed))
    assert len(mesh.vertex) == 20


def test_missing_file(tmp_path):
    assert "no such file" in refused(tmp_path / "none.stl")


@pytest.mark.parametrize("size", [0, 50, 83, 84, 400])
def test_truncated_file(tmp_path, size):
    path = film_file(tmp_path / "a.stl", [BARE])
    path.write_bytes(path.read_bytes()[:size])
    assert ("not a binary STL" if size else "looks like an empty file") in refused(path)


def test_stl_text_without_corners(tmp_path):
    path = tmp_path / "a.stl"
    path.write_text("solid film\n" + "facet normal 0 0 1\n" * 40 + "endsolid\n")
    assert "an STL as text: expected 4 facets or more" in refused(path)


@pytest.mark.parametrize("factor", [1e3, 1e-3], ids=["µm", "m"])
def test_coordinates_in_another_unit_are_found(tmp_path, facets, factor):
    assert "expected 0.001 to 20 mm" in refused(write_facets(tmp_path / "a.stl", facets * factor))


def test_too_few_facets(tmp_path, facets):
    assert "3 facets" in refused(write_facets(tmp_path / "a.stl", facets[:3]))


def test_not_finite(tmp_path, facets):
    facets[3, 1, 2] = np.nan
    assert "finite" in refused(write_facets(tmp_path / "a.stl", facets))


def test_a_missing_facet_is_found_and_its_place_named(tmp_path, facets):
    top = int(np.argmax(facets[:, :, 2].min(axis=1) >= 0.15))
    text = refused(write_facets(tmp_path / "a.stl", np.delete(facets, top, axis=0)))
    assert "open" in text
    place = [float(v) for v in text.split("(")[1].split(")")[0].split(",")]
    middles = (facets[top] + np.roll(facets[top], -1, axis=0)) / 2
    assert np.abs(middles - place).max(axis=1).min() < 1e-6


def test_a_flipped_facet_is_found(tmp_path, facets):
    facets[5] = facets[5][::-1]
    assert "inconsistently oriented" in refused(write_facets(tmp_path / "a.stl", facets))


def test_an_inverted_solid_is_found(tmp_path, facets):
    text = refused(write_facets(tmp_path / "a.stl", facets[:, ::-1]))
    assert "outward" in text


def test_a_doubled_facet_is_found(tmp_path, facets):
    doubled = np.concatenate([facets, facets[:1], facets[:1, ::-1]])
    assert "two facets" in refused(write_facets(tmp_path / "a.stl", doubled))


def test_a_film_without_flat_underside_is_read_with_all_its_facets(tmp_path, facets):
    facets[..., 2] = np.where(
        (facets[..., 2] == 0) & (np.abs(facets[..., 0] - PITCH) < 1e-6), -0.01, facets[..., 2]
    )
    mesh = read_film_mesh(write_facets(tmp_path / "a.stl", facets))
    assert not mesh.underside
    assert len(mesh.top) == 2 * 2 * 4
    assert (mesh.vertex[mesh.top].mean(axis=1)[:, 2] < 0.02).sum() == 8


def test_a_film_upside_down_is_read(tmp_path, facets):
    turned = read_film_mesh(write_facets(tmp_path / "a.stl", facets * (1.0, -1.0, -1.0)))
    assert not turned.underside
    assert turned.size[2] == pytest.approx(0.175, abs=1e-7)


@pytest.mark.parametrize("name", SECTIONS)
def test_several_bodies_and_voids_are_read(tmp_path, name):
    mesh = section_mesh(tmp_path, name)
    # Each edge of the cross-section but for flat undersides and sides is a strip of two facets.
    rings = [np.asarray(ring) for ring in SECTIONS[name]]
    edges = sum(len(ring) for ring in rings)
    low = min(ring[:, 1].min() for ring in rings)
    for ring in rings:
        a, b = ring, np.roll(ring, -1, axis=0)
        edges -= ((a[:, 0] == b[:, 0]) & np.isin(a[:, 0], (0, 0.1))).sum()
        edges -= mesh.underside * ((a[:, 1] == low) & (b[:, 1] == low)).sum()
    assert len(mesh.top) == 2 * edges
    assert mesh.underside == ("grooves" not in name)


def test_a_body_that_ends_on_the_side_of_the_tile_is_refused(tmp_path):
    square = [(0.0, 0.05), (0.05, 0.0), (0.1, 0.05), (0.05, 0.1)]
    text = refused(write_facets(tmp_path / "a.stl", drawn([square], 0.1)))
    assert "touches its copy in the next tile at (0, 0, 0.05) mm" in text


def test_facets_without_extent_are_left_out(tmp_path, facets):
    a, b = facets[0, :2]
    # As a mesher leaves them where points fall together in single precision.
    more = np.concatenate([facets, [[a, b, b], [a, a, a]]])
    read = read_film_mesh(write_facets(tmp_path / "a.stl", more))
    plain = read_film_mesh(write_facets(tmp_path / "b.stl", facets))
    assert (read.top == plain.top).all() and (read.vertex == plain.vertex).all()


def test_a_film_whose_valley_touches_its_underside_is_refused(tmp_path):
    x, z = row([BARE] * 2, 0.0)
    text = refused(write_facets(tmp_path / "a.stl", extruded(x, z, 0.1)))
    assert "touches itself at (0.025, " in text


def test_a_film_that_does_not_repeat_is_refused(tmp_path):
    x, z = row([BARE] * 2, 0.15)
    z[-1] += 0.001
    text = refused(write_facets(tmp_path / "a.stl", extruded(x, z, 0.1)))
    assert "x = 0" in text and "repeat" in text


def test_a_flat_sheet_is_no_solid(tmp_path, facets):
    facets[..., 2] = 0.0
    refused(write_facets(tmp_path / "a.stl", facets))


def test_each_groove_may_have_its_own_curvature(tmp_path):
    grooves = [groove(c) for c in (0.0, 40.0001, 60.0, 80.0)]
    mesh = read_film_mesh(film_file(tmp_path / "a.stl", grooves))
    assert mesh.size[0] == pytest.approx(0.2, rel=1e-6)
