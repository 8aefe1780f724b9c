"""What is no groove is said or refused by what the fit leaves of its mean shape."""

import numpy as np
import pytest
from simulated_trace import simulate

from mpfcad.errors import InputError
from mpfcad.film import Groove, StylusTip, StylusTrace, fit_stylus_trace

BEF = Groove(0.050, 0.025)
X = np.arange(0.0, 0.3, 2.5e-4)
SINE = np.sin(2 * np.pi * X / BEF.pitch)
NOISE = np.random.default_rng(4).normal(0, 3e-5, len(X))


@pytest.mark.parametrize("amplitude", [12.5e-3, 5e-3, 1e-3, 3e-4])
def test_a_sine_is_no_groove(amplitude):
    """The smallest is what a trace along the groove shows of the screen's threads."""
    trace = StylusTrace(X, amplitude * SINE + NOISE, "t.csv", StylusTip(0.0))
    with pytest.raises(InputError, match=r"t\.csv: z_um: the grooves' mean shape .* expected"):
        fit_stylus_trace(trace, BEF)


@pytest.mark.slow
def test_a_sine_that_a_large_tip_could_have_drawn_is_said():
    """A ball of 12.5 µm over a covered groove looks much like it: 3 % of the relief are left."""
    fit = fit_stylus_trace(StylusTrace(X, 5e-3 * SINE + NOISE, "t.csv"), BEF)
    assert any("are these such grooves?" in note for note in fit.notes)


@pytest.mark.parametrize("seed", range(3))
def test_grooves_with_all_faults_are_grooves(seed):
    fit = fit_stylus_trace(simulate(seed).trace, BEF)
    assert not any("mean shape" in note for note in fit.notes)
