"""The search of a map under LEDs: each harmonic of C corrected by its own harmonic of L.

A film's harmonic answers to that of the luminance over it nearly alone. Uniform films come first;
then each harmonic of C moves by -L_ij/r_ij, r the response of ln L to C [mm], which is taken from
the prior below and, once a harmonic has moved, from what it did.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CurvatureSeries
from mpfcad.job.led_design import LedDesign
from mpfcad.measure import CellResult

#: Response of ln L to C [mm] of one film; of two at C = 74 /mm, and over which C it doubles [1/mm].
ONE, TWO, AT, DOUBLES = -0.0028, -0.018, 74.0, 10.0
#: Bounds of a response found, over its prior.
_LEAST, _MOST = 0.4, 3.0
#: Least change [1/mm] that tells a response.
_TELLS = 0.3


@dataclass(frozen=True, eq=False)
class Tried:
    """A map that was traced.

    Attributes
    ----------
    map
        its series
    found
        the luminance over the cell
    harmonic
        (h+1, h+1) float64, amplitudes of the luminance's cosines over the mean
    """

    map: CurvatureSeries
    found: CellResult
    harmonic: NDArray[np.float64]


@dataclass(eq=False)
class LedSearch:
    """Tries maps by a trace from files; `tried` holds them in their order."""

    design: LedDesign
    trace: Callable[[CurvatureSeries], CellResult]
    tried: list[Tried] = field(default_factory=list)

    @property
    def best(self) -> Tried:
        """The map of least contrast."""
        return min(self.tried, key=lambda one: one.found.contrast.value)

    def run(self) -> Tried:
        """Return the best map after uniform films and corrections."""
        size = self.design.constraint.harmonics + 1
        for curvature in self.design.search.uniform_per_mm:
            coefficient = np.zeros((size, size))
            coefficient[0, 0] = curvature
            self._try(coefficient)
        last = self.best
        response = self._prior(last.map.coefficient[0, 0])
        for _ in range(self.design.search.iterations):
            if self.best.found.contrast.value <= self.design.goal.contrast_target:
                break
            step = -last.harmonic / response
            step[0, 0] = 0.0
            new = self._try(self._held(last.map.coefficient + step))
            moved = new.map.coefficient - last.map.coefficient
            told = np.abs(moved) > _TELLS
            prior = self._prior(new.map.coefficient[0, 0])[told]
            gained = (new.harmonic - last.harmonic)[told] / moved[told]
            response[told] = prior * np.clip(gained / prior, _LEAST, _MOST)
            last = new
        return self.best

    def _prior(self, curvature: float) -> NDArray[np.float64]:
        size = self.design.constraint.harmonics + 1
        two = TWO * 2 ** ((curvature - AT) / DOUBLES)
        return np.full((size, size), ONE if self.design.films == 1 else two)

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


def cosines(found: CellResult, size: int) -> NDArray[np.float64]:
    """Return the amplitudes of the luminance's cosines over the mean, (size, size); 0 beyond."""
    amplitude = np.zeros((size, size))
    series = found.series
    for (i, j), value in zip(series.order, series.coefficient, strict=True):
        even = (i == 0 or i % 2 == 1) and (j == 0 or j % 2 == 1)
        a, b = (int(i) + 1) // 2, (int(j) + 1) // 2
        if even and a < size and b < size:
            amplitude[a, b] = value / series.coefficient[0]
    amplitude[0, 0] = 0.0
    return amplitude
