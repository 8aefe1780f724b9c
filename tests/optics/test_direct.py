"""What lamps give directly to the reflector: against quadrature, and the same mean as without."""

import math
from dataclasses import replace

import numpy as np
import pytest
from harness import within
from numba import njit

from mpfcad.optics.bsdf.basis import ring_basis
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.cavity.direct import lamp_view
from mpfcad.optics.cavity.endless import lamp_hit
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import Cavity, Sheet
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source
from mpfcad.store.kernel import kept

OWN = -(2**40)


@kept
@njit
def _view(pitch, position, height, radius, x):
    return lamp_view(pitch, position, height, radius, x)


@kept
@njit
def _seen(pitch, position, height, radius, x, sine):
    """Return the numbers of the lamps met at sines from the vertical, those of no lamp far off."""
    out = np.empty(len(sine), np.int64)
    for i in range(len(sine)):
        dz = math.sqrt(1.0 - sine[i] * sine[i])
        distance, _, number = lamp_hit(x, 0.0, sine[i], dz, pitch, position, height, radius, OWN)
        out[i] = number if distance < math.inf else OWN
    return out


@pytest.mark.parametrize("x", [0.0, 0.3, 7.9, 16.345, -40.0, 1e4])
@pytest.mark.parametrize(
    ("pitch", "height", "radius"), [(32.69, 3.5, 1.7), (4.0, 1.9, 1.9), (5.0, 3.0, 2.4)]
)
def test_the_view_of_the_lamps_is_that_of_many_rays(x, pitch, height, radius):
    sine = (np.arange(400_000) + 0.5) / 200_000 - 1
    share, nearest = _view(pitch, 0.7, height, radius, x)
    seen = np.abs(_seen(pitch, 0.7, height, radius, x, sine) - nearest) <= 1
    # Each end of an angle is off by half a step at most: three lamps have six.
    assert seen.mean() == pytest.approx(share, abs=6 / 400_000)


def cavities(mirrored):
    """Return lamps without end, and the same in a panel of 41 pitches that ends far off."""
    endless = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 1.0, 0.5, 0.8, mirrored)
    half = 20.5 * 32.69
    place = tuple(32.69 * i for i in range(-20, 21))
    panel = Panel(-half, half, -5000.0, 5000.0, place, (1.0,) * 41, 1e4, 1.0, 1.0)
    return endless, replace(endless, panel=panel)


def seen(cavity):
    """Return (luminance, its error, variance a path) over two places."""
    source = Source(EYE, np.linspace(0, 16.0, 3), 1.0, acceptance=0.9)
    t = trace(build_scene([cavity, Sheet(0.3, 1.49, 1.0)]), source, 80, seed=9)
    assert t.radiance_error.max() < 0.003
    return t.radiance, t.radiance_error, (t.score2 / t.paths - t.radiance**2).mean()


@pytest.mark.parametrize("mirrored", [0.0, 0.3, 1.0])
def test_lamps_counted_at_the_reflector_give_what_a_control_variate_gives(mirrored):
    here, there = (seen(cavity) for cavity in cavities(mirrored))
    within(here[0], there[0], np.hypot(here[1], there[1]), 3.5)


def test_both_give_what_lamps_counted_where_met_give_with_less_chance():
    # Over a table as reflector, here a Lambertian one of 0.8, lamps are counted where they are met.
    basis = ring_basis(np.radians([0, 30, 60, 90]), 12)
    value = np.zeros((2, 2, len(basis.azimuths), basis.count))
    value[1] = 0.8 / np.pi
    endless, panel = cavities(0.0)
    met = seen(replace(endless, brdf=BsdfTable("Lambertian", basis, True, value)))
    for other in (seen(endless), seen(panel)):
        within(other[0], met[0], np.hypot(other[1], met[1]), 3.5)
        assert other[2] < 0.9 * met[2]
