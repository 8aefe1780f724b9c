"""Which luminances have no kinks: those that a sheet far enough over the lamps spreads."""

import numpy as np
import pytest
from harness import BARE, CONCAVE, film_file, groove

from mpfcad.backlight import read_stack
from mpfcad.measure import POINTS, contrast_of_curve, fit_curve, light_film
from mpfcad.measure.contrast.basis import SPECTRA
from mpfcad.measure.contrast.blur import _LEAST
from mpfcad.optics.repeat import has_equal_grooves
from mpfcad.optics.solid.mesh import read_film_mesh

EQUAL = [groove(60.0)] * 20
PATTERN = [groove(60.0 + 4 * (i > 9)) for i in range(20)]


def lit(folder, grooves=EQUAL, *, stack="thesis-32in-mpf", thickness=14.0, layers="", **values):
    file = folder / "stack.toml"
    file.write_text(f'extends = "{stack}"\n{layers}')
    return light_film(read_stack(file, thickness, values), film_file(folder / "f.stl", grooves))


@pytest.mark.parametrize(
    ("case", "blurred"),
    [
        ({}, True),
        ({"stack": "thesis-32in-conventional", "grooves": [BARE] * 20}, True),
        ({"extent": "panel", "panel_width_mm": 133.2, "lamp_count": 4}, True),
        # Nothing that scatters, or hardly; sheets on the lamps; a film with a step of its own.
        ({"layers": 'layers = ["clear_plate", "film"]\n'}, False),
        ({"bottom_sheet_sigma": 0.05, "top_sheet_sigma": 0.05}, False),
        ({"thickness": 5.3}, False),
        ({"grooves": PATTERN}, False),
    ],
)
def test_light_is_blurred_by_sheets_over_equal_grooves(tmp_path, case, blurred):
    assert lit(tmp_path, **case).is_blurred == blurred


def test_the_least_blur_leaves_no_wave_more_than_the_widest_spectrum_has():
    frequency = np.linspace(0, 16, 65)
    smooth = [s.density(frequency) for s in SPECTRA if not s.is_rough]
    left = np.exp(-((2 * np.pi * frequency * _LEAST) ** 2))
    assert left == pytest.approx(np.max(smooth, axis=0), abs=1e-12)


ALIKE = [EQUAL, [CONCAVE] * 7, [BARE] * 40]
UNLIKE = [PATTERN, [groove(60.0)] * 19 + [groove(60.2)], [groove(60.0)] * 9 + [BARE]]


@pytest.mark.parametrize(
    ("grooves", "equal"), [*((g, True) for g in ALIKE), *((g, False) for g in UNLIKE)]
)
def test_grooves_are_told_alike(tmp_path, grooves, equal):
    mesh = read_film_mesh(film_file(tmp_path / "film.stl", grooves, base=0.2))
    assert has_equal_grooves(mesh) == equal


def test_a_blurred_curve_has_no_kinks_and_a_narrower_interval():
    position = np.linspace(0, 1, POINTS)
    rng = np.random.default_rng(81)
    wide, narrow = [], []
    for i in range(12):
        noisy = 1 + 0.06 * np.cos(2 * np.pi * position) + 0.03 * rng.standard_normal(POINTS)
        for found, blurred in ((wide, False), (narrow, True)):
            fit = fit_curve(position, noisy, np.full(POINTS, 0.03), blurred=blurred)
            assert any(p.is_rough for p in fit.plausible.priors) != blurred
            found.append(contrast_of_curve(fit, i).half_width)
    assert np.mean(narrow) < 0.9 * np.mean(wide)
