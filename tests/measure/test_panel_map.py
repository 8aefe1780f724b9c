"""A finite panel's map, flux and picture."""

import numpy as np
import pytest
from harness import film_file, groove, within

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.measure import (
    TraceRun,
    camera_image,
    light_film,
    output_flux,
    panel_luminance,
    rounds,
)

SMALL = {
    "extent": "panel",
    "panel_width_mm": 66.0,
    "panel_length_mm": 80.0,
    "lamp_count": 2,
    "lamp_length_mm": 70.0,
    "wall_reflectance": 0.9,
    "wall_specular_fraction": 0.0,
}


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    return film_file(tmp_path_factory.mktemp("film") / "film.stl", [groove(60.0)] * 20, base=0.2)


@pytest.fixture
def small(mesh, monkeypatch):
    monkeypatch.setattr(rounds, "LEAST_PATHS", 60_000)
    return lambda **more: light_film(read_stack("thesis-32in-mpf", overrides=SMALL | more), mesh)


def test_flux_of_a_finite_panel_is_the_same_both_ways(small):
    lit = small(lamp_1_luminance_factor=0.5)
    flux = output_flux(lit, TraceRun(seed=31), 0.006)
    assert abs(flux.disagreement) < 3
    # 1.5 lamps of 70 mm: π L · 2π r · l; over 66 × 80 mm.
    emitted = 1.5 * np.pi * lit.stack["lamp_luminance_cd_m2"] * 2 * np.pi * 1.7e-3 * 70e-3
    assert flux.flux.value == pytest.approx(flux.efficiency.value * emitted)
    assert flux.exitance.value == pytest.approx(flux.flux.value / (66e-3 * 80e-3))


def test_corners_are_alike_and_dimmer_than_the_middle(small):
    found = panel_luminance(small(), TraceRun(seed=32), 0.05)
    assert found.luminance.shape == (8, 24)
    assert found.across == pytest.approx((np.arange(8) + 0.5) * 8.25)
    assert found.along[[0, -1]] == pytest.approx([80 / 48, 80 - 80 / 48])
    for corner in found.corner:
        assert corner.high < 1
        # Mirror symmetry: each against the first, 4 sigma.
        error = np.hypot(corner.standard_error, found.corner[0].standard_error)
        within(corner.value, found.corner[0].value, error, 4)


def test_the_side_of_a_dim_lamp_is_dimmer(small):
    found = panel_luminance(small(lamp_1_luminance_factor=0.3), TraceRun(seed=33), 0.05)
    left, right = found.luminance[:4].mean(), found.luminance[4:].mean()
    assert left < 0.9 * right


def test_a_finite_picture_changes_along_the_lamps(small):
    # The panel is smaller than the picture: black beside it.
    image = camera_image(small(), TraceRun(seed=34, path_limit=1), 1.0)
    assert image.luminance.shape == (200, 20) and image.picture.shape == (200, 200)
    assert image.luminance[100, 10] > 0
    assert (image.luminance[:, [0, -1]] == 0).all() and (image.luminance[[0, -1]] == 0).all()


def test_a_stack_without_end_has_no_corners(mesh):
    lit = light_film(read_stack("thesis-32in-mpf"), mesh)
    with pytest.raises(InputError, match="extent: pitch: expected panel"):
        panel_luminance(lit, TraceRun(), 0.1)
