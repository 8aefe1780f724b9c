"""Reflection at a smooth surface: laws that hold for every angle and index."""

import math

import pytest
from harness import compiled
from hypothesis import assume, given
from hypothesis import strategies as st
from oracle import ray as reference_ray

from mpfcad.optics.base.fresnel import fresnel as fresnel_kernel

fresnel = compiled(fresnel_kernel)

index = st.floats(1.0001, 3.0)
cosine = st.floats(1e-4, 1.0)


@given(index)
def test_normal_incidence(n):
    expected = ((n - 1) / (n + 1)) ** 2
    for ratio in (n, 1 / n):
        reflectance, cos_out = fresnel(1.0, ratio)
        assert reflectance == pytest.approx(expected, rel=1e-12, abs=1e-17)
        assert cos_out == 1.0


@given(index)
def test_at_brewster_angle_only_s_is_reflected(n):
    # tan θ = n: r_p = 0 and r_s = (1-n²)/(1+n²), so R = r_s²/2.
    reflectance, _ = fresnel(math.cos(math.atan(n)), 1 / n)
    assert reflectance == pytest.approx(((1 - n * n) / (1 + n * n)) ** 2 / 2, rel=1e-9, abs=1e-16)


@given(st.floats(1.01, 3.0), st.floats(1e-6, 1.0))
def test_total_reflection_begins_at_the_critical_angle(n, share):
    critical = math.asin(1 / n)
    beyond = critical + share * (math.pi / 2 - critical)
    assert fresnel(math.cos(beyond), n) == (1.0, 0.0)
    below = critical * (1 - 1e-6)
    assert fresnel(math.cos(below), n)[0] < 1.0


@given(index, cosine)
def test_snell_and_reciprocity(n, cos_in):
    reflectance, cos_out = fresnel(cos_in, 1 / n)
    assert 0.0 <= reflectance <= 1.0
    assert math.sqrt(1 - cos_out**2) * n == pytest.approx(math.sqrt(1 - cos_in**2), abs=1e-7)
    back, cos_back = fresnel(cos_out, n)
    assert cos_back == pytest.approx(cos_in, rel=1e-5)
    assert back == pytest.approx(reflectance, rel=1e-4, abs=1e-12)


@given(st.floats(0.3, 3.0), st.floats(1e-3, 0.9999))
def test_equals_the_oracle_that_works_with_angles(ratio, cos_in):
    assume(abs(ratio - 1) > 1e-6)
    assert fresnel(cos_in, ratio)[0] == pytest.approx(
        reference_ray.reflectance(cos_in, ratio, 1.0), rel=1e-6, abs=1e-14
    )


@given(cosine)
def test_equal_media_do_not_reflect(cos_in):
    reflectance, cos_out = fresnel(cos_in, 1.0)
    assert reflectance == pytest.approx(0.0, abs=1e-15)
    assert cos_out == pytest.approx(cos_in, rel=1e-7)
