"""The least contrast of stripes that the eye sees: information beside the limits, never a gate."""

import math

#: Share of the backlight's luminance that a liquid-crystal panel lets through; usual for colour.
PANEL_TRANSMITTANCE = 0.05


def threshold_contrast(
    pitch: float, distance: float, luminance: float, field_deg: float = 60.0
) -> float:
    """Return the Michelson contrast of sinusoidal stripes that is seen half of the time.

    Barten, "Formula for the contrast sensitivity of the human eye", Proc. SPIE 5294 (2003):

        1/m = 5200 exp(−0.0016 u² (1 + 100/L)^0.08)
              / √((1 + 144/X² + 0.64 u²) (63/L^0.83 + 1/(1 − exp(−0.02 u²))))

    Parameters
    ----------
    pitch, distance
        of the stripes, and from the eye to the screen [mm]
    luminance
        L of the screen [cd/m²]
    field_deg
        X, side of the square that is looked at [degree]

    >>> round(threshold_contrast(32.69, 1200.0, 400.0), 4)
    0.0024
    """
    per_degree = 1 / math.degrees(2 * math.atan(pitch / 2 / distance))
    square = per_degree**2
    optics = math.exp(-0.0016 * square * (1 + 100 / luminance) ** 0.08)
    size = 1 + 144 / field_deg**2 + 0.64 * square
    noise = 63 / luminance**0.83 + 1 / (1 - math.exp(-0.02 * square))
    return math.sqrt(size * noise) / (5200 * optics)


def describe_eye(pitch: float, distance: float, luminance: float) -> dict[str, object]:
    """Return the threshold as it stands in verification.json; `luminance` of the backlight."""
    seen = luminance * PANEL_TRANSMITTANCE
    return {
        "threshold_contrast": threshold_contrast(pitch, distance, seen),
        "viewing_distance_mm": distance,
        "stripe_pitch_mm": pitch,
        "luminance_at_eye_cd_m2": seen,
        "panel_transmittance": PANEL_TRANSMITTANCE,
        "source": "Barten, Formula for the contrast sensitivity of the human eye, Proc. SPIE 5294 "
        "(2003); sinusoidal stripes; the panel's transmittance is assumed",
    }
