"""Our figures of the traced cases, with intervals, and what they say beside a published one."""

import math
from dataclasses import dataclass

import numpy as np

from thesis.by_curvature import by_curvature
from thesis.film_case import PRINTED

CONVENTIONAL = "conventional filled 80"
BEF = "bef filled 80"
MPF_PRINTED = f"mpf filled {PRINTED:g}"
PLATE_PRINTED = f"mpf-plate filled {PRINTED:g}"
PATTERNED = "patterned-16mm"
#: Standard errors in half of a 95 % interval.
_SIGMAS = 1.96


@dataclass(frozen=True)
class Figure:
    """A figure with its 95 % interval."""

    value: float
    low: float
    high: float

    def show(self, digits: int) -> str:
        """Return `value (low … high)`."""
        return f"{self.value:.{digits}f} ({self.low:.{digits}f} … {self.high:.{digits}f})"

    def beside(self, published: float, half_digit: float, near: float, digits: int) -> str:
        """Return the verdict beside a published value given to ± `half_digit`.

        `agrees`: the published value lies in our interval widened by its rounding, and no end of
        the interval is further from it than twice `near`; the furthest distance is given. `open`:
        it lies there, but the interval is too wide. `near`: ours is within `near` of it.
        """
        furthest = max(abs(self.low - published), abs(self.high - published))
        if self.low - half_digit <= published <= self.high + half_digit:
            word = "agrees" if furthest <= 2 * near else "open"
            return f"{word}, within {furthest:.{digits}f}"
        return "near" if abs(self.value - published) <= near else "differs"

    def beyond(self, limit: float, *, above: bool, digits: int = 4) -> str:
        """Return the verdict beside a limit: `agrees` where the whole interval is on its side."""
        low, high = self.low - limit, self.high - limit
        if not above:
            low, high = -high, -low
        if low > 0:
            return f"agrees, by {low:.{digits}f} or more"
        if high < 0:
            return "differs"
        holds = (self.value > limit) if above else (self.value < limit)
        return f"open, value {'agrees' if holds else 'differs'}"

    def keeps(self, low: float, high: float) -> tuple[bool, str]:
        """Return whether the value lies in low … high, and whether its interval does.

        The interval: `met` inside, `not met` outside, `open` across a limit.
        """
        value = low <= self.value <= high
        if low <= self.low and self.high <= high:
            return value, "met"
        return value, "not met" if self.high < low or self.low > high else "open"


class Figures:
    """The figures of one set of values."""

    def __init__(self, results: dict, values: str):
        self.case = results["set"][values]
        self.curve = {"mpf": self._curve("mpf ideal"), "plate": self._curve("mpf-plate ideal")}

    def _curve(self, films: str) -> dict:
        """Return contrast and relative luminance of like films against their curvature."""
        names = [name for name in self.case if name.startswith(films + " ")]
        relative = [self.relative(name) for name in names]
        harmonics = np.array([self.case[name]["harmonics"] for name in names])
        reading = np.c_[np.log([f.value for f in relative]), harmonics[..., 0]]
        width = np.c_[
            [(f.high - f.low) / f.value for f in relative], harmonics[..., 2] - harmonics[..., 1]
        ]
        at = np.array([float(name.split()[-1]) for name in names])
        return by_curvature(at, reading, width / (2 * _SIGMAS))

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

    def fill_ratio(self, stack: str, resin: str, curvature: float) -> Figure:
        """Return the mean luminance with a scattering resin over that with a clear one."""
        return self.relative(f"{stack} {resin} {curvature:g}", f"{stack} filled {curvature:g}")

    def first_harmonic(self, name: str) -> Figure:
        """Return cos 2πu's amplitude over the mean: below 0 is brighter between the lamps."""
        return Figure(*self.case[name]["harmonics"][0])

    def paths(self) -> list[int]:
        """Return the paths of each case."""
        return [case["paths"] for case in self.case.values()]

    def half_width(self, name: str) -> float:
        """Return half the interval of a case's contrast."""
        found = self.contrast(name)
        return (found.high - found.low) / 2

    def lowest(self, family: str) -> Figure:
        """Return the least contrast over the traced range of curvature."""
        curve = self.curve[family]["contrast"]
        at = min(range(len(curve["value"])), key=curve["value"].__getitem__)
        return Figure(*(curve[key][at] for key in ("value", "low", "high")))

    def place(self, family: str, name: str) -> Figure:
        """Return an edge of the good range of curvature, or its best."""
        return Figure(*self.curve[family][name])
