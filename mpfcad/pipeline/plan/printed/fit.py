"""The shortest period of a pattern that a screen holds, and what is left of it after levelling."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.mask.screen.slot_ripple import slot_ripple

#: Apertures and webs are so much longer than they must be; periods are multiples of that [mm].
SPARE, PERIOD_STEP, LONGEST_PERIOD = 1.05, 0.01, 10.0


@dataclass(frozen=True, eq=False)
class Fit:
    """A pattern that holds a range of ratios; lengths in mm.

    Attributes
    ----------
    pattern, period
        of the apertures along the grooves
    aperture, web
        smallest
    residual
        (2,) float64, root mean square of the ratio's error after levelling, at both ends
    """

    pattern: Literal["slot", "dot"]
    period: float
    aperture: float
    web: float
    residual: NDArray[np.float64]


def fit_slots(
    ratio: tuple[float, float], limit: tuple[float, float], levelling: float
) -> Fit | None:
    """Return slots for ratios and smallest aperture and web [mm]; None when no period holds them.

    `levelling` is the levelling length [mm].
    """
    low, high = ratio
    if high >= 1:
        return None
    period = _stepped(SPARE * max(limit[0] / low, limit[1] / (1 - high)))
    if period > LONGEST_PERIOD:
        return None
    residual = slot_ripple(np.array(ratio), period, levelling)
    return Fit("slot", period, low * period, (1 - high) * period, residual)


def fit_dots(
    ratio: tuple[float, float], limit: tuple[float, float], pitch: float, levelling: float
) -> Fit | None:
    """Return square dots in grooves of `pitch` [mm], as `fit_slots`; a web lies on all sides."""
    low, high = ratio
    web = SPARE * limit[1]
    # Along: P - sqrt(high pitch P) >= web. Across: sqrt(high pitch P) <= pitch - web.
    along = ((math.sqrt(high * pitch) + math.sqrt(high * pitch + 4 * web)) / 2) ** 2
    period = _stepped(max((SPARE * limit[0]) ** 2 / (low * pitch), along))
    sides = np.sqrt(np.array(ratio) * pitch * period)
    if period > LONGEST_PERIOD or sides[1] > pitch - web:
        return None
    # Along a groove a dot is a slot as long as its side, as deep as its share of the width.
    residual = slot_ripple(sides / period, period, levelling) * sides / pitch
    return Fit("dot", period, float(sides[0]), float(min(pitch, period) - sides[1]), residual)


def _stepped(period: float) -> float:
    return math.ceil(period / PERIOD_STEP - 1e-9) * PERIOD_STEP
