"""Contrast without the bias of noise: closed form, coverage of the interval, bias."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.measure import POINTS, contrast_of_curve, fit_curve, fit_harmonics, reach
from mpfcad.measure.contrast import draws

POSITION = np.linspace(0, 1, POINTS)


def cosine(u):
    return np.cos(2 * np.pi * u)


def lopsided(u):
    return cosine(u) + 0.5 * np.cos(4 * np.pi * u + 0.7) + 0.25 * np.sin(6 * np.pi * u)


def curve(shape, contrast, mean=1.0):
    """Return the luminances at the points of a curve with the given true contrast."""
    fine = shape(np.linspace(0, 1, 20_001))
    high, low = fine.max(), fine.min()
    factor = 2 * contrast / ((high - low) - contrast * (high + low))
    return mean * (1 + factor * shape(POSITION))


def naive(luminance):
    return (luminance.max() - luminance.min()) / (luminance.max() + luminance.min())


@given(
    contrast=st.floats(0.001, 0.5), mean=st.floats(10.0, 1e5),
    phase=st.floats(0, 1), shape=st.sampled_from([cosine, lopsided]),
)  # fmt: skip
def test_a_curve_without_noise_gives_its_closed_form(contrast, mean, phase, shape):
    luminance = curve(lambda u: shape(u + phase), contrast, mean)
    fit = fit_curve(POSITION, luminance, np.full(POINTS, 1e-9 * mean))
    estimate = contrast_of_curve(fit)
    # The curve is read at 129 places: 2% of the extremes' curvature is missed at most.
    assert estimate.value == pytest.approx(contrast, rel=3e-3)
    assert estimate.low <= estimate.value <= estimate.high
    assert fit.mean().value == pytest.approx(mean, rel=1e-5)


def test_a_flat_curve_without_noise_has_no_contrast():
    fit = fit_curve(POSITION, np.full(POINTS, 7000.0), np.full(POINTS, 1e-6))
    # Errors count as 1e-5 of the luminance at least.
    assert contrast_of_curve(fit).value < 1e-5


def simulated(shape, contrast, sigma, count, seed, *, blurred=True):
    """Return (low, high, value, naive contrast) of noisy curves, (count, 4)."""
    rng = np.random.default_rng(seed)
    truth = curve(shape, contrast)
    rows = []
    for i in range(count):
        noisy = truth + sigma * rng.standard_normal(POINTS)
        fit = fit_curve(POSITION, noisy, np.full(POINTS, sigma), blurred=blurred)
        estimate = contrast_of_curve(fit, i)
        rows.append((estimate.low, estimate.high, estimate.value, naive(noisy)))
    return np.array(rows)


def covered(rows, contrast):
    return np.mean((rows[:, 0] <= contrast) & (contrast <= rows[:, 1]))


CASES = [
    (cosine, 0.005, 0.002),
    (cosine, 0.015, 0.003),
    (cosine, 0.012, 0.0015),
    (lopsided, 0.005, 0.002),
    (lopsided, 0.015, 0.003),
    (lopsided, 0.030, 0.001),
]


def check_share(share, count, most=0.97, least=0.93):
    """Assert that the share is `least` … `most`; a count of it scatters: 2.5 binomial sigma."""
    print(f"{share:.4f} of {count}")
    assert share >= least - 2.5 * np.sqrt(least * (1 - least) / count)
    assert share <= most + 2.5 * np.sqrt(most * (1 - most) / count)


def check(shape, contrast, sigma, count):
    rows = simulated(shape, contrast, sigma, count, seed=71)
    # A wave of a few errors might as well be flat where it is highest, so its interval holds more;
    # of three harmonics the higher ones are lost in the noise, and with them some of the contrast.
    most, least = (0.97, 0.93) if contrast > 3 * sigma else (0.98, 0.915)
    check_share(covered(rows, contrast), count, most, least)
    # Bias of the median below 0.15 of a point's error (3σ of the median: 1.25 · 0.35/√count) …
    slack = 3 * 1.25 * 0.35 / np.sqrt(count)
    assert abs(np.median(rows[:, 2]) - contrast) <= (0.15 + slack) * sigma
    # … where the plain maximum and minimum of the points overstate it.
    assert np.median(rows[:, 3]) - contrast > 0.4 * sigma


@pytest.mark.parametrize(("shape", "contrast", "sigma"), [CASES[0], CASES[4]])
def test_the_interval_holds_the_truth_as_often_as_it_says(shape, contrast, sigma):
    check(shape, contrast, sigma, 80)


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "contrast", "sigma"), CASES)
def test_the_interval_holds_the_truth_over_many_curves(shape, contrast, sigma):
    check(shape, contrast, sigma, 1000)


def peaks(number):
    return lambda u: np.cos(2 * np.pi * number * u)


def plateaus(edge, floor):
    """Return flat tops and floors with edges; the larger `floor`, the longer the top."""
    return lambda u: np.tanh(edge * (cosine(u) + floor))


#: Several places are as high, or a whole stretch is. Noise reads them too high alone, so intervals
#: miss on one side only.
RIVALS = [
    (peaks(2), 0.01, 0.003),
    (peaks(4), 0.1, 0.003),
    (plateaus(3, 0.3), 0.01, 0.003),
    (plateaus(3, 0.3), 0.05, 0.003),
    (plateaus(6, 0.6), 0.05, 0.003),
    (plateaus(6, 0.0), 0.3, 0.003),
    (plateaus(20, 0.3), 0.3, 0.003),
]


def check_rivals(shape, contrast, sigma, count):
    rows = simulated(shape, contrast, sigma, count, seed=78, blurred=False)
    # At the points: between them a steep edge is not told.
    share = covered(rows, naive(curve(shape, contrast)))
    check_share(share, count, 0.985)
    assert np.mean(rows[:, 1] < contrast) < 0.01


def test_flat_tops_in_noise_are_not_taken_for_waves():
    check_rivals(*RIVALS[2], 80)


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "contrast", "sigma"), RIVALS)
def test_many_curves_whose_highest_places_are_alike(shape, contrast, sigma):
    check_rivals(shape, contrast, sigma, 400)


def decay(length, lamp=0.0):
    """Return the light of one lamp: a pointed top above it."""
    return lambda u: np.exp(-np.abs(u - lamp) / length)


def bell(u):
    """Return the light of a lamp in a white cavity."""
    return 1 / (1 + (u / 0.35) ** 2)


def unequal(u):
    """Return two pitches' lamps, one dimmed."""
    lamps = zip((1, 0.9, 1, 1), (-1, 0, 1, 2), strict=True)
    return sum(luminance / (1 + ((u - place) / 0.35) ** 2) for luminance, place in lamps)


