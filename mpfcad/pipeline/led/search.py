"""The search of a map under LEDs: each harmonic of C corrected by its own harmonic of L.

A film's harmonic answers to that of the luminance over it nearly alone. Uniform films come first;
then each harmonic of C moves by -L_ij/r_ij, r the response of ln L to C [mm], which is taken from
the prior below and, once a harmonic has moved, from what it did. Where the limits of C forbid that
move, the best map within them by the same linear model is next (`bound`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CurvatureSeries
from mpfcad.job.led_design import LedDesign
from mpfcad.measure import CellResult
from mpfcad.pipeline.led.bound import least_contrast
from mpfcad.pipeline.led.tried import Tried, cosines

#: Response of ln L to C [mm] of one film; of two at C = 74 /mm, and over which C it doubles [1/mm].
ONE, TWO, AT, DOUBLES = -0.0028, -0.018, 74.0, 10.0
#: Bounds of a response found, over its prior.
_LEAST, _MOST = 0.4, 3.0
#: Least change [1/mm] that tells a response.
_TELLS = 0.3


@dataclass(eq=False)
class LedSearch:
    """Tries maps by a trace from files.

    Attributes
    ----------
    tried
        the maps in their order
    response
        (h+1, h+1) float64 [mm], of ln L to C by harmonic, as the last move told it
    """

    design: LedDesign
    trace: Callable[[CurvatureSeries], CellResult]
    tried: list[Tried] = field(default_factory=list)
    response: NDArray[np.float64] = field(init=False, default_factory=lambda: np.zeros((0, 0)))

    @property
    def best(self) -> Tried:
        """The map of least contrast."""
        return min(self.tried, key=lambda one: one.found.contrast.value)

    def run(self) -> Tried:
        """Return the best map after uniform films and corrections."""
        for curvature in self.design.search.uniform_per_mm:
            self.try_even(curvature)
        last = self.best
        response = self.response = self.prior_of(last)
        for _ in range(self.design.search.iterations):
            if self.best.found.contrast.value <= self.design.goal.contrast_target:
                break
            step = -last.harmonic / response
            step[0, 0] = 0.0
            new = self._try(self._next(last, step))
            moved = new.map.coefficient - last.map.coefficient
            told = np.abs(moved) > _TELLS
            prior = self._prior(new.map.coefficient[0, 0])[told]
            gained = (new.harmonic - last.harmonic)[told] / moved[told]
            response[told] = prior * np.clip(gained / prior, _LEAST, _MOST)
            last = new
        return self.best

    def try_even(self, curvature: float) -> Tried:
        """Return the film of one curvature [1/mm], traced once."""
        size = self.design.constraint.harmonics + 1
        coefficient = np.zeros((size, size))
        coefficient[0, 0] = curvature
        for one in self.tried:
            if np.array_equal(one.map.coefficient, coefficient):
                return one
        return self._try(coefficient)

    def prior_of(self, one: Tried) -> NDArray[np.float64]:
        """Return the response (h+1, h+1) [mm] that films of its mean have by experience."""
        return self._prior(one.map.coefficient[0, 0])

    def _prior(self, curvature: float) -> NDArray[np.float64]:
        size = self.design.constraint.harmonics + 1
        two = TWO * 2 ** ((curvature - AT) / DOUBLES)
        return np.full((size, size), ONE if self.design.films == 1 else two)

    def _next(self, last: Tried, step: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the corrected series; where C would pass its limits, the model's best within."""
        wanted = last.map.coefficient + step
        held = self._held(wanted)
        if np.array_equal(held, wanted):
            return held
        return self._held(least_contrast(self.design.constraint, last, self.response).coefficient)

    def _held(self, coefficient: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a series whose pattern is made smaller until C is within its limits."""
        limit = self.design.constraint
        place = np.arange(64) / 64
        pattern = coefficient.copy()
        pattern[0, 0] = 0.0
        value = CurvatureSeries(pattern).at(place, place)
        mean = coefficient[0, 0]
        room = (limit.curvature_max_per_mm - mean, mean - limit.curvature_min_per_mm)
        reach = (float(value.max()), float(-value.min()))
        share = min([1.0, *(max(r, 0.0) / e for r, e in zip(room, reach, strict=True) if e > r)])
        held = share * pattern
        held[0, 0] = mean
        return held

    def _try(self, coefficient: NDArray[np.float64]) -> Tried:
        chosen = CurvatureSeries(coefficient)
        found = self.trace(chosen)
        tried = Tried(chosen, found, cosines(found, len(coefficient)))
        self.tried.append(tried)
        return tried
