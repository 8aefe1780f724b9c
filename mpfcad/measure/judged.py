"""Which lamp pitches of a finite panel are judged: all that lie within its rim."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.measure.meter import POINTS

#: Rounding of places on the panel [mm].
_NEAR = 1e-6


@dataclass(frozen=True)
class Judged:
    """The pitches of a panel that its figure is read from.

    Attributes
    ----------
    rim
        what is not judged at the panel's left and right side [mm]
    start, pitch
        left end of the first pitch that is measured, from the panel's left edge, and a pitch [mm]
    count
        pitches that are measured, from the first lamp to the last
    first, stop
        numbers of the first one that is judged and of the one after the last
    """

    rim: float
    start: float
    pitch: float
    count: int
    first: int
    stop: int

    def place(self, number: int) -> tuple[float, float]:
        """Return where a pitch begins and ends [mm] from the panel's left edge."""
        return self.start + number * self.pitch, self.start + (number + 1) * self.pitch

    def is_judged(self, number: int) -> bool:
        """Return whether a pitch lies within the rim."""
        return self.first <= number < self.stop

    def words(self, worst: int) -> str:
        """Return in a line which pitch is the worst, where it is, and what is not judged."""
        begin, end = self.place(worst)
        line = f"worst pitch {worst + 1} of {self.count}, {begin:.1f} to {end:.1f} mm from the left"
        left_out = self.count - (self.stop - self.first)
        if not left_out:
            return f"{line}; all judged"
        return f"{line}; {left_out} in the rim of {self.rim:g} mm not judged"


def judged_pitches(stack: Stack, position: NDArray[np.float64]) -> Judged | None:
    """Return the judged pitches among those of a meter's positions; None without end.

    Raises
    ------
    InputError
        when no pitch lies within the rim.
    """
    if stack.extent != "panel":
        return None
    pitch, rim = stack.period.across, stack["rim_mm"]
    start = stack.origin[0] + float(position[0]) * pitch
    count = (len(position) - 1) // (POINTS - 1)
    begin = start + np.arange(count) * pitch
    within = (begin >= rim - _NEAR) & (begin + pitch <= stack.panel_width - rim + _NEAR)
    if not within.any():
        most = np.minimum(begin, stack.panel_width - begin - pitch).max()
        raise InputError(
            f"{stack.name}: rim_mm: {rim:g}: expected at most {most:g}, so that a whole lamp pitch "
            f"of {pitch:g} mm is judged"
        )
    number = np.flatnonzero(within)
    return Judged(rim, start, pitch, count, int(number[0]), int(number[-1]) + 1)
