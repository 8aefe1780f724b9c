"""Moiré: beats against what a Fourier transform of drawn patterns shows, and what avoids them."""

import numpy as np
import pytest

from mpfcad.mask import MaskRules
from mpfcad.mask.fabric import build_mesh, find_mesh
from mpfcad.mask.pattern.levelling import FULL_WIDTH
from mpfcad.mask.screen.moire import (
    VISIBLE_CONTRAST,
    MoireSetting,
    find_beats,
    gratings,
    pattern_grating,
    suggest,
    worst_contrast,
)
from mpfcad.units import deg

PITCH = 0.050


def beats_of(rules, setting, pitch=PITCH, ratio=0.1):
    return find_beats(gratings(rules, setting, pitch, ratio), setting, rules.levelling_length)


def test_two_gratings_beat_at_the_difference_of_their_frequencies():
    # 200 threads/cm have cells of 50 µm: exactly the prisms'; 196 beat every 1/(20 - 19.6) mm.
    for count, period in ((196, 2.5), (204, 2.5), (198, 5.0)):
        rules = MaskRules("slot", 0.4, 0.01, 0.01, mesh=build_mesh(count, 0.025))
        found = beats_of(rules, MoireSetting(mesh_angle=0.0))
        beat = next(b for b in found if b.pair == ("mesh", "prism"))
        assert beat.period == pytest.approx(period)
        assert beat.order == ((1, 0), (1, 0))
        assert min(beat.direction, np.pi - beat.direction) < 1e-9
        assert beat.is_visible


def test_coincidence_is_no_beat():
    rules = MaskRules("dot", 0.05, 0.01, 0.01, mesh=build_mesh(200, 0.025))
    assert not beats_of(rules, MoireSetting(mesh_angle=0.0))


def test_contrast_is_that_of_a_drawn_product():
    """Dots every 50 µm seen through holes every 52 µm, drawn over 1.3 mm, transformed."""
    n, pitch, cell, hole, ratio = 2600, 0.050, 0.052, 0.026, 0.16
    step = 1.3 / n
    x = (np.arange(n) + 0.5) * step
    dots = np.abs((x % pitch) - pitch / 2) < np.sqrt(ratio) * pitch / 2
    holes = np.abs((x % cell) - cell / 2) < hole / 2
    dots, holes = dots / dots.mean(), holes / holes.mean()
    drawn = 2 * np.abs(np.fft.rfft(dots * holes)[1]) / n  # the beat's period is 1.3 mm
    mesh = build_mesh(10 / cell, cell - hole)
    rules = MaskRules("dot", pitch, 0.01, 0.01, mesh=mesh)
    found = beats_of(rules, MoireSetting(mesh_angle=0.0), pitch, ratio)
    across = [b for b in found if b.pair == ("pattern", "mesh") and b.order == ((1, 0), (1, 0))]
    assert across[0].period == pytest.approx(1.3)
    assert across[0].contrast == pytest.approx(drawn, rel=0.03)
    # The same beat along the grooves fades as the resin levels.
    along = [b for b in found if b.pair == ("pattern", "mesh") and b.order == ((0, 1), (0, 1))]
    fade = np.exp(-2 * (np.pi / FULL_WIDTH / 1.3) ** 2)
    assert along[0].contrast == pytest.approx(fade * across[0].contrast, rel=1e-6)


@pytest.mark.parametrize("pattern", ["dot", "staggered", "angled"])
def test_harmonics_are_those_of_the_lattice(pattern):
    """At every dot of the lattice each harmonic has the same phase."""
    rules = MaskRules(pattern, 0.08, 0.01, 0.01, angle=30 * deg)
    grating = pattern_grating(rules, PITCH, 0.1)
    lean = {"dot": 0.0, "staggered": 0.04, "angled": PITCH * np.tan(30 * deg)}[pattern]
    i, k = np.meshgrid(np.arange(5), np.arange(5))
    dots = np.stack([i * PITCH, i * lean + k * 0.08], axis=-1)
    turns = dots @ grating.frequency.T
    assert np.abs(turns - np.rint(turns)).max() < 1e-9


def test_slots_have_no_harmonic_across():
    grating = pattern_grating(MaskRules("slot", 0.4, 0.01, 0.01), PITCH, 0.1)
    assert grating.amplitude[grating.order[:, 0] != 0].max() < 1e-9


def test_a_closer_eye_sees_finer_beats():
    rules = MaskRules("slot", 1.0, 0.01, 0.01)
    near, far = (MoireSetting(pixel=0.3633, viewing_distance=d) for d in (500.0, 1000.0))
    assert near.shortest == pytest.approx(0.291, abs=1e-3)
    periods = [beat.period for beat in beats_of(rules, near)]
    assert min(periods) < far.shortest
    assert all(beat.period >= far.shortest for beat in beats_of(rules, far))


@pytest.mark.parametrize("pattern", ["dot", "angled", "slot"])
def test_the_suggested_screen_is_better(pattern):
    period = 1.0 if pattern == "slot" else 0.05
    rules = MaskRules(pattern, period, 0.01, 0.01, mesh=find_mesh("180-27"))
    bad = MoireSetting(mesh_angle=0.0, pixel=0.3633)
    before = worst_contrast(rules, bad, PITCH, 0.06)
    assert before > VISIBLE_CONTRAST
    better, turned, worst = suggest(rules, bad, PITCH, 0.06)
    assert worst < VISIBLE_CONTRAST
    assert worst_contrast(better, turned, PITCH, 0.06) == worst
    assert 5 * deg <= turned.mesh_angle <= 40 * deg
