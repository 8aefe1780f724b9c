"""The mask in memory: aperture ratios, the grid, the period, and grooves that cannot be made."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)
SLOT = MaskRules("slot", 0.400, 0.015, 0.015)
DOT = MaskRules("dot", 0.100, 0.012, 0.012)


def film_of(curvature, length=20.0, groove=BEF, profile="filled"):
    return PrismFilm(groove, 0.2, length, profile, np.asarray(curvature, float))


printable = st.one_of(st.just(80.0), st.floats(20, 63))


@given(st.lists(printable, min_size=1, max_size=30), st.floats(1.0, 700.0))
def test_slots_have_the_wanted_ratio_whatever_the_length(curvature, length):
    mask = build_mask(film_of(curvature, length), PROCESS, SLOT, "job")
    wanted = PROCESS.aperture_ratio_of_curvature(curvature)
    # Half a grid step a period, and half a step of the length.
    assert np.abs(mask.aperture_ratio - wanted).max() < 2e-6 + 1e-6 / length
    assert np.array_equal(mask.wanted_ratio, wanted)
    assert np.all(mask.across[mask.is_open] == 50_000)
    assert mask.aperture_count == np.count_nonzero(wanted) * mask.period_count
    assert np.all(mask.bottom[mask.is_open] >= 0)
    top = mask.bottom + (mask.period_count - 1) * mask.period_steps + mask.along
    assert np.all(top[mask.is_open] <= round(length / 1e-6))


@given(st.lists(st.one_of(st.just(80.0), st.floats(50, 64)), min_size=1, max_size=30))
def test_dots_have_the_wanted_ratio(curvature):
    mask = build_mask(film_of(curvature), PROCESS, DOT, "job")
    wanted = PROCESS.aperture_ratio_of_curvature(curvature)
    assert np.abs(mask.aperture_ratio - wanted).max() < 1e-5
    assert np.array_equal(mask.across, mask.along)


def test_dots_stand_in_the_middle_of_their_groove():
    mask = build_mask(film_of([60.0, 55.0, 60.0]), PROCESS, DOT, "job")
    middle = mask.left + mask.across / 2
    assert np.abs(middle - [25_000, 75_000, 125_000]).max() <= 0.5


def test_slots_of_equal_neighbours_are_continuous():
    mask = build_mask(film_of([60.0] * 4), PROCESS, SLOT, "job")
    assert np.array_equal(mask.left[1:], (mask.left + mask.across)[:-1])
    assert np.ptp(mask.bottom) == 0


def test_a_pitch_off_the_grid_keeps_slots_continuous_and_ratios_right():
    groove = Groove(0.0333333, 0.0166667)
    process = read_process(None, groove)
    film = film_of([70.0] * 1000, groove=groove)
    mask = build_mask(film, process, SLOT, "job")
    assert np.array_equal(mask.left[1:], (mask.left + mask.across)[:-1])
    assert np.abs(mask.aperture_ratio - mask.wanted_ratio).max() < 1e-4
    assert mask.left[-1] + mask.across[-1] == round(film.width / 1e-6)


def test_the_period_is_stretched_to_fill_the_length():
    assert build_mask(film_of([60.0], 697.68), PROCESS, SLOT, "job").period_count == 1744
    mask = build_mask(film_of([60.0], 4.1), PROCESS, SLOT, "job")
    assert (mask.period_count, mask.period) == (10, pytest.approx(0.41))


def test_ratio_0_is_no_aperture():
    mask = build_mask(film_of([80.0, 60.0]), PROCESS, SLOT, "job")
    assert mask.is_open.tolist() == [False, True]
    assert mask.aperture_ratio[0] == 0


def test_the_hash_tells_curvatures_apart():
    one, two, three = (
        build_mask(film_of(c), PROCESS, SLOT, "job").content_hash
        for c in ([60.0], [60.0], [np.nextafter(60.0, 0)])
    )
    assert one == two != three
    assert len(one) == 12


def refused(film, rules, *words, name="job"):
    with pytest.raises(InputError) as error:
        build_mask(film, PROCESS, rules, name)
    text = str(error.value)
    assert "\n" not in text
    for word in words:
        assert word in text


def test_apertures_too_small_name_grooves_and_both_ranges():
    curvature = np.full(700, 60.0)
    curvature[12:41] = 70.0
    curvature[600:613] = 68.0
    # 15 µm of a 400 µm period is ratio 0.0375, fill 0.0468, 63.8 /mm.
    refused(
        film_of(curvature),
        SLOT,
        "grooves 12-40, 600-612: ",
        "0.01362",
        "68 … 70",
        "expected 0 … 63.84 or 80 (no resin; ratio 0.0375 … 0.9625: ",
    )


@pytest.mark.parametrize("curvature", [79.9, 79.95, 79.9999, 80 * (1 - 2e-9)])
@pytest.mark.parametrize("pattern", ["slot", "dot", "blue-noise", "error-diffused"])
def test_what_is_nearly_bare_is_refused_and_not_left_empty(curvature, pattern):
    rules = MaskRules(pattern, 0.4 if pattern == "slot" else 0.1, 0.008, 0.008)
    refused(film_of([60.0, curvature]), rules, "map: groove 1: ")
    mask = build_mask(film_of([60.0, 80.0]), PROCESS, rules, "job")
    assert mask.aperture_ratio[1] == 0


def test_the_stated_range_is_the_one_that_passes():
    limit = PROCESS.curvature(0.015 / 0.4)
    build_mask(film_of([limit - 1e-3]), PROCESS, SLOT, "job")
    refused(film_of([limit + 1e-3]), SLOT, "groove 0: ")


def test_webs_too_small_are_refused():
    tight = MaskRules("slot", 0.400, 0.015, 0.300)
    build_mask(film_of([60.0]), PROCESS, tight, "job")
    refused(film_of([60.0, 20.0]), tight, "groove 1: ", "0.0375 … 0.25", "min_web 300 µm")
    refused(film_of([60.0, 35.0]), DOT, "groove 1: ", "dot period 100 µm", "0.0288 … 0.2888")


def test_narrow_slots_and_webs_across_are_refused():
    wide = MaskRules("slot", 0.400, 0.015, 0.060)
    refused(film_of([60, 80, 60]), wide, "groove 1: webs of 50 µm across", "_um, 60, or more")
    build_mask(film_of([60, 80, 80, 60, 80]), PROCESS, wide, "job")
    refused(film_of([60, 60, 80, 60, 80]), MaskRules("slot", 2.0, 0.06, 0.01), "groove 3: slots")


def test_rules_that_nothing_can_meet_are_refused():
    refused(film_of([60.0]), MaskRules("dot", 0.1, 0.03, 0.03), "no aperture fits")


def test_an_ideal_film_has_no_mask():
    refused(film_of([60.0], profile="ideal"), SLOT, "film.profile: ideal: expected 'filled'")


def test_a_name_that_cannot_be_drawn_is_refused():
    refused(film_of([60.0]), SLOT, "printable ASCII", name="Fläche\n")


def test_what_the_process_cannot_reach_is_refused():
    with pytest.raises(InputError, match=r"film\.curvature\[1\]: 90: expected a finite number"):
        film_of([60.0, 90.0])


def test_a_panel_too_long_for_gdsii_is_refused():
    refused(film_of([60.0], 2200.0), SLOT, "stack.panel_length_mm: 2200")
