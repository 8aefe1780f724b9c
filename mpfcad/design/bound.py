"""The least contrast that any map of a range of C can have: a bound over all maps, not a search.

With b = r + T F(C) b, what a path collects beyond the film, cell x has the luminance g F(C_x) b_x.
F(C) is taken as a mixture Σ λ_a F_a of films at some curvatures, free in every cell; maps are the
same on both sides of the lamp. The products y_a = λ_a b are relaxed to what linear inequalities say
of them (McCormick, "Computability of global solutions to factorable nonconvex programs", 1976),

    Σ_a y_a = b,    λ_a lo ≤ y_a ≤ λ_a hi,

lo and hi being the extremes of b over all rules that take another film in every state, by value
iteration (Bellman, "Dynamic programming", 1957). The least Lmax/Lmin under them is a linear
programme once it is made homogeneous (Charnes and Cooper, "Programming with linear fractional
functionals", 1962). Every map is among its points, so none has less. Halving the range of C in one
cell at a time makes the relaxation tighter (branch and bound).
"""

import heapq
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.grid import Grid
from mpfcad.design.optimum import Correction
from mpfcad.design.response import Operators, Response

#: States of the model that is bounded: coarser, so that the linear programmes take seconds.
BOUND_GRID = Grid(cells=18, across=8, along=2)
#: Films that are mixed.
_FILMS = 5
_ROUNDS, _CLOSE = 1000, 1e-4


@dataclass(frozen=True, eq=False)
class _Folded:
    """The operators on one side of the lamp: states by cell, then side and direction.

    Attributes
    ----------
    films
        (m, 2d, 2d) F_a
    seen
        (m, 2d) g F_a
    world
        (cells/2 · 2d)² T
    radiance
        r
    """

    films: NDArray[np.float64]
    seen: NDArray[np.float64]
    world: NDArray[np.float64]
    radiance: NDArray[np.float64]

    @property
    def cells(self) -> int:
        """Cells on one side of the lamp."""
        return len(self.radiance) // self.films.shape[1]


@dataclass(order=True)
class _Part:
    """A part of all maps: the films first … last in each cell; `least` bounds its Lmax/Lmin."""

    least: float
    number: int
    first: NDArray[np.int64] = field(compare=False)
    last: NDArray[np.int64] = field(compare=False)
    worst: int = field(compare=False, default=-1)


def bound_contrast(
    operators: Operators, correction: Correction, low: float, high: float, parts: int = 1
) -> float:
    """Return a contrast that no map with C in low … high [1/mm] goes below, by the model.

    `parts`: linear programmes that are solved at most; more of them raise the bound.
    """
    folded = _fold(operators, np.linspace(low, high, _FILMS))
    corrected = _corrected(operators.grid, correction)
    cells = folded.cells
    whole = _Part(1.0, 0, np.zeros(cells, int), np.full(cells, _FILMS - 1))
    waiting = [_bounded(whole, folded, corrected)]
    for number in range(1, parts, 2):
        part = waiting[0]
        halves = _halves(part, number)
        if not halves:
            break
        heapq.heappop(waiting)
        for half in halves:
            heapq.heappush(waiting, _bounded(half, folded, corrected))
    least = max(waiting[0].least, 1.0)
    return (least - 1) / (least + 1)


def _halves(part: _Part, number: int) -> list[_Part]:
    """Return a part with its worst cell's range of films halved: both halves share one film."""
    if part.worst < 0:
        return []
    first, last = part.first.copy(), part.last.copy()
    middle = (first[part.worst] + last[part.worst]) // 2
    upper = last.copy()
    upper[part.worst] = middle
    lower = first.copy()
    lower[part.worst] = middle
    return [_Part(part.least, number, first, upper), _Part(part.least, number + 1, lower, last)]


def _fold(operators: Operators, curvature: NDArray[np.float64]) -> _Folded:
    """Return the operators of symmetric maps, with films of the given curvatures [1/mm]."""
    from scipy.sparse import csr_array

    response, grid = Response(operators), operators.grid
    d, cells = grid.directions, grid.cells
    n, half = cells * d, cells // 2
    film = response.films(curvature)
    kept = (np.arange(half)[:, None, None] * d + np.array([0, n])[:, None] + np.arange(d)).ravel()
    number = np.full(2 * n, -1)
    number[kept] = np.arange(len(kept))
    image = np.concatenate([grid.mirrored_state, grid.mirrored_state + n])
    column = np.where(number >= 0, number, number[image])
    fold = csr_array((np.ones(2 * n), (np.arange(2 * n), column)), (2 * n, len(kept)))
    world = (operators.world.tocsr()[kept] @ fold).toarray()
    return _Folded(film[:, :-1], response.entry @ film, world, operators.radiance[kept])


def _corrected(grid: Grid, correction: Correction) -> NDArray[np.float64]:
    """Return the matrix of the correction on one side's luminances, (cells/2)²."""
    half = grid.cells // 2
    unit = np.eye(half)
    whole = np.concatenate([unit, unit[::-1]])
    columns = [correction.apply(grid.centre, column)[:half] for column in whole.T]
    return np.array(columns).T


