"""What a profiler's own response does to a trace: heights that follow late, or ring after an edge.

Of a surface S such an instrument writes

    z(x) = S(x) + Σ b_j (S(x - t_j) - S(x)),

where all t_j lie on the side that the stylus comes from. A groove is its own mirror image, and such
a response is not: so the residual tells it, and from which side the stylus came. Its mirror-like
half rounds and lifts what it follows as resin of another fill would: that is by how much C and
fill are off.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.stylus.bound.half_width import derivatives_of, free_columns
from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import PITCH, TraceModel
from mpfcad.film.stylus.solve import Fitted
from mpfcad.units import nm, um

#: Distances behind the stylus [mm], and the prior deviation of a share b_j.
_LAGS, _SHARE_OFF = (0.5 * um, 1.0 * um, 2.0 * um, 4.0 * um), 0.1
#: By how much the sum of squares over noise² must fall more than by a response from the other side:
#: that of so many shares falls by more in 1 of 1000 traces without one.
_TOLD = 18.5


@dataclass(frozen=True)
class Response:
    """By how much a response that the residual tells moved the mean u, and ln C; 0: none is told.

    `late` is what of it no other value makes up for, rms [mm].
    """

    u: float = 0.0
    log_curvature: float = 0.0
    late: float = 0.0

    @property
    def words(self) -> str:
        """Return it in one line; empty where none is told."""
        if not self.late:
            return ""
        return (
            f"heights follow the surface late, or ring after its edges ({self.late / nm:.2g} nm "
            f"rms, to one side alone): C may read {self.log_curvature:+.2%} off: the interval "
            "holds it"
        )


def response_of(
    fit: Fitted, columns: NDArray[np.float64], noise: float, known: tuple[int, ...]
) -> Response:
    """Return what the residual tells of the instrument's response.

    columns: (n, k), `design_of`'s. noise: of heights [mm], as if they were independent. known:
    values that are.
    """
    model, value = fit.model, fit.value
    free, design, prior = free_columns(fit, columns, known)
    whole, rows = np.concatenate([design, noise * prior]), len(prior)
    basis = np.linalg.qr(whole)[0]
    left = np.concatenate([model.residual(value), np.zeros(rows)])
    sides = [_of_side(model, value, left, basis, side) for side in (1.0, -1.0)]
    best, other = sorted(sides, key=lambda each: each.left)
    rest = left[: len(model.x)] - best.seen
    level = float(np.mean(rest**2)) * correlation_sum(rest)
    if other.left - best.left < _TOLD * level:
        return Response()
    follow = np.concatenate([best.follow, np.zeros(rows)])
    moved = np.linalg.lstsq(whole, follow, rcond=None)[0]
    u, log_curvature = derivatives_of(fit, free, design.shape[1])[:2] @ moved
    return Response(float(u), float(log_curvature), float(np.sqrt(np.mean(best.seen**2))))


@dataclass(frozen=True, eq=False)
class _Side:
    """What is left of the residual's squares, what is seen in it, and the response, (n,) [mm]."""

    left: float
    seen: NDArray[np.float64]
    follow: NDArray[np.float64]


def _of_side(
    model: TraceModel,
    value: NDArray[np.float64],
    left: NDArray[np.float64],
    basis: NDArray[np.float64],
    side: float,
) -> _Side:
    """Return the response from one side that fits best; left: the residual, and zeros of priors."""
    there = model.surface(value)
    follow = np.stack([_moved(model, value, side * lag) - there for lag in _LAGS], axis=1)
    padded = np.concatenate([follow, np.zeros((len(left) - len(there), len(_LAGS)))])
    inner = padded - basis @ (basis.T @ padded)
    size = float(np.mean(left**2)) / _SHARE_OFF**2
    share = np.linalg.solve(inner.T @ inner + size * np.eye(len(_LAGS)), inner.T @ left)
    seen = inner @ share
    return _Side(float(np.sum((left - seen) ** 2)), seen[: len(there)], follow @ share)


def _moved(model: TraceModel, value: NDArray[np.float64], by: float) -> NDArray[np.float64]:
    """Return the traced height at x - by, (n,) [mm]."""
    local, number = model.place(value)
    local, pitch = local - by, float(value[PITCH])
    turn = np.round(local / pitch).astype(np.int64)
    number = np.clip(number + turn, 0, model.grooves - 1)
    return model.traced_at(value, local - turn * pitch, number)
