"""Stylus traces: known curvatures recovered within their intervals; what is refused."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import (
    Coupon,
    Groove,
    StylusTip,
    StylusTrace,
    fit_stylus_trace,
    read_process,
    read_stylus_trace,
    write_process,
)

BEF = Groove(0.050, 0.025)
SHARP = StylusTip(0.0)


def trace(
    curvature, *, noise=1e-4, tilt=0.03, centre=0.011, length=0.125, seed=1, profile="filled"
):
    """Return a trace as a profiler would give it, with heights off by `noise` [mm] rms."""
    x = np.arange(0.0, length, 2e-4)
    local = (x - centre + BEF.half_width) % BEF.pitch - BEF.half_width
    z = BEF.height(local, curvature, profile) + tilt * x - 0.7
    return StylusTrace(
        x + 3.0, z + np.random.default_rng(seed).normal(0, noise, x.size), "t.csv", SHARP
    )


@settings(max_examples=15)
@given(
    curvature=st.floats(2.0, 79.0),
    tilt=st.floats(-0.2, 0.2),
    centre=st.floats(-0.05, 0.05),
    length=st.floats(0.1002, 0.1998),
)
def test_without_noise_both_curvatures_are_exact(curvature, tilt, centre, length):
    fit = fit_stylus_trace(
        trace(curvature, noise=0.0, tilt=tilt, centre=centre, length=length), BEF
    )
    # A flat meniscus hardly shows whether it is round: the priors of that move C by this much.
    assert fit.curvature.value == pytest.approx(curvature, abs=1e-5 + 3e-3 / curvature)
    # A sum over 500 points, not the integral.
    expected = BEF.fitted_curvature(curvature)
    assert fit.fitted_curvature.value == pytest.approx(expected, abs=0.01)
    assert fit.tilt == pytest.approx(tilt, abs=5e-7)
    off = (fit.centre - 3.0 - centre + BEF.half_width) % BEF.pitch - BEF.half_width
    assert abs(off) < 5e-7


def test_intervals_hold_the_truth_as_often_as_they_say():
    """Of 30 traces 28.5 ± 1.2 should: 24 is 3.8 standard deviations away.

    Both readings of a scale that noise alone puts off are in the interval: it may hold all.
    """
    curvatures = np.random.default_rng(5).uniform(5, 75, 30)
    held = np.zeros(2)
    for seed, curvature in enumerate(curvatures):
        fit = fit_stylus_trace(trace(curvature, seed=seed), BEF)
        fitted = float(BEF.fitted_curvature(curvature))
        held += [
            fit.curvature.low <= curvature <= fit.curvature.high,
            fit.fitted_curvature.low <= fitted <= fit.fitted_curvature.high,
        ]
    assert np.all(held >= 24)


def test_correlated_noise_widens_the_interval():
    """A running mean over 20 points: each independent error now counts 20 times."""
    rough = trace(57.0, noise=0.0, length=0.3)
    noise = np.random.default_rng(2).normal(0, 4.5e-4, len(rough.height) + 19)
    noise = np.convolve(noise, np.ones(20) / 20, "valid")
    wavy = fit_stylus_trace(StylusTrace(rough.position, rough.height + noise, "wavy", SHARP), BEF)
    white = fit_stylus_trace(trace(57.0, length=0.3), BEF)
    assert wavy.residual_rms == pytest.approx(white.residual_rms, rel=0.25)
    # The waviness that is sought takes some of it away.
    assert wavy.curvature.high - wavy.curvature.low > 2 * (
        white.curvature.high - white.curvature.low
    )
    assert wavy.curvature.low <= 57.0 <= wavy.curvature.high


def test_residual_is_the_noise():
    fit = fit_stylus_trace(trace(57.0), BEF)
    assert fit.residual_rms == pytest.approx(1e-4, rel=0.1)
    # The parabola leaves what the bare walls add.
    assert fit.fitted_residual_rms > 3 * fit.residual_rms


def test_ideal_profile_has_one_curvature():
    fit = fit_stylus_trace(trace(120.0, profile="ideal"), BEF, "ideal")
    assert fit.curvature.low <= 120.0 <= fit.curvature.high
    assert fit.fitted_curvature.value == pytest.approx(fit.curvature.value, abs=0.01)


def test_interval_stays_in_range():
    fit = fit_stylus_trace(trace(80.0, noise=2e-4), BEF)
    assert fit.curvature.high <= 80.0 * 1.005  # of a groove as steep as this one reads
    assert fit.curvature.low > 70


@pytest.mark.parametrize("relief", ["pitch", "flat"])
def test_what_is_no_such_groove_is_refused(relief):
    other = trace(60.0)
    if relief == "pitch":
        other = StylusTrace((other.position - 3) * 1.4, other.height, "t.csv")
    else:
        z = np.random.default_rng(3).normal(0, 1e-4, len(other.height))
        other = StylusTrace(other.position, z, "t.csv")
    with pytest.raises(InputError, match=r"t.csv: z_um: residual .* pitch 50 µm"):
        fit_stylus_trace(other, BEF)


def rows(x, z):
    return "".join(f"{a!r},{b!r}\n" for a, b in zip(x.tolist(), z.tolist(), strict=True))


GOOD = np.arange(0.0, 101.0, 1.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x,z\n1,2\n", ("1 rows", "40 or more")),
        ("x_um,z_um\n", ("row 1", "no rows of numbers")),
        ("x_um,z_um\n1,2\n2,3\n3,5\n1,a\n", ("row 5", "'1,a'", "2 numbers")),
        ("x_um,z_um\n0,1\n1,-1e308\n2,1\n", ("row 3", "height -1e+308", "within ± 1e+15")),
        ("x_um,z_um\n0,1\n1e30,2\n2e30,1\n", ("row 3", "position 1e+30")),
        ("x_um,z_um\n0,1\n1,2\n0.5,2\n2,1\n", ("row 4", "0.5", "not increasing", "row 3")),
        ("x_um,z_um\n" + rows(GOOD * 0.5, GOOD), ("50 µm long", "100 µm")),
        ("x_um,z_um\n" + rows(np.r_[GOOD[:50], GOOD[60:]], GOOD[:91]), ("gap of 11 µm", "row 52")),
    ],
)
def test_bad_files_are_refused(tmp_path, text, words):
    path = tmp_path / "trace.csv"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_stylus_trace(path, BEF)
    for word in ("trace.csv", *words):
        assert word in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_stylus_trace(tmp_path / "none.csv", BEF)


def test_calibration_is_read_back(tmp_path):
    path = tmp_path / "process.toml"
    coupons = [Coupon(0.10, 54.0, "b"), Coupon(0.05, 66.0, "a"), Coupon(0.10, 56.0, "c")]
    write_process(path, coupons, BEF)
    process = read_process(path, BEF)
    assert process.kind == "table"
    assert process.curvature([0.05, 0.10]) == pytest.approx([66.0, 55.0], abs=1e-6)
    assert "stylus traces a, b, c" in process.source
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("coupons", "words"),
    [
        ([Coupon(0.1, 55.0, "a")], "expected two or more different"),
        ([Coupon(0.1, 55.0, "a"), Coupon(0.2, 60.0, "b")], "p.toml: row 2: fill_fraction"),
    ],
)
def test_coupons_that_make_no_calibration(tmp_path, coupons, words):
    with pytest.raises(InputError, match=words):
        write_process(tmp_path / "p.toml", coupons, BEF)
    assert list(tmp_path.iterdir()) == []
