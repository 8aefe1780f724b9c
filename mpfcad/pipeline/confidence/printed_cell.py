"""Films under LEDs with the resin that their process may give them, and their light in short runs.

All films of a job are printed by one process, so they have more resin, or less, together.
"""

import tempfile
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import Factor
from mpfcad.film import CellLibrary, PieceLibrary
from mpfcad.measure import POINTS, CellResult, Lit, light_film, trace_terms
from mpfcad.pipeline.confidence.runs import Reading, Runs
from mpfcad.pipeline.confidence.variant import FULL, RESIN, TONE
from mpfcad.pipeline.plan.cell import LEVELS
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import SILENT, Progress

#: Curvatures between the least and the most of the films at which the process is asked, and places
#: along each side of the cell where the light is read.
_ASKED, _FINE = 64, 24
#: Paths of a block of a trace over a pitch.
_PITCH_BLOCK = POINTS * 512


class CellRuns(Runs):
    """Traces of a plan under LEDs with other resin, all with the same random numbers."""

    def __init__(
        self,
        plan: Plan,
        films: list[PieceLibrary | CellLibrary],
        found: CellResult,
        threads: int,
        progress: Progress,
    ) -> None:
        self.plan, self.films, self.series = plan, films, found.series
        self.estimator = found.choice.estimator
        wanted = np.concatenate([film.wanted.ravel() for film in films])
        ends = float(wanted.min()), float(wanted.max())
        if plan.job.halftone is not None:  # one ratio is printed, whatever levelling makes of it
            ends = (plan.job.halftone.curvature_per_mm,) * 2
        self.asked = np.linspace(*ends, _ASKED)
        super().__init__(None, self._factors(), _reading(found), plan.job.seed, threads, progress)

    @cached_property
    def modes(self) -> NDArray[np.float64] | None:
        """What the process does not know of ln(fill) at the asked curvatures, (k, n)."""
        process = self.plan.process
        if process is None:
            return None
        modes = process.fill_modes(process.aperture_ratio_of_curvature(self.asked))
        return None if modes is None else modes[:2]

    def _factors(self) -> list[Factor]:
        if self.modes is None or self.plan.process is None:
            return []
        source = f"resin of the films, by the process: {self.plan.process.source}"
        size = 100 * np.sqrt(np.mean(self.modes**2, axis=1))
        return [
            Factor(name, 0.0, float(one), source=source, is_curved=True)
            for name, one in zip((RESIN, TONE), size, strict=False)
            if one > 0
        ]

    def changed(
        self, library: PieceLibrary | CellLibrary, steps: NDArray[np.float64]
    ) -> PieceLibrary | CellLibrary:
        """Return a film with other resin, `steps` of the factors in units of sigma."""
        assert self.modes is not None  # without modes there are no factors
        more = np.zeros(_ASKED)
        for mode, step in zip(self.modes, steps, strict=False):
            more += mode * step
        groove, wanted = library.groove, library.wanted
        fill = np.asarray(groove.fill_fraction(wanted))
        of_place = (
            more[0] if self.asked[0] == self.asked[-1] else np.interp(wanted, self.asked, more)
        )
        fill = fill * np.exp(of_place)
        curvature = np.asarray(groove.curvature_of_fill(np.clip(fill, 0.0, FULL)))
        levels = LEVELS if self.plan.job.cad.levels is None else self.plan.job.cad.levels
        curvature = np.minimum(curvature, groove.curvature_empty)
        return library.remapped(curvature, levels)

    def light(self, steps: NDArray[np.float64]) -> Lit:
        """Return the films with other resin, written and read back, in the job's stack."""
        from mpfcad.pipeline.run.make import write_cad

        drawn = [self.changed(film, steps) for film in self.films]
        films = [replace(one, drawn=film) for one, film in zip(self.plan.films, drawn, strict=True)]
        across = films[1] if len(films) > 1 else None
        plan = replace(films[0], crossed=across)
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary)
            write_cad(plan, folder, ("3mf",), SILENT)
            return light_film(plan.lit_stack(folder), folder / plan.file("film", "3mf"))

    def trace(self, steps: NDArray[np.float64], blocks: int) -> tuple[NDArray, NDArray]:
        """Return the coefficients of a run over its mean, and their covariance."""
        paths = blocks * _PITCH_BLOCK
        lit = self.light(steps)
        value, covariance, traced = trace_terms(
            lit, self.series.order, paths, self.seed, self.threads, self.estimator
        )
        self.paths += traced
        return value[1:] / value[0], covariance[1:, 1:] / value[0] ** 2


def _reading(found: CellResult) -> Reading:
    """Return the cell's own coefficients over their mean, and where the light is read."""
    series = found.series
    fine = np.arange(_FINE) / _FINE
    u, v = (part.ravel() for part in np.meshgrid(fine, fine, indexing="ij"))
    mean = series.coefficient[0]
    return Reading(
        np.zeros((0, 0)), series.at(u, v)[:, 1:], series.coefficient[1:] / mean,
        series.covariance[1:, 1:] / mean**2, False,
    )  # fmt: skip