#: A window of a panel: pointed and round tops, at its end and within.
WINDOWS = [
    (decay(0.4), 0.82, 0.003),
    (decay(0.4), 0.82, 0.01),
    (decay(0.4, 0.5), 0.57, 0.003),
    (decay(0.4, 0.31), 0.57, 0.01),
    (decay(0.7, 0.5), 0.35, 0.003),
    (decay(1.0, 0.31), 0.14, 0.01),
    (decay(1.0, 0.31), 0.03, 0.003),
    (bell, 0.5, 0.01),
    (unequal, 0.02, 0.003),
    (unequal, 0.1, 0.01),
]


def check_window(shape, contrast, sigma, count):
    rng = np.random.default_rng(80)
    truth = curve(shape, contrast)
    truth /= truth.mean()
    held = 0
    for i in range(count):
        noisy = truth + sigma * rng.standard_normal(POINTS)
        fit = fit_curve(POSITION, noisy, np.full(POINTS, sigma), periodic=False)
        found = contrast_of_curve(fit, i)
        held += found.low <= naive(truth) <= found.high
    # Where one lamp's top is all that is high, noise hardly makes it higher: 98 % are held.
    check_share(held / count, count, 0.98)


@pytest.mark.parametrize("number", [3, 5])
def test_a_pointed_top_is_not_smoothed_away(number):
    check_window(*WINDOWS[number], 80)


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "contrast", "sigma"), WINDOWS)
def test_many_windows_of_a_panel(shape, contrast, sigma):
    check_window(shape, contrast, sigma, 400)


