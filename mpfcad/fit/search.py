"""Values sought in rounds: traces about the last values, a fit, until they move no more."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence import STEP, factorial_steps
from mpfcad.fit.datum import Datum
from mpfcad.fit.linear import Line, fit_line, flat_line
from mpfcad.fit.posterior import Lines, Posterior, fit_values
from mpfcad.fit.unknown import Unknowns

#: Settled: the last move over the widths left, root mean square over all directions.
SETTLED = 0.5
MOST_ROUNDS = 4
#: Widths left below it, in the prior's, are not traced: noise would hide so small a change.
_NARROW = 0.3
#: Later rounds go so many of the widths left in each direction, that is as far in each value.
_LATER = 1.0

View = tuple[str, str]
Reading = tuple[NDArray[np.float64], NDArray[np.float64]]


class Tracer(Protocol):
    """What traces a view with values changed."""

    def trace(self, view: View, steps: NDArray[np.float64], *, middle: bool) -> Reading:
        """Return what is read at steps (k,), and its covariance; `middle`: with more paths."""

    def active(self, view: View) -> NDArray[np.bool_]:
        """Return which values a view depends on, (k,)."""

    def known(self, view: View) -> NDArray[np.float64]:
        """Return slopes that need no trace, (k, m)."""


@dataclass(frozen=True, eq=False)
class Found:
    """What a search ends with.

    Attributes
    ----------
    posterior
        values and what is left
    lines
        about the last middle
    moves
        of each round: the way over the widths left
    """

    posterior: Posterior
    lines: Lines
    moves: tuple[float, ...]

    @property
    def is_settled(self) -> bool:
        """Whether the last lines were traced where the values ended."""
        return self.moves[-1] < SETTLED


def search_values(
    tracer: Tracer,
    views: list[View],
    data: list[Datum],
    unknowns: Unknowns,
    tell: Callable[[str], None] = lambda text: None,
) -> Found:
    """Return the values that the data hold, re-traced where they lie until they move no more.

    Gauss's and Newton's method: readings are straight lines through a two-level factorial of runs
    about the last values, which share their random numbers. The first factorial spans the prior,
    the next what the last fit has left.
    """
    at: NDArray[np.float64] = np.zeros(len(unknowns.factors))
    moves: list[float] = []
    steps = _first_steps(unknowns)
    while True:
        lines = {}
        for place, view in enumerate(views, 1):
            tell(f"round {len(moves) + 1}: {view[0]}, {view[1]} ({place} of {len(views)})")
            lines[view] = trace_line(tracer, view, at, _within(at + steps, unknowns))
        posterior = fit_values(lines, data, unknowns)
        away = posterior.steps - at
        moves.append(float(np.sqrt(away @ np.linalg.solve(posterior.covariance, away) / len(at))))
        if len(moves) >= MOST_ROUNDS or (len(moves) > 1 and moves[-1] < SETTLED):
            return Found(posterior, lines, tuple(moves))
        at = posterior.steps
        steps = _later_steps(posterior.covariance, unknowns)


def trace_line(
    tracer: Tracer, view: View, at: NDArray[np.float64], steps: NDArray[np.float64]
) -> Line:
    """Return a view's straight line about `at` from runs at steps (n, k)."""
    start, covariance = tracer.trace(view, at, middle=True)
    is_active = tracer.active(view)
    if not is_active.any():
        return replace(flat_line(at, len(steps), start, covariance), slope=tracer.known(view))
    only = np.where(is_active, steps, at)
    found = np.array([tracer.trace(view, row, middle=False)[0] for row in only])
    line = fit_line(at, only, found, start, covariance, is_active)
    return replace(line, slope=line.slope + tracer.known(view))


def _first_steps(unknowns: Unknowns) -> NDArray[np.float64]:
    return distinct_steps(len(unknowns.factors))


def distinct_steps(count: int) -> NDArray[np.float64]:
    """Return a two-level factorial's steps, (n, count), no two alike.

    Runs that a factorial of few values repeats would read the same again, for all runs share their
    random numbers: they would tell of no scatter. Each repetition goes less far, down to half; main
    effects stay free of each other, as each repetition is a factorial of its own.
    """
    steps = factorial_steps(count)
    _, group = np.unique(steps, axis=0, return_inverse=True)
    group = group.reshape(-1)
    before = np.array([np.count_nonzero(group[:i] == group[i]) for i in range(len(group))])
    found: NDArray[np.float64] = steps * (1 - 0.5 * before / (before.max() + 1))[:, None]
    return found


def _later_steps(covariance: NDArray[np.float64], unknowns: Unknowns) -> NDArray[np.float64]:
    """Return steps along the principal directions of what is left, (n, k)."""
    value, vector = np.linalg.eigh(covariance)
    size = np.clip(np.sqrt(np.maximum(value, 0)), _NARROW, 1.0)
    found: NDArray[np.float64] = (
        (_LATER / STEP) * distinct_steps(len(unknowns.factors)) * size
    ) @ vector.T
    return found


def _within(steps: NDArray[np.float64], unknowns: Unknowns) -> NDArray[np.float64]:
    """Return steps cut off a little inside of what the values can be."""
    low, high = unknowns.limits()
    room = np.minimum(0.02, (high - low) / 4)
    return np.clip(steps, low + room, high - room)


def later_lines(
    tracer: Tracer,
    views: list[View],
    found: Found,
    unknowns: Unknowns,
    tell: Callable[[str], None] = lambda text: None,
) -> Found:
    """Return what was found with the lines of further views, traced about the values found."""
    posterior, lines = found.posterior, dict(found.lines)
    steps = _within(posterior.steps + _later_steps(posterior.covariance, unknowns), unknowns)
    new = [view for view in views if view not in lines]
    for place, view in enumerate(new, 1):
        tell(f"what is asked for: {view[0]}, {view[1]} ({place} of {len(new)})")
        lines[view] = trace_line(tracer, view, posterior.steps, steps)
    return replace(found, lines=lines)
