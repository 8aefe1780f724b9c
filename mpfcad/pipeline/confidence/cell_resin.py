"""Films under LEDs with more or less resin than designed.

All films of a job are printed by one process, so they have more resin, or less, together.
"""

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import Factor
from mpfcad.film import CellLibrary, PieceLibrary
from mpfcad.pipeline.confidence.variant import FULL, RESIN, TONE
from mpfcad.pipeline.plan.cell import LEVELS
from mpfcad.pipeline.plan.plan import Plan

#: Curvatures between the least and the most of the films at which the process is asked.
_ASKED = 64


class CellResin:
    """What is not known of the resin of a plan's films, and the films with so much of it."""

    def __init__(self, plan: Plan, films: list[PieceLibrary | CellLibrary]) -> None:
        self.plan, self.films = plan, films
        wanted = np.concatenate([film.wanted.ravel() for film in films])
        ends = float(wanted.min()), float(wanted.max())
        if plan.job.halftone is not None:  # one ratio is printed, whatever levelling makes of it
            ends = (plan.job.halftone.curvature_per_mm,) * 2
        self.asked = np.linspace(*ends, _ASKED)

    @cached_property
    def modes(self) -> NDArray[np.float64] | None:
        """What the process does not know of ln(fill) at the asked curvatures, (k, n)."""
        process = self.plan.process
        if process is None:
            return None
        modes = process.fill_modes(process.aperture_ratio_of_curvature(self.asked))
        return None if modes is None else modes[:2]

    def printed(self) -> list[Factor]:
        """Return what the process itself does not know; empty where it states none."""
        if self.modes is None or self.plan.process is None:
            return []
        source = f"resin of the films, by the process: {self.plan.process.source}"
        return [
            Factor(name, 0.0, float(one), source=source, is_curved=True)
            for name, one in zip((RESIN, TONE), self._sizes, strict=False)
            if one > 0
        ]

    def factors(self, assumed: float) -> list[Factor]:
        """Return what is not known: the process's, else so many percent of all resin."""
        if self.modes is not None:
            return self.printed()
        if assumed <= 0 or not any(film.fill_fraction > 0 for film in self.films):
            return []
        source = "resin of the films, assumed: the process does not state its width"
        return [Factor(RESIN, 0.0, assumed, -100.0, source=source, is_curved=True)]

    @property
    def _sizes(self) -> NDArray[np.float64]:
        """Standard uncertainty of each mode [%]."""
        assert self.modes is not None  # without modes there are no sizes
        return np.asarray(100 * np.sqrt(np.mean(self.modes**2, axis=1)))

    def changed(
        self, library: PieceLibrary | CellLibrary, change: Mapping[str, float]
    ) -> PieceLibrary | CellLibrary:
        """Return a film with other resin, by so many percent of each factor."""
        groove, wanted = library.groove, library.wanted
        fill = np.asarray(groove.fill_fraction(wanted)) * self._factor(wanted, change)
        curvature = np.asarray(groove.curvature_of_fill(np.clip(fill, 0.0, FULL)))
        levels = LEVELS if self.plan.job.cad.levels is None else self.plan.job.cad.levels
        curvature = np.minimum(curvature, groove.curvature_empty)
        return library.remapped(curvature, levels)

    def _factor(
        self, wanted: NDArray[np.float64], change: Mapping[str, float]
    ) -> NDArray[np.float64]:
        """Return how many times as much resin there is at curvatures."""
        if self.modes is None:
            return np.full(wanted.shape, 1 + change.get(RESIN, 0.0) / 100)
        more = np.zeros(_ASKED)
        for name, mode, size in zip((RESIN, TONE), self.modes, self._sizes, strict=False):
            more += mode * change.get(name, 0.0) / size
        is_one = self.asked[0] == self.asked[-1]
        of_place = more[0] if is_one else np.interp(wanted, self.asked, more)
        return np.exp(np.broadcast_to(of_place, wanted.shape))
