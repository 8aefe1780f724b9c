"""Our figures of the traced cases, with intervals, and what they say beside a published one."""

import math
from dataclasses import dataclass

from thesis.trial import PRINTED

CONVENTIONAL = "conventional filled 80"
BEF = "bef filled 80"
MPF_PRINTED = f"mpf filled {PRINTED:g}"
PLATE_PRINTED = f"mpf-plate filled {PRINTED:g}"
PATTERNED = "patterned-16mm"


@dataclass(frozen=True)
class Figure:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float

    def show(self, digits: int) -> str:
        """Return `value (low … high)`."""
        return f"{self.value:.{digits}f} ({self.low:.{digits}f} … {self.high:.{digits}f})"

    def beside(self, published: float, half_digit: float, near: float) -> str:
        """Return the verdict beside a published value given to ± `half_digit`.

        `agrees`: the published value lies in our interval widened by its rounding; `near`: ours is
        within `near` of it; else `differs`.
        """
        if self.low - half_digit <= published <= self.high + half_digit:
            return "agrees"
        return "near" if abs(self.value - published) <= near else "differs"

    def is_at_most(self, limit: float) -> bool:
        """Return whether the value, not its whole interval, keeps a limit."""
        return self.value <= limit


class Figures:
    """The figures of one set of values."""

    def __init__(self, results: dict, fit: dict, values: str):
        self.case = results["set"][values]
        self.curve = fit["by_curvature"]["centre" if values == "thesis-32in" else "fitted"]

    def contrast(self, name: str) -> Figure:
        """Return the lamp-Mura contrast of a case."""
        return Figure(*self.case[name]["contrast"])

    def luminance(self, name: str) -> Figure:
        """Return the mean luminance [cd/m²] of a case."""
        return Figure(*self.case[name]["luminance_cd_m2"])

    def relative(self, name: str, to: str = CONVENTIONAL) -> Figure:
        """Return the mean luminance of a case over that of another."""
        one, other = self.luminance(name), self.luminance(to)
        ratio = one.value / other.value
        spread = math.hypot(*((f.high - f.low) / 2 / f.value for f in (one, other)))
        return Figure(ratio, ratio * (1 - spread), ratio * (1 + spread))

    def is_brighter_between(self, name: str) -> bool:
        """Return whether a case is brighter between the lamps than above."""
        return self.case[name]["first_harmonic"] < 0

    def place(self, family: str, name: str) -> Figure:
        """Return an edge of the good range of curvature, or its best, off the surfaces."""
        return Figure(*self.curve[family][name])
