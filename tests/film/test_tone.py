"""Tone curve, posterior from coupons, and how far resin levels."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import Groove, ToneCurve, levelling_length, prior_belief, read_process
from mpfcad.film.process.model import Process
from mpfcad.film.process.posterior import PRIOR_MEAN, FillCoupon, calibrate
from mpfcad.film.process.tone import PUBLISHED_LINE, fill_of, log_gradient
from mpfcad.film.process.write import Coupon, write_tone_process

BEF = Groove(0.050, 0.025)
CURVES = st.builds(
    ToneCurve, st.floats(0, 0.2), st.floats(0.5, 2.5), st.floats(0.3, 3.0)
)  # fmt: skip


@given(CURVES)
def test_a_tone_curve_grows_from_0_to_1(curve):
    ratio = np.linspace(curve.dead_zone, 1, 400)
    share = curve.share(ratio)
    assert share[0] == 0 and share[-1] == 1
    assert np.all(np.diff(share) >= 0)
    assert np.all(curve.share(np.linspace(0, curve.dead_zone, 5)) == 0)


@given(CURVES, st.floats(1e-4, 1 - 1e-4))
def test_the_inverse_is_the_inverse(curve, share):
    assert curve.share(curve.aperture_ratio(share)) == pytest.approx(share, rel=1e-9)


def test_without_bend_it_is_the_straight_line():
    ratio = np.linspace(0, 1, 11)
    assert ToneCurve().share(ratio) == pytest.approx(ratio, abs=1e-15)


def test_the_prior_is_the_published_line():
    dead, contrast, gain = PRIOR_MEAN
    curve = ToneCurve(dead, np.exp(contrast), np.exp(gain))
    error = curve.share(PUBLISHED_LINE[:, 0]) - PUBLISHED_LINE[:, 1]
    assert np.sqrt(np.mean(error**2)) < 0.018
    # The straight line lies two deviations off, so the prior covers it.
    belief = prior_belief(1.0)
    straight = np.array([0.0, 0.0, 0.0, 0.0])
    assert np.all(np.abs(straight - belief.mean) < 2.1 * belief.deviation)


def test_the_gradient_is_that_of_the_fill():
    mean, ratio = prior_belief(0.6).mean, np.array([0.03, 0.2, 0.6, 0.95])
    step = 1e-6
    for i in range(4):
        aside = np.eye(4)[i] * step
        slope = np.log(fill_of(mean + aside, ratio) / fill_of(mean - aside, ratio)) / (2 * step)
        assert log_gradient(mean, ratio)[:, i] == pytest.approx(slope, rel=1e-4, abs=1e-6)


def test_posterior_intervals_hold_the_truth_in_95_percent():
    """Truths drawn from the prior, 6 coupons of 3 % scatter: 250 draws, σ of the share 1.4 %."""
    generator = np.random.default_rng(20)
    prior = prior_belief(0.7)
    ratio = np.array([0.03, 0.06, 0.12, 0.25, 0.5, 0.8])
    asked = np.array([0.05, 0.15, 0.4])
    held, width = [], []
    for _ in range(250):
        truth = generator.multivariate_normal(prior.mean, prior.covariance)
        truth[1] = max(truth[1], 0)
        fill = fill_of(truth, ratio) * np.exp(0.03 * generator.standard_normal(6))
        coupons = [FillCoupon(a, f, 1e-3, "c") for a, f in zip(ratio, fill, strict=True) if f < 1]
        found = calibrate(prior, coupons).belief
        error = np.log(found.fill(asked) / fill_of(truth, asked))
        held.append(np.abs(error) < 1.96 * found.log_deviation(asked))
        width.append(found.log_deviation(asked))
    assert np.mean(held, axis=0) == pytest.approx(0.95, abs=0.045)
    assert np.mean(width) < 0.2 * prior.log_deviation(asked).mean()


def test_coupons_that_scatter_widen_the_interval():
    prior, ratio = prior_belief(0.7), np.array([0.05, 0.1, 0.2, 0.4])
    fill = fill_of(prior.mean, ratio)
    wild = fill * np.array([1.3, 0.75, 1.3, 0.75])
    calm, torn = (
        calibrate(prior, [FillCoupon(a, f, 1e-3, "c") for a, f in zip(ratio, fs, strict=True)])
        for fs in (fill, wild)
    )
    assert calm.birge == 1
    assert torn.birge > 5
    assert torn.belief.log_deviation([0.1])[0] > 3 * calm.belief.log_deviation([0.1])[0]


def test_less_resin_from_more_aperture_is_refused():
    swapped = [FillCoupon(0.2, 0.13, 0.01, "c10"), FillCoupon(0.1, 0.277, 0.01, "c20")]
    with pytest.raises(InputError, match="are the ratios swapped") as error:
        calibrate(prior_belief(None), swapped)
    assert "c10: fill 0.13 at aperture_ratio 0.2, but c20 has 0.277 at 0.1" in str(error.value)
    # A little less is scatter.
    near = [FillCoupon(0.2, 0.13, 0.05, "a"), FillCoupon(0.19, 0.135, 0.05, "b")]
    assert calibrate(prior_belief(None), near).belief.transfer_factor > 0


def test_the_dead_zone_stays_below_the_smallest_print():
    """However little the smallest coupon holds: it did print."""
    coupons = [FillCoupon(a, f, 1e-6, "c") for a, f in ((0.05, 1e-5), (0.1, 0.05), (0.2, 0.12))]
    found = calibrate(prior_belief(0.7), coupons, spread=1e-6)
    assert 0.02 < found.belief.mean[1] <= 0.9 * 0.05


def test_a_scaled_belief_is_moved_and_widened():
    before = prior_belief(0.7)
    after = before.scaled(2.0, 0.1)
    assert after.transfer_factor == pytest.approx(1.4)
    assert after.deviation[0] ** 2 == pytest.approx(before.deviation[0] ** 2 + 0.01)
    assert after.deviation[1:] == pytest.approx(before.deviation[1:])


def test_the_curvature_s_interval_is_that_of_the_fill_turned_round():
    process = Process.build_tone(BEF, prior_belief(0.57), "test", solids_fraction=0.5)
    ratio = np.linspace(0.1, 0.5, 9)
    low, high = process.curvature_interval(ratio)
    assert np.all(low < process.curvature(ratio)) and np.all(process.curvature(ratio) < high)
    more = BEF.fill_fraction(low) / process.fill_fraction(ratio)
    assert np.log(more) == pytest.approx(1.96 * process.fill_deviation(ratio), rel=1e-4)


def test_a_process_of_a_tone_curve_goes_both_ways():
    process = Process.build_tone(BEF, prior_belief(0.57), "test", solids_fraction=0.5)
    curvature = np.linspace(45, 79, 50)
    there = process.aperture_ratio_of_curvature(curvature)
    assert process.curvature(there) == pytest.approx(curvature, abs=1e-9)
    # Knots are so dense that straight lines between them are the curve.
    belief = prior_belief(0.57)
    ratio = np.linspace(0.02, 0.7, 999)
    assert process.fill_fraction(ratio) == pytest.approx(
        np.minimum(belief.fill(ratio), 0.5), rel=2e-5
    )
    assert process.fill_fraction_max == 0.5


def test_the_calibration_file_reads_back(tmp_path):
    coupons = [Coupon(0.05, 66.0, "a", 65.5, 66.5), Coupon(0.1, 55.0, "b", 54.8, 55.2)]
    found = write_tone_process(tmp_path / "p.toml", coupons, BEF, prior_belief(None))
    process = read_process(tmp_path / "p.toml", BEF)
    assert process.belief.mean == pytest.approx(found.belief.mean, abs=1e-7)
    assert process.belief.covariance == pytest.approx(found.belief.covariance, rel=1e-3, abs=1e-6)
    half = read_process(tmp_path / "p.toml", Groove(0.025, 0.0125))
    assert half.transfer_factor == pytest.approx(2 * process.transfer_factor)


def test_a_calibration_says_of_its_coupons_scatter_only_what_they_have(tmp_path):
    prior, ratio = prior_belief(0.7), (0.05, 0.1, 0.2)
    for number, factor in enumerate((1.0, 1.3)):
        path = tmp_path / f"{number}.toml"
        fills = fill_of(prior.mean, np.array(ratio)) * np.array([factor, 1 / factor, factor])
        coupons = [
            Coupon(a, float(BEF.curvature_of_fill(f)), "c", *(float(BEF.curvature_of_fill(k * f))
            for k in (1.01, 0.99))) for a, f in zip(ratio, fills, strict=True)
        ]  # fmt: skip
        found = write_tone_process(path, coupons, BEF, prior)
        words = [one for one in read_process(path, BEF).caveats if "scatter" in one]
        assert words == [] if factor == 1.0 else f"{found.birge:.3g} times as wide" in words[0]


def test_coupons_that_are_no_prints_are_refused(tmp_path):
    for coupons, words in (
        ([Coupon(0.1, 55.0, "a")], "expected two or more"),
        ([Coupon(0.1, 80.0, "a"), Coupon(0.2, 50.0, "b")], "a: aperture_ratio 0.1"),
    ):
        with pytest.raises(InputError, match=words):
            write_tone_process(tmp_path / "p.toml", coupons, BEF, prior_belief(None))
        assert not list(tmp_path.iterdir())


RESIN = {"viscosity": 0.4, "surface_tension": 0.03, "contact_angle": 0.2, "time": 10.0}


def test_levelling_grows_with_the_root_of_time_and_drive():
    length = levelling_length(0.12, 0.025, **RESIN)
    assert 0.5 < length < 3
    for change in ({"time": 40.0}, {"viscosity": 0.1}, {"surface_tension": 0.12}):
        assert levelling_length(0.12, 0.025, **{**RESIN, **change}) == pytest.approx(2 * length)
    assert levelling_length(0.12 * 16, 0.025, **RESIN) == pytest.approx(2 * length)
    assert levelling_length(0.12, 0.025, **{**RESIN, "contact_angle": 0.7}) < length


def test_levelling_is_what_the_groove_s_flow_does():
    """The flow of the module's head, solved on a grid: a small ripple decays as the Gauss curve."""
    height, period = 0.0087, 0.4  # mm
    length = levelling_length(height**2 / 0.025**2, 0.025, **{**RESIN, "time": 0.2})
    count, steps = 64, 4000
    z = np.arange(count) * period / count
    area = height**2 * (1 + 1e-3 * np.cos(2 * np.pi * z / period))
    drive = 4 * 0.0351443 / 2 * np.sin(np.pi / 4 - 0.2) * 0.03 / 0.4 * 1000  # mm/s
    dz, dt = period / count, 0.2 / steps
    for _ in range(steps):
        h = np.sqrt(area)
        middle = (h + np.roll(h, -1)) / 2
        flow = -drive * middle**2 * (np.roll(h, -1) - h) / dz
        area = area - dt / dz * (flow - np.roll(flow, 1))
    left = np.ptp(area) / (2e-3 * height**2)
    sigma = length / (2 * (2 * np.log(2)) ** 0.5)
    assert left == pytest.approx(np.exp(-2 * (np.pi * sigma / period) ** 2), rel=0.01)


def test_from_45_degrees_on_nothing_levels():
    with pytest.raises(InputError, match="contact_angle_deg: 50: expected below 45"):
        levelling_length(0.12, 0.025, **{**RESIN, "contact_angle": np.radians(50)})
