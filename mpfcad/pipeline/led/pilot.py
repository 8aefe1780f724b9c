"""How the light over one film answers to its C, measured: no experience tells it.

Grooves, pyramids and dishes differ in size and may differ in sign.

One pattern of all harmonics is laid onto an even film and taken away from it, and both are traced.
Half the difference of a harmonic of ln L is its response, without what is even in C.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CurvatureSeries
from mpfcad.pipeline.led.tried import Tried

#: Share of the way from the mean of C to its nearer limit that the pattern goes.
_SHARE = 0.5
#: Signs along an axis: the sum of such cosines has no high peak (after Rudin and Shapiro).
_SIGNS = np.array([1.0, 1.0, -1.0, -1.0, 1.0])
#: Standard errors by which a response has to differ from 0.
SURE = 3.0
#: How far a harmonic's own response is from that of all, as a share of it (standard deviation).
_SPREAD = 0.5


@dataclass(frozen=True, eq=False)
class Pilot:
    """What two films of opposite patterns tell.

    Attributes
    ----------
    own, error
        (h+1, h+1) float64 [mm], the response of each harmonic of ln L to its own of C and its
        standard error; infinite where nothing tells it
    value, standard_error
        the response of all of them [mm], weighted by what they tell
    """

    own: NDArray[np.float64]
    error: NDArray[np.float64]
    value: float
    standard_error: float

    @property
    def is_told(self) -> bool:
        """Whether the response differs from 0."""
        return abs(self.value) > SURE * self.standard_error

    @property
    def response(self) -> NDArray[np.float64]:
        """What a search takes, (h+1, h+1) [mm].

        Each harmonic's own as far as it is told, drawn to that of all. Where that is not told, the
        largest that is left possible: what no map does with it, no map does.
        """
        if not self.is_told:
            most = abs(self.value) + SURE * self.standard_error
            return np.full(self.own.shape, np.copysign(most, self.value))
        told, prior = 1 / self.error**2, 1 / (_SPREAD * self.value) ** 2
        return (self.own * told + self.value * prior) / (told + prior)

    def document(self) -> dict[str, Any]:
        """Return it as plain values, fit for JSON; None where a harmonic tells nothing."""

        def plain(table: NDArray[np.float64]) -> list[list[float | None]]:
            told = np.isfinite(self.error)
            return [
                [float(value) if known else None for value, known in zip(*rows, strict=True)]
                for rows in zip(table, told, strict=True)
            ]

        return {
            "response_mm": self.value,
            "standard_error_mm": self.standard_error,
            "is_told": self.is_told,
            "harmonic_mm": plain(self.own),
            "harmonic_standard_error_mm": plain(self.error),
        }


def pilot_pattern(size: int, room: float) -> NDArray[np.float64]:
    """Return a pattern of all harmonics, (size, size) [1/mm], within half of `room` [1/mm]."""
    signs = _SIGNS[:size]
    pattern = np.outer(signs, signs)
    pattern[0, 0] = 0.0
    place = np.arange(64) / 64
    return _SHARE * room / float(np.abs(CurvatureSeries(pattern).at(place, place)).max()) * pattern


def read_pilot(more: Tried, less: Tried) -> Pilot:
    """Return what the films with a pattern and without it tell of the response.

    Their noise is taken as independent: paths that both have in common make it less.
    """
    moved = more.map.coefficient - less.map.coefficient
    error = np.full(moved.shape, np.inf)
    own = np.zeros(moved.shape)
    told = moved != 0
    own[told] = (more.harmonic - less.harmonic)[told] / moved[told]
    error[told] = np.hypot(more.error, less.error)[told] / np.abs(moved[told])
    weight = 1 / error**2
    value = float(np.sum(weight * own) / weight.sum())
    return Pilot(own, error, value, float(weight.sum() ** -0.5))
