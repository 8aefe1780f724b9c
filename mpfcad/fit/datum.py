"""A measured figure beside what the readings predict for it."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from mpfcad.fit.linear import Line, noise_of_lines
from mpfcad.fit.reading import Figure

_STEP = 1e-3


@dataclass(frozen=True, eq=False)
class Figured:
    """A figure of a view, or of one view over another.

    Attributes
    ----------
    name
        in words
    view, over
        (case, kind) of the view, and of the one that it is divided by
    figure
        what is read
    """

    name: str
    view: tuple[str, str]
    figure: Figure
    over: tuple[str, str] | None = None

    @property
    def views(self) -> list[tuple[str, str]]:
        """The views that it needs."""
        return [self.view] if self.over is None else [self.view, self.over]

    def predict(
        self, lines: dict[tuple[str, str], Line], steps: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the figure at steps (k,), (d,)."""
        return self._of(lines, {v: lines[v].reading(steps) for v in self.views})

    def _of(
        self,
        lines: dict[tuple[str, str], Line],
        readings: dict[tuple[str, str], NDArray[np.float64]],
    ) -> NDArray[np.float64]:
        found = self.figure(readings[self.view], lines[self.view].start_covariance)
        if self.over is None:
            return found
        return found / self.figure(readings[self.over], lines[self.over].start_covariance)

    def jacobian(
        self, lines: dict[tuple[str, str], Line], steps: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the figure's derivative by the steps, (d, k), of central differences."""
        columns = []
        for i in range(len(steps)):
            away = np.zeros(len(steps))
            away[i] = _STEP
            high, low = self.predict(lines, steps + away), self.predict(lines, steps - away)
            columns.append((high - low) / (2 * _STEP))
        return np.stack(columns, axis=1)

    def gain(
        self, lines: dict[tuple[str, str], Line], steps: NDArray[np.float64]
    ) -> dict[tuple[str, str], NDArray[np.float64]]:
        """Return the figure's derivative by the readings of each view, (d, m)."""
        base = {v: lines[v].reading(steps) for v in self.views}
        found = {}
        for view in self.views:
            step = 1e-5
            columns = []
            for j in range(len(base[view])):
                ends = []
                for sign in (step, -step):
                    moved = base[view].copy()
                    moved[j] += sign
                    ends.append(self._of(lines, {**base, view: moved}))
                columns.append((ends[0] - ends[1]) / (2 * step))
            found[view] = np.stack(columns, axis=1)
        return found

    def drawn(
        self,
        lines: dict[tuple[str, str], Line],
        steps: NDArray[np.float64],
        covariance: NDArray[np.float64],
        within: NDArray[np.float64],
        draws: int,
    ) -> NDArray[np.float64]:
        """Return the figure of backlights that may be the true one, (draws, d).

        Readings are drawn, and the figure is taken of each: a contrast does not follow the values
        along a straight line where its curve is nearly flat. `covariance` (k, k): of the steps;
        `within`: the same where the traces' noise is counted.
        """
        views = [lines[view] for view in self.views]
        slope = np.hstack([line.slope for line in views])
        spread = slope.T @ covariance @ slope + noise_of_lines(views, steps, within)
        value, vector = np.linalg.eigh(spread)
        root = vector * np.sqrt(np.maximum(value, 0))
        rng = np.random.Generator(np.random.Philox(0))
        middle = np.concatenate([line.reading(steps) for line in views])
        found = middle + rng.standard_normal((draws, len(middle))) @ root.T
        ends = np.cumsum([len(line.start) for line in views])[:-1]
        parts = [np.split(one, ends) for one in found]
        return np.array([self._exactly(part) for part in parts])

    def _exactly(self, readings: list[NDArray[np.float64]]) -> NDArray[np.float64]:
        """Return the figure of readings without noise."""
        found = [self.figure(one, np.zeros((len(one), len(one)))) for one in readings]
        return found[0] if self.over is None else found[0] / found[1]

    def noise(
        self,
        lines: dict[tuple[str, str], Line],
        steps: NDArray[np.float64],
        covariance: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return the covariance (d, d) of the prediction that the traces leave."""
        gains = self.gain(lines, steps)
        gain = np.hstack(list(gains.values()))
        together = noise_of_lines([lines[view] for view in gains], steps, covariance)
        found: NDArray[np.float64] = gain @ together @ gain.T
        return found


@dataclass(frozen=True, eq=False)
class Datum:
    """A measured figure.

    Attributes
    ----------
    figured
        what was measured
    value, covariance
        (d,), (d, d) float64
    side
        0: as measured; 1: at least the value; -1: at most
    label
        of each of the d numbers
    """

    figured: Figured
    value: NDArray[np.float64]
    covariance: NDArray[np.float64]
    side: int = 0
    label: tuple[str, ...] = field(default=("",))

    @property
    def name(self) -> str:
        """What was measured, in words."""
        return self.figured.name

    def off(self, predicted: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return predicted less measured, (d,); 0 on the free side of a limit."""
        away = predicted - self.value
        if self.side == 0:
            return away
        return np.minimum(away, 0.0) if self.side > 0 else np.maximum(away, 0.0)
