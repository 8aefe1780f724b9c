"""Traces of a fit's cases with values changed, kept in the store, all with the same numbers."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import factorial_steps
from mpfcad.errors import InputError
from mpfcad.fit import Unknowns
from mpfcad.fit.reading import DIRECTIONS, FLUX, HALF, PITCH, read_logarithm, read_pitch
from mpfcad.fit.search import Reading, View
from mpfcad.measure import POINTS, Lit, fit_harmonics
from mpfcad.pipeline.fit.case import FitCase
from mpfcad.pipeline.fit.sought import LUMINANCE
from mpfcad.store import Store, work_key

if TYPE_CHECKING:
    from mpfcad.optics.source import Source

#: Kind of a trace in the store.
KIND = "fit"
#: Paths of a round by effort [million], shared by its runs; a view's middle has as many as so many
#: runs.
ROUND_PATHS = {"quick": 20.0, "standard": 100.0, "final": 400.0}
_MIDDLE = 12
#: The flux is one number: it needs fewer.
_FLUX_SHARE = 0.5
_BLOCK = 512
#: χ² of the sines beyond this many standard deviations: not its own mirror image.
_SKEW = 6.0
_POSITION = np.linspace(0, 1, POINTS)


def run_paths(effort: str, views: int, count: int) -> float:
    """Return the paths of one run, of so many views whose lines have so many values."""
    return ROUND_PATHS[effort] * 1e6 / (views * (len(factorial_steps(count)) + _MIDDLE))


class FitTracer:
    """Readings of the cases; `paths` counts those traced or found in the store."""

    def __init__(
        self,
        cases: dict[str, FitCase],
        unknowns: Unknowns,
        active: dict[str, NDArray[np.bool_]],
        store: Store,
        *,
        run_paths: float,
        seed: int,
        threads: int,
    ) -> None:
        self._cases, self._unknowns, self._active = cases, unknowns, active
        self._store, self._seed, self._threads = store, seed, threads
        self._run_paths = run_paths
        self._harmonics: dict[str, int] = {}
        self.paths = 0

    def trace(self, view: View, steps: NDArray[np.float64], *, middle: bool) -> Reading:
        """Return what is read at steps (k,), and its covariance."""
        case, kind = self._cases[view[0]], view[1]
        values = self._unknowns.values(steps)
        bright = values.pop(LUMINANCE, case.stack[LUMINANCE]) / case.stack[LUMINANCE]
        lit = case.light({k: v for k, v in values.items() if k not in case.own})
        found, covariance = self._read(view, lit, middle)
        if LUMINANCE not in case.own:
            found = found + np.log(bright) * _brightness(kind, len(found))
        return found, covariance

    def active(self, view: View) -> NDArray[np.bool_]:
        """Return which values a view depends on by the traces, (k,)."""
        scales = np.array([name == LUMINANCE for name in self._unknowns.names])
        return self._active[view[0]] & ~scales

    def known(self, view: View) -> NDArray[np.float64]:
        """Return the slopes by the lamps' luminance, (k, m)."""
        count = self._count(view)
        found = np.zeros((len(self._unknowns.factors), count))
        for i, factor in enumerate(self._unknowns.factors):
            if factor.name == LUMINANCE and factor.name not in self._cases[view[0]].own:
                found[i] = factor.sigma / factor.value * _brightness(view[1], count)
        return found

    def _count(self, view: View) -> int:
        if view[1] == PITCH:
            return 1 + self._harmonics[view[0]]
        return 2 if view[1] == FLUX else 2 * len(HALF) - 1

    def _read(self, view: View, lit: Lit, middle: bool) -> Reading:
        value, error = self._kept(view[1], lit, middle)
        if view[1] == FLUX:
            source = lit.stack.source
            flux = np.pi * value[0] * source.lit_area
            both = np.array([flux / source.flux, flux])
            spread = (error[0] / value[0]) ** 2
            return np.log(both), np.full((2, 2), spread) * (1 + 1e-9 * np.eye(2))
        if view[1] == DIRECTIONS:
            return read_logarithm(value, error)
        if view[0] not in self._harmonics:
            self._harmonics[view[0]] = _harmonics(view[0], value, error)
        return read_pitch(value, error, self._harmonics[view[0]])

    def _kept(
        self, kind: str, lit: Lit, middle: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return luminances and their errors [cd/m²], traced or from the store."""
        source = source_of(kind, lit)
        paths = self._run_paths * (_MIDDLE if middle else 1) * (_FLUX_SHARE if kind == FLUX else 1)
        blocks = max(8 if middle else 2, round(paths / (len(source.position) * _BLOCK)))
        self.paths += blocks * _BLOCK * len(source.position)
        key = work_key(KIND, {**lit.case, "source": source, "seed": self._seed, "blocks": blocks})
        kept = self._store.read_json(KIND, key)
        if kept is None:
            kept = self._store.keep_json(KIND, key, self._traced(kind, lit, source, blocks))
        return np.array(kept[0]), np.array(kept[1])

    def _traced(self, kind: str, lit: Lit, source: "Source", blocks: int) -> list[list[float]]:
        from mpfcad.measure.rounds import trace_lit

        tally = trace_lit(lit, source, blocks, seed=self._seed, threads=self._threads)
        if np.any(tally.radiance <= 0):
            raise InputError(f"{lit.stack.name}: no light at a point of the {kind}: expected some")
        error = tally.own_error if kind == DIRECTIONS else tally.radiance_error
        return [tally.radiance.tolist(), error.tolist()]


def source_of(kind: str, lit: Lit) -> "Source":
    """Return what a view looks from: over the pitch, from each direction, from all of them."""
    from mpfcad.optics.source import EYE, Source

    stack = lit.stack
    pitch = stack.period.across
    if kind == PITCH:
        return Source(EYE, _POSITION * pitch, lit.spot.width, acceptance=stack.acceptance)
    if kind == FLUX:
        # A meter of acceptance sine 1 sees the hemisphere as Lambertian light arrives.
        return Source(EYE, [pitch / 2], pitch, acceptance=1.0)
    side = np.sin(HALF[1:])
    zero = np.zeros_like(side)
    tilt_x, tilt_y = np.r_[0.0, -side, zero], np.r_[0.0, zero, -side]
    return Source(
        EYE, np.full(len(tilt_x), pitch / 2), pitch, tilt_x=tilt_x, tilt_y=tilt_y,
        acceptance=stack.acceptance,
    )  # fmt: skip


def _brightness(kind: str, count: int) -> NDArray[np.float64]:
    """Return which readings follow the logarithm of the lamps' luminance, (m,) of 0 and 1."""
    found = np.zeros(count)
    if kind == PITCH:
        found[0] = 1
    elif kind == FLUX:
        found[1] = 1
    else:
        found[:] = 1
    return found


def _harmonics(name: str, luminance: NDArray[np.float64], error: NDArray[np.float64]) -> int:
    """Return how many harmonics a case's curve has.

    Raises
    ------
    InputError
        when it is not its own mirror image about the lamps.
    """
    fit = fit_harmonics(_POSITION, luminance, error)
    sines = np.arange(2, len(fit.coefficient), 2)
    part = fit.coefficient[sines]
    chi2 = float(part @ np.linalg.solve(fit.covariance[np.ix_(sines, sines)], part))
    if chi2 > len(sines) + _SKEW * np.sqrt(2 * len(sines)):
        raise InputError(
            f"case.{name}: its luminance is not its own mirror image about the lamps: expected a "
            "film that is placed symmetrically"
        )
    return fit.harmonics
