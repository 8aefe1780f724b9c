"""The published method (Hsieh, MPF thesis, chapter 6), as the measure of the other.

1. Trace uniform films of several C.
2. The largest luminance that one of them reaches at half the pitch is the target; at each position
   take the C whose uniform film gives the target there: the initial map.
3. Trace the patterned film; where it is brighter than at half the pitch raise C, where it is darker
   lower it; repeat.

The thesis does not say by how much: here by the excess over the slope of ln L(0)/L(0.5) between the
uniform films of smallest and largest C.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.cosine import Constraint, project, row_position, series_rows
from mpfcad.design.search import Iteration, Traced, TraceRows


def search_by_inversion(
    uniform: Sequence[float],
    constraint: Constraint,
    pitch: float,
    trace: TraceRows,
    *,
    iterations: int,
    contrast_target: float,
    finish: Callable[[NDArray[np.float64]], NDArray[np.float64]] = lambda rows: rows,
) -> list[Iteration]:
    """Return the traced films: the uniform ones of C in `uniform` [1/mm], then the patterned."""
    position = row_position()
    done: list[Iteration] = []

    def make(rows: NDArray[np.float64], series: NDArray[np.float64], label: str) -> Traced:
        traced = trace(rows, label, len(done), 0.0)
        curvature, coefficient = (tuple(map(float, part)) for part in (rows, series))
        done.append(Iteration(label, curvature, coefficient, None, None, traced))
        return traced

    films = [
        make(np.full(len(position), float(c)), np.array([c]), f"uniform C = {c:g} /mm")
        for c in uniform
    ]
    curve = np.array([film.curve(position) for film in films])
    middle = len(position) // 2
    wanted = invert(np.array(uniform, float), curve, float(curve[:, middle].max()))
    ratio = np.log(curve[:, 0] / curve[:, middle])
    gain = abs((uniform[-1] - uniform[0]) / (ratio[-1] - ratio[0]))
    for number in range(iterations):
        series = project(position, wanted, constraint, pitch)
        rows = finish(series_rows(series)[1])
        traced = make(rows, series, f"patterned {number + 1}")
        if traced.contrast_high <= contrast_target:
            break
        excess = traced.curve(position) / traced.curve(position[middle : middle + 1]) - 1
        wanted = series_rows(series)[1] + gain * (excess + excess[::-1]) / 2
    return done


def invert(
    uniform: NDArray[np.float64], luminance: NDArray[np.float64], target: float
) -> NDArray[np.float64]:
    """Return the C [1/mm] at each position whose uniform film has the luminance `target` there.

    Between films luminance is linear in C; of several solutions the largest C is taken, of none the
    nearest film. `luminance` is (films, positions) [cd/m²].
    """
    found = uniform[np.argmin(np.abs(luminance - target), axis=0)]
    for i in range(len(uniform) - 1):
        here, there = luminance[i] - target, luminance[i + 1] - target
        crosses = here * there <= 0
        share = np.divide(here, here - there, out=np.zeros_like(here), where=here != there)
        found = np.where(crosses, uniform[i] + share * (uniform[i + 1] - uniform[i]), found)
    return found
