"""Which stacks and films are traced for the fit: all assumed values moved at once."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thesis.film_case import EMPTY, Case

#: Curvature through the tips at a fill of 10 %: 57.04 /mm (Hsieh, MPF thesis: fitted 58 /mm).
PRINTED = 57.04


@dataclass(frozen=True)
class Factor:
    """An assumed value: where the trials stand around it, and how far.

    Code 0 is `centre`, code ±1 is centre ± step, or centre ×/÷ step for a `ratio`.
    """

    name: str
    centre: float
    step: float
    ratio: bool = False

    def value(self, code: float) -> float:
        """Return the value at a code."""
        if self.ratio:
            return self.centre * self.step**code
        return self.centre + self.step * code

    def code(self, value: float) -> float:
        """Return the code of a value."""
        if self.ratio:
            return float(np.log(value / self.centre) / np.log(self.step))
        return (value - self.centre) / self.step


#: A step is about what is plausible either way without a measurement.
FACTORS = (
    Factor("bottom_sheet_sigma", 0.36, 0.05),
    Factor("top_sheet_sigma", 0.35, 0.05),
    Factor("plate_scattering_per_mm", 0.6, 1.4, ratio=True),
    Factor("plate_asymmetry", 0.8, 0.05),
    Factor("plate_absorption_per_mm", 0.0036, 0.002),
    Factor("reflector_reflectance", 0.94, 0.02),
    Factor("reflector_specular_fraction", 0.30, 0.20),
    Factor("lamp_height_mm", 3.5, 0.7),
    Factor("lamp_radius_mm", 1.7, 0.3),
    Factor("lamp_reflectance", 0.75, 0.15),
    Factor("sheet_transmission", 0.98, 0.01),
)

#: Preset, profile and curvatures [1/mm] of films that follow one another smoothly in curvature.
FAMILIES = {
    "conventional": ("thesis-32in-conventional", "filled", (EMPTY,)),
    "mpf": ("thesis-32in-mpf", "ideal", (50.0, 57.0, 63.0, 72.0, 81.0)),
    "bef": ("thesis-32in-mpf", "filled", (EMPTY,)),
    "mpf-printed": ("thesis-32in-mpf", "filled", (PRINTED,)),
    "plate": ("thesis-32in-mpf-plate", "ideal", (50.0, 65.0, 81.0)),
    "plate-printed": ("thesis-32in-mpf-plate", "filled", (PRINTED,)),
}


def cases(family: str) -> list[Case]:
    """Return the films of a family."""
    preset, profile, curvatures = FAMILIES[family]
    return [Case(f"{family}-{c:g}", preset, profile, c) for c in curvatures]


def screening_design() -> NDArray[np.float64]:
    """Return the codes of the trials, (24, 11) of ±1: each factor's effect apart from the others'.

    Plackett and Burman, "The design of optimum multifactorial experiments", 1946, 12 runs, and the
    same with all signs turned, so that no product of two factors looks like one factor.
    """
    generator = np.array([1, 1, -1, 1, 1, 1, -1, -1, -1, 1, -1], float)
    rows = [np.roll(generator, shift) for shift in range(11)]
    half = np.array([*rows, -np.ones(11)])
    # Each trial and its opposite follow one another: a run cut short is balanced.
    return np.stack([half, -half], axis=1).reshape(24, 11)


def values_at(code: NDArray[np.float64]) -> dict[str, float]:
    """Return the stack's values at codes (11,)."""
    return {factor.name: factor.value(c) for factor, c in zip(FACTORS, code, strict=True)}
