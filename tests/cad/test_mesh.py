"""The cross-section's polyline and the mesh on it, before any file."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpfcad.cad.shape.mesh import build_cross_section, build_mesh
from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm
from mpfcad.units import deg

BEF = Groove(0.050, 0.025)


def edge_counts(triangles):
    """Return how often each directed edge occurs, and whether each has its opposite."""
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    back = np.unique(edges[:, ::-1], axis=0)
    return count, np.array_equal(unique, back)


def enclosed_volume(mesh):
    a, b, c = np.moveaxis(mesh.vertices.astype(float)[mesh.triangles], 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6)


@settings(max_examples=60, deadline=None)
@given(
    curvature=st.lists(st.floats(0, 80) | st.floats(80, 700), min_size=1, max_size=5),
    profile=st.sampled_from(["filled", "ideal"]),
    tolerance=st.floats(0.2, 20.0),
)
def test_any_film_is_one_closed_outward_mesh_of_the_right_volume(curvature, profile, tolerance):
    most = min(BEF.curvature_most(profile), 700)
    film = PrismFilm(BEF, 0.2, 2.0, profile, np.minimum(curvature, most))
    mesh = build_mesh(film, tolerance * deg)
    count, paired = edge_counts(mesh.triangles)
    assert paired
    assert count.max() == 1
    assert np.array_equal(np.unique(mesh.triangles), np.arange(len(mesh.vertices)))
    assert len(np.unique(mesh.vertices, axis=0)) == len(mesh.vertices)
    assert enclosed_volume(mesh) == pytest.approx(film.volume, rel=1e-4)


@pytest.mark.parametrize("curvature", [0, 15, 40, 40.0001, 40.1, 57, 79.6, 79.99, 80])
@pytest.mark.parametrize("tolerance", [0.25, 0.5, 2.0])
def test_chords_keep_the_angle(make_film, curvature, tolerance):
    film = make_film(curvature)
    section = build_cross_section(film, tolerance * deg)
    x, z = section.x.astype(float), section.z.astype(float)
    chord = np.arctan(np.diff(z) / np.diff(x))
    # Inside each chord, clear of its ends, by central differences of the closed form.
    worst = 0.0
    for part in np.linspace(0.01, 0.99, 23):
        at = x[:-1] + part * np.diff(x)
        slope = (film.height(at + 1e-8) - film.height(at - 1e-8)) / 2e-8
        # Parts merged for being thinner than 0.1 µm are no part of the mesh.
        local = at - (np.floor(at / BEF.pitch) + 0.5) * BEF.pitch
        contact = BEF.contact_position(curvature)
        merged = (contact < 1e-4) & (np.abs(local) < 1e-4)
        merged |= (BEF.half_width - contact < 1e-4) & (np.abs(local) > contact)
        worst = max(worst, float(np.abs(chord - np.arctan(slope))[~merged].max()))
    assert worst <= tolerance * deg


def test_half_the_tolerance_gives_about_twice_the_facets(make_film):
    film = make_film(60.0)
    counts = [len(build_mesh(film, angle * deg).triangles) for angle in (1.0, 0.5, 0.25)]
    assert 1.7 < counts[1] / counts[0] < 2.1
    assert 1.7 < counts[2] / counts[1] < 2.1


@pytest.mark.parametrize("curvature", [0.0, 30.0, 60.0, 79.0])
def test_corners_are_symmetric_and_have_tips_contacts_and_centre(make_film, curvature):
    film = make_film(curvature, count=1)
    contact = float(BEF.contact_position(curvature))
    for number, off in ((np.float64, 1e-15), (np.float32, 1e-8)):
        local = build_cross_section(film, 0.5 * deg, number).x.astype(float) - 0.025
        for corner in (-0.025, -contact, contact, 0.025):
            assert np.abs(local - corner).min() < off
        # In float32 other corners move by up to a quarter of a chord, so that z rounds well.
        chord = np.diff(local).max() if number is np.float32 else off
        np.testing.assert_allclose(local, -local[::-1], atol=chord / 2)
        assert np.abs(local).min() <= chord / 4
        assert np.all(np.diff(local) > 0)


@pytest.mark.parametrize("curvature", [20.0, 41.0, 48.0, 75.0, 80.0])
def test_grooves_have_the_profiles_slopes_and_the_same_chords_everywhere(curvature):
    """At x = 390 mm one float32 step is 30 nm, a tenth of a facet of 0.5°."""
    film = PrismFilm(BEF, 0.2, 2.0, "filled", np.full(7846, curvature))
    section = build_cross_section(film, 0.5 * deg)
    step = np.spacing(np.float32(film.width))
    moved = section.x[section.tip].astype(float) - film.tip_position
    assert np.abs(moved).max() <= step
    assert np.all(section.z[section.tip] == np.float32(film.thickness))
    assert len(np.unique(np.diff(section.tip))) == 1
    contact = float(BEF.contact_position(curvature))
    bare = 0 < contact < BEF.half_width
    seen = set()
    for i in [*range(100), *range(7700, 7800)]:
        depths, slopes, profile, size = [], [], [], []
        middle = section.centre[i]
        halves = ((section.tip[i], middle, i, 1), (middle, section.tip[i + 1], i + 1, -1))
        for first, last, tip, side in halves:
            x = section.x[first : last + 1].astype(float)
            z = section.z[first : last + 1].astype(float)
            depth = (side * (x - section.x[section.tip[tip]]))[::side]
            local = x - moved[tip] - film.groove_position[i]
            walls = curvature == 80.0 or (bare & (np.arange(len(x) - 1)[::side] == 0))
            secant = np.where(walls, -side, curvature * (local[1:] + local[:-1]) / 2)
            slopes.append(np.arctan2(np.diff(z), np.diff(x)))
            profile.append(np.arctan(secant))
            size.append(np.hypot(np.diff(z), np.diff(x)))
            depths += list(depth[:-1])
            # Resin is lifted to meet the rounded contact point, by less than a step.
            true = film.height(film.groove_position[i] + local)
            if curvature == 80.0:
                true = film.thickness - BEF.wall_slope * (BEF.half_width + side * local)
            assert np.abs(z - true).max() <= bare * step + np.spacing(np.float32(film.thickness))
        slopes, profile, size = map(np.concatenate, (slopes, profile, size))
        assert np.sqrt(np.average((slopes - profile) ** 2, weights=size)) < 0.001 * deg
        seen.add(tuple(depths))
    # A contact point is rounded up in some grooves and down in others.
    assert len(seen) <= 2


def test_sides_are_plane_and_whole(make_film):
    film = make_film([60.0, 20.0, 75.0, 80.0])
    mesh = build_mesh(film, 0.5 * deg)
    width, length = np.float32(film.width), np.float32(film.length)
    top, vertices = np.float32(film.thickness), mesh.vertices
    assert set(np.unique(vertices[:, 1])) == {np.float32(0), length}
    for side in (np.float32(0), width):
        there = vertices[vertices[:, 0] == side]
        assert {(float(y), float(z)) for _, y, z in there} == {
            (float(y), float(z)) for y in (0, length) for z in (0, top)
        }
    assert np.ptp(vertices[:, 0]) == width
    near, far = vertices[vertices[:, 1] == 0], vertices[vertices[:, 1] > 0]
    np.testing.assert_array_equal(near[:, [0, 2]], far[:, [0, 2]])


def test_no_chord_is_a_sliver():
    """Just above C = 40 and just below 80 the wall or the parabola is thinner than 0.1 µm."""
    curvature = np.concatenate([40 + np.geomspace(1e-6, 1, 30), 80 - np.geomspace(1e-6, 1, 30)])
    section = build_cross_section(PrismFilm(BEF, 0.2, 2.0, "filled", curvature), 0.5 * deg)
    assert np.diff(section.x).min() > 0.9e-4


@pytest.mark.parametrize("angle", [0.0, -1.0, np.nan, 1e-6])
def test_impossible_tolerances_are_refused(make_film, angle):
    with pytest.raises(InputError, match="angle_tolerance"):
        build_mesh(make_film(60.0), angle * deg)


@pytest.mark.parametrize(
    ("curvature", "profile", "words"),
    [
        (-1.0, "filled", r"curvature\[1\]: -1"),
        (np.nan, "filled", r"curvature\[1\]: nan"),
        (720.0, "ideal", "curvature of groove 1"),
    ],
)
def test_impossible_curvatures_are_refused(make_film, curvature, profile, words):
    with pytest.raises(InputError, match=words):
        build_mesh(make_film([60.0, curvature], profile), 0.5 * deg)


def test_a_deep_ideal_groove_over_a_thin_base_is_closed():
    film = PrismFilm(BEF, 0.005, 1.0, "ideal", np.array([90.0, 10.0]))
    mesh = build_mesh(film, 0.5 * deg)
    assert edge_counts(mesh.triangles)[1]
    assert enclosed_volume(mesh) == pytest.approx(film.volume, rel=1e-4)
    # No cap triangle may be turned over, or caps would overlap.
    corner = mesh.vertices.astype(float)[mesh.triangles]
    cap = np.all(corner[:, :, 1] == 0, axis=1)
    normal = np.cross(corner[cap, 1] - corner[cap, 0], corner[cap, 2] - corner[cap, 0])
    assert np.all(normal[:, 1] < 0)
