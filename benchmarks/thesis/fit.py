"""Published figures in, assumed values out: least squares on the response surfaces."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from thesis.response import Surface, contrast

PUBLISHED = Path(__file__).with_name("published.toml")
#: Codes beyond this were not traced.
REACH = 1.25
#: χ² above its least at the ends of a 95 % interval of one value.
RISE = 3.84
_GRID = 21


@dataclass(frozen=True)
class Target:
    """A published figure that the fit aims at; see published.toml."""

    name: str
    family: str
    curvature_per_mm: float
    of: str
    kind: str
    value: float
    rounding: float
    allowance: float

    def ours(self, surfaces: dict[str, Surface], code: NDArray[np.float64]) -> float:
        """Return our figure at codes."""
        reading = surfaces[self.family](code, self.curvature_per_mm)
        return contrast(reading[1:]) if self.of == "contrast" else float(np.exp(reading[0]))

    def residual(self, ours: float, error: float) -> float:
        """Return how far ours lies off, in standard deviations; 0 on the free side of a limit."""
        sigma = np.sqrt(self.allowance**2 + self.rounding**2 / 3 + error**2)
        away = (ours - self.value) / sigma
        limited = {"equal": away, "at_most": max(0.0, away), "at_least": min(0.0, away)}
        return float(limited[self.kind])


def read_targets(path: Path = PUBLISHED) -> list[Target]:
    """Return the targets of a file of published figures."""
    return [Target(**entry) for entry in tomllib.loads(path.read_text("utf-8"))["target"]]


@dataclass(frozen=True, eq=False)
class StackFit:
    """What the published figures say about the assumed values, in codes.

    Attributes
    ----------
    code
        (k,) the fitted set: the data, and a prior of one step about the trials' centre
    interval
        (k, 2) 95 % profile interval of each code with that prior
    data_interval
        (k, 2) the same by the data alone within ±`REACH`; ends at ±`REACH` are no ends
    singular, direction
        (m,) and (m, k): singular values of the weighted Jacobian and their combinations of codes.
        A combination of singular value s is known to 1/s steps
    residual, error
        (t,) of each target: off in standard deviations; standard error of ours from the surfaces
    """

    code: NDArray[np.float64]
    interval: NDArray[np.float64]
    data_interval: NDArray[np.float64]
    singular: NDArray[np.float64]
    direction: NDArray[np.float64]
    residual: NDArray[np.float64]
    error: NDArray[np.float64]

    @property
    def held(self) -> NDArray[np.float64]:
        """Share of each value's prior variance that the data take away, (k,) 0…1."""
        gain = self.singular**2 / (1 + self.singular**2)
        return (gain[:, None] * self.direction**2).sum(0)


def fit_values(
    surfaces: dict[str, Surface], targets: list[Target], factors: int, draws: int = 40
) -> StackFit:
    """Return the fit; starts at the trials' centre, so equal inputs give equal results."""
    from scipy.optimize import least_squares

    error = _errors(surfaces, targets, factors, draws)

    def data(code: NDArray) -> NDArray:
        return np.array(
            [t.residual(t.ours(surfaces, code), e) for t, e in zip(targets, error, strict=True)]
        )

    def solve(start: NDArray, prior: float, fixed: int | None = None, at: float = 0.0) -> NDArray:
        """Return the best codes, one of them fixed; prior: weight of a step off the centre."""
        free = np.arange(factors) != (-1 if fixed is None else fixed)

        def whole(part: NDArray) -> NDArray:
            code = np.full(factors, at)
            code[free] = part
            return code

        def residual(part: NDArray) -> NDArray:
            code = whole(part)
            return np.r_[data(code), prior * code]

        low = np.full(free.sum(), -REACH)
        part = np.clip(start[free], -0.99 * REACH, 0.99 * REACH)
        found = least_squares(residual, part, bounds=(low, -low), diff_step=1e-3, xtol=1e-6)
        return whole(found.x)

    def profile(best: NDArray, prior: float) -> NDArray:
        """Return the ends of each code's interval, (k, 2)."""

        def chi2(code: NDArray) -> float:
            return float((data(code) ** 2).sum() + (prior * code @ code * prior))

        ends = np.empty((factors, 2))
        least = chi2(best)
        for i in range(factors):
            for side, sign in enumerate((-1, 1)):
                start, last, rise = best, best[i], 0.0
                ends[i, side] = sign * REACH
                for at in np.linspace(best[i], sign * REACH, _GRID // 2)[1:]:
                    start = solve(start, prior, i, at)
                    now = chi2(start) - least
                    if now > RISE:
                        # χ² grows as the square of the way: its root is nearly straight.
                        ends[i, side] = np.interp(RISE**0.5, np.sqrt([rise, now]), [last, at])
                        break
                    last, rise = at, max(0.0, now)
        return ends

    best = solve(np.zeros(factors), 1.0)
    # So weak a prior only chooses among sets that fit alike.
    faint = 0.05
    data_best = solve(best, faint)
    step = 0.02 * np.eye(factors)
    jacobian = np.array([(data(best + s) - data(best - s)) / 0.04 for s in step]).T
    _, singular, direction = np.linalg.svd(jacobian, full_matrices=False)
    return StackFit(
        best, profile(best, 1.0), profile(data_best, faint), singular, direction, data(best), error
    )


def _errors(surfaces, targets, factors: int, draws: int) -> NDArray[np.float64]:
    """Return the standard error of our figures at the centre from the surfaces' own, (t,)."""
    centre = np.zeros(factors)
    drawn = {name: surface.draws(draws, 1) for name, surface in surfaces.items()}
    return np.array(
        [np.std([t.ours({t.family: s}, centre) for s in drawn[t.family]]) for t in targets]
    )
