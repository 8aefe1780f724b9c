"""Stylus traces: height over position across the grooves, as a profiler measured it."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.units import um

#: Points that a trace must have in each prism width; its largest step is the pitch over half of it.
FEWEST_POINTS = 20


@dataclass(frozen=True, eq=False)
class StylusTrace:
    """Heights measured across the grooves; tilt, offset and the place of the grooves are unknown.

    Attributes
    ----------
    position, height
        (n,) float64 [mm]; positions increase
    name
        of the file, for messages
    tip
        the stylus's, if stated
    reading
        what was understood of the file, in one line
    either
        whether it may as well lie upside down
    """

    position: NDArray[np.float64]
    height: NDArray[np.float64]
    name: str
    tip: StylusTip | None = None
    reading: str = ""
    either: bool = False

    def turned(self) -> "StylusTrace":
        """Return the trace upside down."""
        return replace(self, height=-self.height)

    def middle(self, width: float) -> "StylusTrace":
        """Return the middle `width` [mm] of the trace, its two ends as far from the middle."""
        start = (self.position[0] + self.position[-1] - width) / 2
        inside = (self.position >= start) & (self.position < start + width)
        return replace(self, position=self.position[inside], height=self.height[inside])

    def widths(self, pitch: float) -> int:
        """Return how many whole prism widths of `pitch` [mm] the trace holds."""
        step = float(np.median(np.diff(self.position)))
        return int((self.position[-1] - self.position[0] + step) / pitch * (1 + 1e-9))


def check_sampling(
    path: Path, x: NDArray[np.float64], lines: list[int], pitch: float, prism_widths: int
) -> None:
    """Refuse a trace that is too short or too coarse to tell the shape of a groove.

    Raises
    ------
    InputError
        naming the row, its value and what was expected.
    """
    if len(x) < FEWEST_POINTS * prism_widths:
        raise InputError(
            f"{path}: {len(x)} rows: expected {FEWEST_POINTS * prism_widths} or more, "
            f"{FEWEST_POINTS} a prism width"
        )
    length, step = x[-1] - x[0], np.diff(x)
    if length + np.median(step) < prism_widths * pitch * (1 - 1e-9):
        raise InputError(
            f"{path}: x_um: {length / um:.6g} µm long: expected {prism_widths * pitch / um:g} µm "
            f"or more, {prism_widths} prism widths of {pitch / um:g} µm"
        )
    i = int(np.argmax(step))
    widest = 2 * pitch / FEWEST_POINTS
    if step[i] > widest:
        row = f"row {lines[i + 1]}: " if lines else ""
        raise InputError(
            f"{path}: {row}x_um {x[i + 1] / um:.10g}: gap of {step[i] / um:g} µm: "
            f"expected steps up to {widest / um:g} µm"
        )
