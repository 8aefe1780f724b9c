"""The search of a map under LEDs: each harmonic of C corrected by its own harmonic of L.

A film's harmonic answers to that of the luminance over it nearly alone. Uniform films come first;
the search goes on about that whose best pattern has the least contrast by the model of `bound`.
Each harmonic of C moves by -L_ij/r_ij, r the response of ln L to C [mm], which is taken from
the experience below, of one film from a `pilot`, and, once a harmonic has moved, from what it did.
Where the limits of C forbid that move, the best map within them by the same linear model is next.
Where the pilot's response may be none, no map is tried.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CurvatureSeries
from mpfcad.job.led_design import LedDesign
from mpfcad.measure import CellResult
from mpfcad.pipeline.led.bound import least_contrast
from mpfcad.pipeline.led.pilot import Pilot, pilot_pattern, read_pilot
from mpfcad.pipeline.led.tried import Tried, read_tried

#: Response of ln L to C [mm] of two films at C = 74 /mm, and over which C it doubles [1/mm].
TWO, AT, DOUBLES = -0.018, 74.0, 10.0
#: Bounds of a response that a move has told, over what was taken before.
_LEAST, _MOST = 0.4, 3.0
#: Least change [1/mm] that tells a response, if what it is expected to do is over the noise.
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
    pilots
        by the mean C [1/mm], what was measured of one film
    pilot
        that of the mean that the search goes on about; None of two films, and before
    """

    design: LedDesign
    trace: Callable[[CurvatureSeries], CellResult]
    tried: list[Tried] = field(default_factory=list)
    response: NDArray[np.float64] = field(init=False, default_factory=lambda: np.zeros((0, 0)))
    pilots: dict[float, Pilot] = field(init=False, default_factory=dict)
    pilot: Pilot | None = field(init=False, default=None)

    @property
    def best(self) -> Tried:
        """The map of least contrast."""
        return self._best_of(self.tried)

    @staticmethod
    def _best_of(tried: list[Tried]) -> Tried:
        return min(tried, key=lambda one: one.found.contrast.value)

    def run(self) -> Tried:
        """Return the best map after uniform films and corrections."""
        evens = [self.try_even(curvature) for curvature in self.design.search.uniform_per_mm]
        even = min(evens, key=self._promise)
        prior = self.response_of(even)
        response = self.response = prior.copy()
        self.pilot = self.pilots.get(even.mean)
        if self.pilot is not None and not self.pilot.is_told:
            return self.best
        last = self._best_of([one for one in self.tried if one.mean == even.mean])
        for _ in range(self.design.search.iterations):
            if self.best.found.contrast.value <= self.design.goal.contrast_target:
                break
            step = -last.harmonic / response
            step[0, 0] = 0.0
            new = self._try(self._next(last, step))
            moved = new.map.coefficient - last.map.coefficient
            noise = np.hypot(new.error, last.error)
            told = (np.abs(moved) > _TELLS) & (noise < np.abs(prior * moved))
            gained = (new.harmonic - last.harmonic)[told] / moved[told]
            response[told] = prior[told] * np.clip(gained / prior[told], _LEAST, _MOST)
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

    def response_of(self, even: Tried) -> NDArray[np.float64]:
        """Return the response (h+1, h+1) [mm] about an even film; of one film, measured once."""
        size = self.design.constraint.harmonics + 1
        if self.design.films == 2:
            return np.full((size, size), TWO * 2 ** ((even.mean - AT) / DOUBLES))
        if even.mean not in self.pilots:
            pattern, about = pilot_pattern(size, self._room(even.mean)), even.map.coefficient
            more, less = (self._try(about + move) for move in (pattern, -pattern))
            self.pilots[even.mean] = read_pilot(more, less)
        return self.pilots[even.mean].response

    def _room(self, curvature: float) -> float:
        """Return how far a C [1/mm] is from its nearer limit."""
        limit = self.design.constraint
        return min(limit.curvature_max_per_mm - curvature, curvature - limit.curvature_min_per_mm)

    def _promise(self, even: Tried) -> tuple[float, float]:
        """Return what the best pattern about an even film leaves by the model, and the film's own.

        To a thousandth: below that the film that is better by itself is. A response in the noise
        promises nothing.
        """
        own, response = even.found.contrast.value, self.response_of(even)
        if even.mean in self.pilots and not self.pilots[even.mean].is_told:
            return round(own, 3), own
        least = least_contrast(self.design.constraint, even, response)
        return round(least.contrast, 3), own

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
        tried = read_tried(chosen, self.trace(chosen))
        self.tried.append(tried)
        return tried
