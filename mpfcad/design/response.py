"""The two-scale model of a backlight: the luminance of any curvature map, and its derivatives.

A ray alternates between the film and the world around it (lamps, reflector, plate, sheets). Both
are linear operators on the states of `Grid`: the film's depends on its curvature there, the world's
not on the film. With v the radiance that a backward path collects from meeting the film on,

    v = F(C) (r + T v),     luminance = g F(C) (r + T v),

T and r: where the world sends what leaves the film, and the light it adds; g: where the meter's
rays meet the film. T, r, g and F at some curvatures are estimated once, by short traces.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.design.grid import Grid
from mpfcad.errors import TraceError

#: Harmonics of the lamp pitch in a luminance of the model; what is beyond is noise of the traces.
HARMONICS = 6


@dataclass(frozen=True, eq=False)
class Operators:
    """What the short traces give.

    Attributes
    ----------
    grid
        the states; n = cells · d of them on each side of the film
    node
        (m,) float64 [1/mm], curvatures at which the film was traced
    film
        (m, 2d+1, 2d) float64, shares by entry (from below, from above, the meter's cone) and exit
        (up, down)
    world
        T, sparse (2n, 2n): rows are exits (up, down), columns meetings (from below, from above)
    radiance
        (2n,) float64 r [cd/m²]
    meter
        (d+1,) float64 g: from above by direction; last, straight from the meter
    passages, segments
        rays traced through the film alone, and from the film back to it
    """

    grid: Grid
    node: NDArray[np.float64]
    film: NDArray[np.float64]
    world: Any
    radiance: NDArray[np.float64]
    meter: NDArray[np.float64]
    passages: int
    segments: int


@dataclass(frozen=True, eq=False)
class Response:
    """Luminances and derivatives of curvature maps, by the operators."""

    operators: Operators

    @property
    def grid(self) -> Grid:
        """The cells in which curvature and luminance are given."""
        return self.operators.grid

    @cached_property
    def _cardinal(self) -> Any:
        """The spline that is 1 at one node and 0 at the others, for each; and its derivative."""
        from scipy.interpolate import CubicSpline

        spline = CubicSpline(
            self.operators.node, np.eye(len(self.operators.node)), bc_type="natural"
        )
        return spline, spline.derivative()

    def films(self, curvature: NDArray[np.float64], order: int = 0) -> NDArray[np.float64]:
        """Return F or dF/dC of each cell, (cells, 2d+1, 2d)."""
        node = self.operators.node
        weight = self._cardinal[order](np.clip(curvature, node[0], node[-1]))
        flat = self.operators.film.reshape(len(node), -1)
        return (weight @ flat).reshape(len(curvature), *self.operators.film.shape[1:])

    def _after(self, v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return r + T v, what leaving the film up or down collects, by cell, (cells, 2d)."""
        return self._by_cell(self.operators.radiance + self.operators.world @ v)

    def _by_cell(self, state: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a (2n,) vector as (cells, 2d)."""
        cells, d = self.grid.cells, self.grid.directions
        return state.reshape(2, cells, d).transpose(1, 0, 2).reshape(cells, 2 * d)

    def _by_side(self, cell: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a (cells, 2d) array as (2n,): the inverse of `_by_cell`."""
        cells, d = self.grid.cells, self.grid.directions
        return cell.reshape(cells, 2, d).transpose(1, 0, 2).reshape(-1)

    def _solve(self, film: NDArray[np.float64], start: NDArray[np.float64] | None = None) -> Any:
        """Return v of the maps's films, (2n,)."""
        from scipy.sparse.linalg import LinearOperator, gmres

        inner = film[:, :-1]
        size = len(self.operators.radiance)

        def after_film(state: NDArray[np.float64]) -> NDArray[np.float64]:
            return self._by_side(np.einsum("xij,xj->xi", inner, self._by_cell(state)))

        def left(v: NDArray[np.float64]) -> NDArray[np.float64]:
            return v - after_film(self.operators.world @ v)

        matrix = LinearOperator((size, size), matvec=left, dtype=float)
        right = after_film(self.operators.radiance)
        v, failed = gmres(matrix, right, x0=start, rtol=1e-7, restart=60, maxiter=20)
        _check_solved(failed)
        return v

    @cached_property
    def entry(self) -> NDArray[np.float64]:
        """Share of the meter's rays by the film's rows of entry, (2d+1,)."""
        return np.concatenate([np.zeros(self.grid.directions), self.operators.meter])

    def luminance(self, curvature: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the luminance [cd/m²] over each cell, (cells,), of curvatures [1/mm], (cells,)."""
        return self.smooth @ self.raw_luminance(curvature)

    def raw_luminance(self, curvature: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the luminance as `luminance` does, with the noise beyond its harmonics."""
        film = self.films(curvature)
        after = self._after(self._solve(film))
        return np.einsum("i,xij,xj->x", self.entry, film, after)

    def jacobian(
        self, curvature: NDArray[np.float64], *, symmetric: bool = False
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the luminance (cells,) and its derivative by the curvature of each cell.

        The derivative is (cells of luminance, cells of curvature) float64 [cd/m² per 1/mm];
        `symmetric` maps save half of the work. From the adjoint: with p_i the solution of
        p = T'(F' p + F' g_i), row i is Σ (p + g_i) dF/dC (r + T v) over each cell.
        """
        cells = self.grid.cells
        wanted = np.eye(cells)[: (cells + 1) // 2] if symmetric else np.eye(cells)
        luminance, rows = self.derivative(curvature, wanted)
        if symmetric:
            rows = np.concatenate([rows, rows[: cells // 2][::-1, ::-1]])
        return self.smooth @ luminance, self.smooth @ rows

    def derivative(
        self, curvature: NDArray[np.float64], weight: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the unsmoothed luminance L and the derivatives of some sums weight · L.

        That is (cells,) and, for weights (m, cells), (m, cells) float64, as in `jacobian`.
        """
        film, slope = self.films(curvature), self.films(curvature, 1)
        after = self._after(self._solve(film))
        luminance = np.einsum("i,xij,xj->x", self.entry, film, after)
        # What a change of F in each cell adds to what is collected there, by row of entry.
        change = np.einsum("xij,xj->xi", slope, after)
        direct = change @ self.entry
        rows = np.empty((len(weight), self.grid.cells))
        for row, part in zip(rows, weight, strict=True):
            importance = self._importance(film, part)
            row[:] = np.einsum("xi,xi->x", importance, change[:, :-1]) + part * direct
        return luminance, rows

    @cached_property
    def smooth(self) -> NDArray[np.float64]:
        """Take a luminance's first `HARMONICS` harmonics, (cells, cells)."""
        angle = 2 * np.pi * np.outer(self.grid.centre, np.arange(1, HARMONICS + 1))
        basis = np.concatenate([np.ones((len(angle), 1)), np.cos(angle), np.sin(angle)], axis=1)
        return basis @ np.linalg.pinv(basis)

    def _importance(
        self, film: NDArray[np.float64], weight: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return how much of meters' light, weighted by cell, meets the film in each state."""
        from scipy.sparse.linalg import LinearOperator, gmres

        inner = film[:, :-1]
        size = len(self.operators.radiance)

        def through(state: NDArray[np.float64]) -> NDArray[np.float64]:
            leaving = np.einsum("xij,xi->xj", inner, self._by_cell(state))
            return self._transposed @ self._by_side(leaving)

        first = weight[:, None] * np.einsum("i,xij->xj", self.entry, film)
        right = self._transposed @ self._by_side(first)
        matrix = LinearOperator((size, size), matvec=lambda p: p - through(p), dtype=float)
        p, failed = gmres(matrix, right, rtol=1e-6, restart=60, maxiter=20)
        _check_solved(failed)
        return self._by_cell(p)

    @cached_property
    def _transposed(self) -> Any:
        return self.operators.world.T.tocsr()


def _check_solved(failed: int) -> None:
    if failed:
        raise TraceError(f"two-scale model: no solution after {failed} iterations")
