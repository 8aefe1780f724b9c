"""What to measure next, and how much each measurement would narrow the contrast."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence.factor import Factor
from mpfcad.confidence.response import Response


class Measurement(NamedTuple):
    """A measurement and the standard uncertainty that it leaves, by the end of an input's name.

    A relative one is a share of the input's value.
    """

    name: str
    leaves: dict[str, tuple[float, bool]]


#: What laboratories do, with the uncertainties that they state.
MEASUREMENTS = (
    Measurement(
        "stylus traces of printed coupons",
        {"resin_percent": (2.0, False), "resin_tone_percent": (2.0, False)},
    ),
    Measurement(
        "place of the print against lamps or LEDs",
        {
            "registration_mm": (0.05, False),
            "registration_x_mm": (0.05, False),
            "registration_y_mm": (0.05, False),
        },
    ),
    Measurement(
        "depth of the cavity and height of lamps or LEDs by a gauge",
        {
            "plate_thickness_mm": (0.02, False),
            "thickness_mm": (0.05, False),
            "lamp_height_mm": (0.05, False),
            "lamp_radius_mm": (0.01, False),
        },
    ),
    Measurement("BTDF of the top sheet", {"top_sheet_sigma": (0.02, True)}),
    Measurement("BTDF of the bottom sheet", {"bottom_sheet_sigma": (0.02, True)}),
    Measurement(
        "BRDF of the reflector by a goniometer",
        {"specular_fraction": (0.02, False), "reflector_reflectance": (0.003, False)},
    ),
    Measurement(
        "flux through the sheets by an integrating sphere", {"transmission": (0.002, False)}
    ),
    Measurement("index of film and plate by a refractometer", {"index": (0.001, False)}),
    Measurement(
        "BTDF of the plate",
        {
            "scattering_per_mm": (0.02, True),
            "asymmetry": (0.005, False),
            "absorption_per_mm": (0.05, True),
        },
    ),
    Measurement(
        "reflectance of a lamp or LED by an integrating sphere",
        {
            "lamp_reflectance": (0.01, False),
            "led_reflectance": (0.01, False),
            "led_hole_reflectance": (0.01, False),
            "led_cup_reflectance": (0.003, False),
        },
    ),
    Measurement(
        "emission of an LED by a goniometer",
        {"led_half_angle_deg": (0.5, False), "led_peak_angle_deg": (0.5, False)},
    ),
    Measurement(
        "LEDs, holes and cups under a microscope",
        {
            "led_width_mm": (0.01, False),
            "led_length_mm": (0.01, False),
            "led_height_mm": (0.01, False),
            "led_hole_radius_mm": (0.01, False),
            "led_cup_height_mm": (0.01, False),
            "led_cup_radius_mm": (0.01, False),
            "led_cup_rim_radius_mm": (0.01, False),
        },
    ),
    Measurement(
        "groove depth and film thickness by a section",
        {"depth_um": (0.05, False), "base_um": (1.0, False)},
    ),
)


def rank_measurements(
    response: Response,
    factors: list[Factor],
    steps: NDArray[np.float64],
    limit: float,
) -> list[dict[str, Any]]:
    """Return measurements, the one that narrows the contrast most first, in outside names.

    Each: what it measures; the width of 95 % of the contrasts after it; the probability to meet the
    limit if it confirms the values as stated.
    """
    best = response.shrunk()
    before = _spread(best.contrast(steps))
    found = []
    for one in MEASUREMENTS:
        narrowed = steps.copy()
        named = []
        for i, factor in enumerate(factors):
            left = left_by(one, factor.name, factor.value)
            if left is not None and left < factor.sigma:
                narrowed[:, i] *= left / factor.sigma
                named.append(factor.name)
        if not named:
            continue
        after = best.contrast(narrowed)
        found.append(
            {
                "measurement": one.name,
                "inputs": named,
                "contrast_spread_before": before,
                "contrast_spread": _spread(after),
                "probability_if_confirmed": float(np.mean(after <= limit)),
            }
        )
    return sorted(found, key=lambda row: (row["contrast_spread"], row["measurement"]))


def left_by(one: Measurement, name: str, value: float) -> float | None:
    """Return the standard uncertainty that a measurement leaves of a value; None: not measured."""
    for end, (size, is_relative) in one.leaves.items():
        if name.endswith(end):
            return size * abs(value) if is_relative else size
    return None


def _spread(contrast: NDArray[np.float64]) -> float:
    low, high = np.quantile(contrast, [0.025, 0.975])
    return float(high - low)
