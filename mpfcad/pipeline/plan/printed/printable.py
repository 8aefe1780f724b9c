"""The curvatures that a screen prints: process, smallest features, the band of ratios, ripple."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import Process
from mpfcad.job.model import GateTable
from mpfcad.mask.rule import MaskRules, ratio_range
from mpfcad.mask.screen.printing import LUMINANCE_RESPONSE, curvature_ripple
from mpfcad.mask.screen.slot_ripple import slot_ripple
from mpfcad.units import um

#: Share of the printable range of aperture ratio left to the rounding of the mask.
_RATIO_MARGIN = 0.01
#: Ratios at which the ripple is looked at.
_RATIOS = 400


def printable_range(
    process: Process, rules: MaskRules, gates: GateTable, where: str
) -> tuple[float, float]:
    """Return the smallest and largest C [1/mm] that are printed; the empty groove prints too.

    Through a mesh the gates' band of ratios and, for slots, their ripple after levelling count too.

    Raises
    ------
    InputError
        when nothing is left.
    """
    low, high = ratio_range(rules, process.groove.pitch, rules.period, where)
    if rules.mesh is not None:
        low, high = max(low, gates.ratio_min), min(high, gates.ratio_max)
    low, high = low * (1 + _RATIO_MARGIN), high * (1 - _RATIO_MARGIN)
    high = min(high, process.aperture_ratio_max)
    if rules.mesh is not None and rules.pattern == "slot" and low < high:
        low, high = _smooth(process, rules, gates, np.geomspace(low, high, _RATIOS), where)
    if low >= high:
        asked = rules.describe(rules.period)
        raise InputError(
            f"{where}: mask.period_um: {rules.period / um:g}: no aperture ratio is printed "
            f"({asked}; smallest {low:.4g}, largest {high:.4g}): expected a longer period, a finer "
            f"mask.mesh, or another process.solids_fraction"
        )
    return float(process.curvature(high)), float(process.curvature(low))


def _smooth(
    process: Process,
    rules: MaskRules,
    gates: GateTable,
    ratio: NDArray[np.float64],
    where: str,
) -> tuple[float, float]:
    """Return the ends of the ratios whose ripple the gates let through."""
    residual = slot_ripple(ratio, rules.period, rules.levelling_length)
    ripple = curvature_ripple(process, ratio, residual)
    passed = (ripple <= gates.ripple_curvature_per_mm) & (
        ripple * LUMINANCE_RESPONSE <= gates.ripple_luminance
    )
    if not passed.any():
        raise InputError(
            f"{where}: mask.period_um: {rules.period * 1000:g}: leaves a ripple of "
            f"{ripple.min():.3g} /mm or more at every ratio: expected a shorter period, or a resin "
            f"that levels further than {rules.levelling_length:.3g} mm"
        )
    # The widest stretch of ratios without a gap: a map runs through all that lie between its ends.
    edge = np.flatnonzero(np.diff(np.concatenate([[False], passed, [False]]).astype(int)))
    start, end = edge[::2], edge[1::2]
    widest = int(np.argmax(end - start))
    return float(ratio[start[widest]]), float(ratio[end[widest] - 1])
