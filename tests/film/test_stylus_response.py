"""An instrument that follows late, or rings: found by what no groove is, said, and held."""

import numpy as np
import pytest

from mpfcad.film import Groove, StylusTip, StylusTrace, fit_stylus_trace
from mpfcad.film.stylus.dilated import DilatedGroove

BEF = Groove(0.050, 0.025)
TIP = StylusTip(2e-3)
FINE = 5e-5


def late(z):
    """Return heights of which 6 % follow with a lag of 2 µm."""
    keep, slow = np.exp(-FINE / 2e-3), np.empty_like(z)
    slow[0] = z[0]
    for i in range(1, len(z)):
        slow[i] = keep * slow[i - 1] + (1 - keep) * z[i]
    return 0.94 * z + 0.06 * slow


def ringing(z):
    """Return heights followed by a second-order loop: 2 µm a turn, damping ratio 0.35."""
    rate, position, speed = 2 * np.pi / 2e-3, z[0], 0.0
    out = np.empty_like(z)
    for i, height in enumerate(z):
        speed += FINE * (rate**2 * (height - position) - 2 * 0.35 * rate * speed)
        position += FINE * speed
        out[i] = position
    return out


def read(curvature, respond, *, turned=False, noise=5e-6):
    x = np.arange(-0.02, 0.28, FINE)
    z = DilatedGroove(BEF, "filled", TIP).height((x + 0.013) % 0.05 - 0.025, curvature)
    z = respond(z[::-1])[::-1] if turned else respond(z)
    kept = slice(400, None, 5)
    z = z[kept] + np.random.default_rng(5).normal(0, noise, len(x[kept]))
    return fit_stylus_trace(StylusTrace(x[kept], z, "t.csv", TIP), BEF)


@pytest.mark.parametrize(("respond", "turned"), [(late, False), (late, True), (ringing, False)])
def test_a_response_is_said_and_held(respond, turned):
    """58 read 57.82 ± 0.01, or 58.08 ± 0.01, and nothing was said."""
    fit = read(58.0, respond, turned=turned)
    (words,) = [note for note in fit.notes if "follow the surface late" in note]
    assert "to one side alone" in words
    assert fit.curvature.low <= 58.0 <= fit.curvature.high
    assert fit.fill_fraction.low <= float(BEF.fill_fraction(58.0)) <= fit.fill_fraction.high
    assert fit.curvature.high - fit.curvature.low < 1.0
    # As it was read, it is off by more than noise.
    assert abs(fit.curvature.value - 58.0) > 0.05


@pytest.mark.parametrize("noise", [5e-6, 5e-5])
def test_a_trace_without_one_is_not_said_to_have_one(noise):
    fit = read(58.0, lambda z: z, noise=noise)
    assert not any("late" in note for note in fit.notes)
    assert fit.curvature.high - fit.curvature.low < 0.2
