"""Periods that are proposed: the mask that is made of them keeps the rules, and ripples as told."""

import numpy as np
import pytest

from mpfcad.film import Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask
from mpfcad.mask.pattern.levelling import levelling_residual
from mpfcad.pipeline.plan.printed.fit import fit_dots, fit_slots

WIDE = Groove(0.150, 0.075)
LIMIT = (0.056, 0.056)


@pytest.mark.parametrize("pattern", ["slot", "dot"])
@pytest.mark.parametrize("levelling", [0.1, 0.3])
def test_a_fitted_period_is_one_that_can_be_made(pattern, levelling):
    process = read_process(None, WIDE)
    ratio = (0.15, 0.25)
    fit = (
        fit_slots(ratio, LIMIT, levelling)
        if pattern == "slot"
        else fit_dots(ratio, LIMIT, WIDE.pitch, levelling)
    )
    curvature = process.curvature(np.array(ratio))
    rules = MaskRules(pattern, fit.period, *LIMIT, levelling_length=levelling)
    for i in (0, 1):
        film = PrismFilm(WIDE, 0.2, 100 * fit.period, "filled", np.full(6, curvature[i]))
        mask = build_mask(film, process, rules, "m")  # refuses what breaks the rules
        found = levelling_residual(mask)
        assert found.groove_ratio[0] == pytest.approx(ratio[i], rel=1e-3)
        assert found.groove_rms[0] == pytest.approx(fit.residual[i], rel=0.05, abs=1e-5)
    assert fit.aperture >= LIMIT[0] and fit.web >= LIMIT[1]


def test_dots_need_a_groove_that_is_two_cells_wide():
    assert fit_dots((0.1, 0.3), LIMIT, 0.050, 1.0) is None
    assert fit_dots((0.1, 0.9), LIMIT, 0.150, 1.0) is None
    assert fit_slots((0.1, 1.0), LIMIT, 1.0) is None