@pytest.mark.parametrize(("shape", "rivals"), [(cosine, False), (peaks(4), True)])
def test_only_rivals_of_the_highest_place_lower_the_low_end(monkeypatch, shape, rivals):
    noisy = curve(shape, 0.05) + 0.003 * np.random.default_rng(79).standard_normal(POINTS)
    fit = fit_curve(POSITION, noisy, np.full(POINTS, 0.003))
    found = contrast_of_curve(fit)
    monkeypatch.setattr(draws, "_ALIKE", 0.0)
    plain = contrast_of_curve(fit)
    assert found.value == plain.value
    assert found.low <= plain.low and found.high <= plain.high
    assert (found.low < plain.low - 0.2 * plain.half_width) == rivals


def test_a_flat_noisy_curve_is_compatible_with_no_contrast():
    sigma = 0.005
    rows = simulated(cosine, 0.0, sigma, 80, seed=72)
    assert covered(rows, 0.0) >= 0.95 - 2.5 * np.sqrt(0.95 * 0.05 / 80)
    assert np.median(rows[:, 2]) <= 0.15 * sigma
    # 2.08 sigma for 33 points of a flat curve: the expected range of 33 normal numbers over 2.
    assert np.mean(rows[:, 3]) == pytest.approx(2.08 * sigma, rel=0.06)


def test_same_noise_same_result():
    rows = [simulated(cosine, 0.01, 0.003, 3, seed=73) for _ in range(2)]
    assert np.array_equal(*rows)


def test_sharp_features_get_more_harmonics():
    def narrow(u):
        return np.exp(-(((u + 0.5) % 1 - 0.5) ** 2) / (2 * 0.05**2))

    error = np.full(POINTS, 1e-4)
    sharp = fit_harmonics(POSITION, curve(narrow, 0.05), error)
    smooth = fit_harmonics(POSITION, curve(cosine, 0.05), error)
    assert smooth.harmonics == 4 < sharp.harmonics
    found = contrast_of_curve(fit_curve(POSITION, curve(narrow, 0.05), error))
    assert found.value == pytest.approx(0.05, rel=0.02)


def test_the_fit_is_the_weighted_one():
    # A point of tenfold error must hardly pull: the same curve, one point far off.
    error = np.full(POINTS, 0.001)
    luminance = curve(cosine, 0.02)
    luminance[7] += 0.05
    error[7] = 1.0
    fit = fit_harmonics(POSITION, luminance, error)
    assert np.abs(fit.curve(POSITION) - curve(cosine, 0.02)).max() < 1e-4


def test_mean_and_its_error():
    rng = np.random.default_rng(74)
    fits = [
        fit_harmonics(POSITION, 100 + rng.standard_normal(POINTS), np.ones(POINTS))
        for _ in range(500)
    ]
    means = np.array([fit.coefficient[0] for fit in fits])
    error = np.sqrt(fits[0].covariance[0, 0])
    # Standard deviation from 500 values: known to 1/√1000; 4 sigma.
    assert means.std() / error == pytest.approx(1, abs=4 / np.sqrt(1000))


def test_a_curve_read_flatter_than_its_noise_allows_is_no_proof_of_flatness():
    # Exactly flat by chance: the interval must not end at 0 (and stop a trace after one round).
    error = 0.01
    estimate = contrast_of_curve(fit_curve(POSITION, np.ones(POINTS), np.full(POINTS, error)))
    # An amplitude's error is 0.01 √(2/33) = 0.0025.
    assert estimate.value == estimate.low == 0
    assert 0.0025 < estimate.high < 0.02


def test_an_interval_widens_by_students_t_where_errors_are_uncertain():
    # Errors of 33 points from 2 blocks are known to about 30 degrees, those of one to 17.
    luminance, error = curve(cosine, 0.02), np.full(POINTS, 0.001)
    known, few, many = (
        contrast_of_curve(fit_curve(POSITION, luminance, error, blocks))
        for blocks in (np.inf, 2, 240)
    )
    # The ends of 2000 draws are themselves known to 3 % of the half-width.
    assert few.half_width / known.half_width == pytest.approx(reach(30) / reach(), abs=0.03)
    assert many.half_width == pytest.approx(known.half_width, rel=0.01)


