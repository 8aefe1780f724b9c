"""What films of several thicknesses say together: which serve, and how bright they are."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

#: Outcomes of a thickness: its contrast's interval below, across or above the limit.
SERVES, UNDECIDED, FAILS = "serves", "undecided", "fails"


def spread_lamps(panel_width: float, count: int) -> dict[str, float]:
    """Return the stack's values for `count` lamps evenly over a panel `panel_width` [mm] wide."""
    # Rounded down, so that the row is never wider than the panel.
    return {"lamp_count": count, "lamp_pitch_mm": math.floor(panel_width / count * 1e6) / 1e6}


def outcome(contrast: dict[str, Any], limit: float) -> str:
    """Return what a traced contrast with its interval is worth against a limit."""
    low, high = contrast["ci95"]
    return SERVES if high <= limit else FAILS if low > limit else UNDECIDED


def crossings(x: ArrayLike, y: ArrayLike, level: float) -> list[float]:
    """Return where y, linear between ascending x, passes `level`."""
    place, above = np.asarray(x, float), np.asarray(y, float) - level
    found = []
    for i in range(len(place) - 1):
        if above[i] == 0 or above[i] * above[i + 1] < 0:
            share = above[i] / (above[i] - above[i + 1])
            found.append(float(place[i] + share * (place[i + 1] - place[i])))
    if len(place) and above[-1] == 0:
        found.append(float(place[-1]))
    return found


def describe_limit(
    thickness: Sequence[float],
    contrast: Sequence[dict[str, Any]],
    mean: Sequence[float],
    conventional: float,
    limit: float,
) -> dict[str, Any]:
    """Return which thicknesses serve, and where the mean luminance is the conventional stack's.

    `thickness` ascends [mm]; `contrast` of each is an estimate with its interval, `mean` and
    `conventional` are mean luminances [cd/m²].
    """
    outcomes = [outcome(one, limit) for one in contrast]
    ranged = {
        name: [t for t, one in zip(thickness, outcomes, strict=True) if one == name]
        for name in (SERVES, UNDECIDED, FAILS)
    }
    ratio = np.asarray(mean, float) / conventional
    return {
        "contrast_limit": limit,
        "conventional_luminance_cd_m2": conventional,
        **{f"{name}_mm": values for name, values in ranged.items()},
        "equal_luminance_mm": crossings(thickness, ratio, 1.0),
        "relative_luminance": [float(ratio.min()), float(ratio.max())],
    }
