"""Gates of the screen: what it lets through, how fine it is, what levelling and a shift leave."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.process.model import NORMAL_95
from mpfcad.gate import Gate, Outcome, worst_outcome
from mpfcad.mask import MaskCheck
from mpfcad.mask.screen.printing import Printing
from mpfcad.units import nm, um

#: What is said instead of a judgement when the job names no mesh.
PHOTOTOOL_ONLY = "phototool only"
#: Rounding of an aperture's and a web's edges to the grid.
ROUNDING = 2 * nm
#: How far a groove's aperture ratio read back may be from the wanted one: 0.1 percentage point.
RATIO_LIMIT = 0.001
#: Begins the name of every gate of the screen.
PREFIX = "screen_"


@dataclass(frozen=True)
class PrintLimits:
    """Limits of what a screen prints, as the job's `[gates]` have them.

    Attributes
    ----------
    ratio_min, ratio_max
        of the open grooves' aperture ratios
    ripple_curvature, registration_curvature
        [1/mm]
    ripple_luminance
        as a share of the luminance
    """

    ratio_min: float
    ratio_max: float
    ripple_curvature: float
    ripple_luminance: float
    registration_curvature: float


def mask_gates(checks: Mapping[str, MaskCheck]) -> list[Gate]:
    """Return the gates of mask files, whatever screen they are for."""
    if not checks:
        return []
    error = max(check.aperture_ratio_error_max for check in checks.values())
    narrow = sum(len(c.windows.violations) for c in checks.values() if c.windows is not None)
    return [
        Gate("mask_aperture_ratio_error", error, RATIO_LIMIT),
        Gate("mask_rule_violations", float(narrow), 0.0),
    ]


def print_gates(
    printing: Printing | None, checks: Mapping[str, MaskCheck], limits: PrintLimits
) -> list[Gate]:
    """Return the gates of a screen; none without a mesh: a phototool alone is not judged.

    Ratios and features are those read back from the files, the others are of the mask in them.
    """
    if printing is None or printing.mesh is None or not checks:
        return []
    return [
        *_release_gate(printing),
        *_ratio_gates(checks, printing, limits),
        *_feature_gates(checks, printing),
        Gate(f"{PREFIX}ripple_per_mm", printing.ripple, limits.ripple_curvature),
        Gate(f"{PREFIX}ripple_luminance", printing.ripple_luminance, limits.ripple_luminance),
        Gate(
            f"{PREFIX}registration_per_mm",
            printing.registration_curvature,
            limits.registration_curvature,
        ),
    ]


def printability(printing: Printing | None, gates: list[Gate]) -> Outcome | str | None:
    """Return the worst outcome of mask and screen; `phototool only` without a mesh; None: no mask.

    Examples
    --------
    >>> printability(None, []) is None
    True
    """
    if printing is None:
        return None
    if printing.mesh is None:
        return PHOTOTOOL_ONLY
    return worst_outcome([gate for gate in gates if gate.name.startswith((PREFIX, "mask_"))])


def _release_gate(printing: Printing) -> list[Gate]:
    if printing.release is None:
        return []
    interval = None
    if printing.release_deviation is not None:
        width = NORMAL_95 * printing.release_deviation
        interval = (printing.release * math.exp(-width), printing.release * math.exp(width))
    return [Gate(f"{PREFIX}release", printing.release, 1.0, interval)]


def _ratio_gates(
    checks: Mapping[str, MaskCheck], printing: Printing, limits: PrintLimits
) -> list[Gate]:
    found = [_over_printed(check.aperture_ratio, printing) for check in checks.values()]
    is_open = [ratio[ratio > 1e-4] for ratio in found]
    if not all(ratio.size for ratio in is_open):
        return []
    # Of a map of both directions the means of whole grooves say less than its own ends.
    least = min(printing.ratio_min, *(float(ratio.min()) for ratio in is_open))
    most = max(printing.ratio_max, *(float(ratio.max()) for ratio in is_open))
    return [
        Gate(f"{PREFIX}ratio_min", least, limits.ratio_min, at_least=True),
        Gate(f"{PREFIX}ratio_max", most, limits.ratio_max),
    ]


def _over_printed(ratio: NDArray[np.float64], printing: Printing) -> NDArray[np.float64]:
    """Return grooves' ratios over what of their length is printed; as they are where nothing is."""
    share = printing.printed_share
    return ratio if share is None else np.divide(ratio, share, out=ratio.copy(), where=share > 0)


def _feature_gates(checks: Mapping[str, MaskCheck], printing: Printing) -> list[Gate]:
    found = (
        ("aperture", [c.smallest_aperture for c in checks.values()], printing.aperture_limit),
        ("web", [c.smallest_web for c in checks.values()], printing.web_limit),
    )
    gates = []
    for name, sizes, limit in found:
        known = [size for size in sizes if size is not None]
        if known:
            least = (limit - ROUNDING) / um
            gates.append(Gate(f"{PREFIX}{name}_um", min(known) / um, least, at_least=True))
    return gates