def test_uncertain_errors_do_not_ask_for_more_harmonics():
    # All points' errors alike too small or large, as two blocks read them: 33 degrees of freedom.
    rng = np.random.default_rng(75)
    more = {2: 0, np.inf: 0}
    for _ in range(600):
        noisy = 1 + 0.01 * rng.standard_normal(POINTS)
        error = np.full(POINTS, 0.01 * np.sqrt(rng.chisquare(POINTS) / POINTS))
        for blocks in more:
            more[blocks] += fit_harmonics(POSITION, noisy, error, blocks).harmonics > 4
    # 0.6 % of 600 are 4 ± 2; taken as known, errors ask for more ten times as often.
    assert more[2] <= 10 < 20 < more[np.inf]


def slope(u):
    """Return a window of a finite panel: no period."""
    return u + 0.6 * cosine(u)


def cusps(u):
    """Return lamps seen straight through a film without sheets: steps and kinks."""
    near = np.abs((u + 0.5) % 1 - 0.5)
    return 1 - 1.3 * near + 0.8 * (near > 0.25) * (near < 0.4)


SHARP = [(slope, 0.018, 0.003), (slope, 0.85, 0.01), (cusps, 0.27, 0.006)]


def check_without_period(shape, contrast, sigma, count):
    rng = np.random.default_rng(76)
    # The contrast of 33 points: between them a curve with steps is not told.
    points = shape(POSITION)
    high, low = points.max(), points.min()
    truth = 1 + 2 * contrast / ((high - low) - contrast * (high + low)) * points
    held = widened = 0
    for i in range(count):
        noisy = truth + sigma * truth.mean() * rng.standard_normal(POINTS)
        error = np.full(POINTS, sigma * truth.mean())
        fit = fit_curve(POSITION, noisy, error, periodic=shape is cusps)
        widened += fit.misfit > 1
        found = contrast_of_curve(fit, i, points=POINTS)
        held += found.low <= contrast <= found.high
    assert held / count >= 0.93 - 2.5 * np.sqrt(0.93 * 0.07 / count)
    assert widened <= 4  # noise alone widens 1 in 1000: 0.6 of 600


@pytest.mark.parametrize(("shape", "contrast", "sigma"), SHARP)
def test_curves_without_period_or_with_steps(shape, contrast, sigma):
    check_without_period(shape, contrast, sigma, 60)


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "contrast", "sigma"), SHARP)
def test_many_curves_without_period_or_with_steps(shape, contrast, sigma):
    check_without_period(shape, contrast, sigma, 600)


def test_a_step_is_not_smoothed_and_a_period_is_not_made_up():
    error = np.full(POINTS, 0.002)
    assert fit_curve(POSITION, curve(cusps, 0.3), error).is_sharp
    smooth = fit_curve(POSITION, curve(slope, 0.1), error, periodic=False)
    assert not smooth.is_sharp
    # A slope of one pitch: with harmonics its ends would meet.
    ends = smooth.at(0.0).value - smooth.at(1.0).value
    assert ends == pytest.approx(curve(slope, 0.1)[0] - curve(slope, 0.1)[-1], abs=4 * 0.002)


def test_over_many_pitches_the_worst_counts_and_what_repeats_is_shared():
    position = np.linspace(-2, 3, 161)
    truth = 1 + 0.005 * cosine(position) - 0.03 * np.exp(-(((position - 1) / 0.8) ** 2))
    rng = np.random.default_rng(77)
    sigma = 0.006
    fit = fit_curve(
        position, truth + sigma * rng.standard_normal(161), np.full(161, sigma), periodic=False
    )
    window = [truth[32 * i : 32 * i + 33] for i in range(5)]
    wanted = max(naive(one) for one in window)
    found = contrast_of_curve(fit)
    assert found.low <= wanted <= found.high
    # Each pitch on its own would have ± 0.0045.
    assert found.half_width < 0.0045
    assert not fit.is_sharp


def test_misfit_widens_the_interval():
    error = np.full(POINTS, 0.001)
    fit = fit_curve(POSITION, curve(cosine, 0.03), error)
    assert fit.misfit == 1
    wide = contrast_of_curve(replace(fit, misfit=2.0))
    assert wide.half_width == pytest.approx(2 * contrast_of_curve(fit).half_width, rel=0.15)