def _allowed(part: _Part) -> NDArray[np.bool_]:
    """Return which films a part allows in each cell, (cells, m)."""
    film = np.arange(_FILMS)
    return (film >= part.first[:, None]) & (film <= part.last[:, None])


def _extremes(
    folded: _Folded, allowed: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the least and largest b over all rules, each state taking an allowed film."""
    found = []
    for sign in (-1.0, 1.0):
        # From a bound on the far side, so that every round keeps one.
        b = folded.radiance.copy() if sign < 0 else _ceiling(folded)
        for _ in range(_ROUNDS):
            by_film = np.einsum("mij,cj->cmi", folded.films, b.reshape(folded.cells, -1))
            by_film = np.where(allowed[:, :, None], sign * by_film, -np.inf)
            new = folded.radiance + folded.world @ (sign * by_film.max(axis=1)).ravel()
            change = np.abs(new - b).max()
            b = new
            if change < _CLOSE * b.max():
                break
        found.append(b)
    return found[0], found[1]


def _ceiling(folded: _Folded) -> NDArray[np.float64]:
    """Return a b that no rule exceeds: the largest radiance over the least loss of a round."""
    kept = folded.world.sum(axis=1).max() * folded.films.sum(axis=2).max()
    return np.full_like(folded.radiance, folded.radiance.max() / (1 - min(kept, 0.999)))


def _bounded(part: _Part, folded: _Folded, corrected: NDArray[np.float64]) -> _Part:
    """Return the part with its bound, and the cell in which the relaxation is loosest."""
    from scipy.optimize import linprog
    from scipy.sparse import csr_array, diags_array, eye_array, hstack, kron, vstack

    allowed = _allowed(part)
    low, high = _extremes(folded, allowed)
    films, size = folded.films.shape[:2]
    pairs = folded.cells * films
    count = pairs * size
    # Unknowns: y by cell, film and state; λ by cell and film; the scale; Lmax. Lmin is 1.
    total = count + pairs + 2
    balance, share, seen = _rows(folded, total)
    each = kron(eye_array(pairs), np.ones((size, 1)), format="csr")
    spread = [np.repeat(b.reshape(-1, 1, size), films, axis=1).ravel() for b in (low, high)]
    rest = csr_array((count, 2))
    luminance = corrected @ seen
    top = luminance.copy()
    top[:, -1] -= 1
    matrix = [
        hstack([eye_array(count), -diags_array(spread[1]) @ each, rest]),
        hstack([-eye_array(count), diags_array(spread[0]) @ each, rest]),
        csr_array(top),
        csr_array(-luminance),
    ]
    bound = np.concatenate([np.zeros(2 * count + len(top)), -np.ones(len(top))])
    limits: list[tuple[int, int | None]] = [(0, None)] * count
    limits += [(0, None if one else 0) for one in allowed.ravel()] + [(0, None)] * 2
    found = linprog(
        np.append(np.zeros(total - 1), 1.0),
        A_ub=vstack(matrix, format="csr"),
        b_ub=bound,
        A_eq=csr_array(np.concatenate([balance, share])),
        b_eq=np.zeros(len(balance) + len(share)),
        bounds=limits,
        method="highs",
    )
    if found.x is None:
        # No map of this part is left.
        return _Part(np.inf, part.number, part.first, part.last)
    return _Part(
        max(found.fun, part.least),
        part.number,
        part.first,
        part.last,
        _loosest(found.x, part, folded),
    )


def _rows(
    folded: _Folded, total: int
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the rows of b = r + T Σ F y, of Σ λ = 1, and of the luminances."""
    films, size = folded.films.shape[:2]
    pairs = folded.cells * films
    count = pairs * size
    balance = np.zeros((len(folded.radiance), total))
    share, seen = np.zeros((folded.cells, total)), np.zeros((folded.cells, total))
    for cell in range(folded.cells):
        own = slice(cell * size, (cell + 1) * size)
        for film in range(films):
            pair = cell * films + film
            columns = slice(pair * size, (pair + 1) * size)
            balance[:, columns] = -folded.world[:, own] @ folded.films[film]
            balance[own, columns] += np.eye(size)
            seen[cell, columns] = folded.seen[film]
            share[cell, count + pair] = 1
    balance[:, -2] = -folded.radiance
    share[:, -2] = -1
    return balance, share, seen


def _loosest(solution: NDArray[np.float64], part: _Part, folded: _Folded) -> int:
    """Return the cell whose y is furthest from λ b, of those whose range can be halved; or -1."""
    films, size = folded.films.shape[:2]
    count = folded.cells * films * size
    y = solution[:count].reshape(folded.cells, films, size)
    share = solution[count : count + folded.cells * films].reshape(folded.cells, films)
    b = y.sum(axis=1, keepdims=True) / solution[-2]
    gap = np.abs(y - share[:, :, None] * b).sum(axis=(1, 2))
    gap[part.last - part.first < 2] = -1.0
    return int(np.argmax(gap)) if gap.max() > 0 else -1
