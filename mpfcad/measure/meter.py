"""The luminance meter's spot and where it stands: over whole grooves, over whole lamp pitches."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.optics.repeat import groove_pitch

if TYPE_CHECKING:
    from mpfcad.optics.solid.mesh import FilmMesh

#: Points over a pitch: 0 and 1 above lamps, 0.5 between (Hsieh, MPF thesis).
POINTS = 33
#: Spots are alike within such a share of a groove.
_SAME = 1e-3


@dataclass(frozen=True)
class Spot:
    """The width over which a point is averaged [mm], and the width that was asked for."""

    width: float
    asked: float

    @property
    def is_rounded(self) -> bool:
        """Whether it is not the one that was asked for."""
        return abs(self.width - self.asked) > 1e-9

    @property
    def note(self) -> str:
        """The rounding in words."""
        return f"meter_spot_mm: {self.asked:g}: rounded to whole grooves: {self.width:g} mm"

    def describe(self) -> dict[str, float]:
        """Return both in outside names."""
        return {"spot_mm": self.width, "asked_spot_mm": self.asked}


def meter_spot(stack: Stack, mesh: "FilmMesh | None") -> Spot:
    """Return the stack's meter spot, rounded to whole grooves of the film; 0 stays a point.

    A spot that cuts grooves gives each point a phase of its own: where no sheet blurs it, the
    points scatter by more than their errors.

    Raises
    ------
    InputError
        when the spot is wider than the panel.
    """
    asked = stack["meter_spot_mm"]
    if asked > stack.panel_width:
        raise InputError(
            f"{stack.name}: meter_spot_mm: {asked:g}: expected at most the panel's width of "
            f"{stack.panel_width:g} mm"
        )
    pitch = None if mesh is None else groove_pitch(mesh)
    if pitch is None or asked == 0:
        return Spot(asked, asked)
    width = max(1, round(asked / pitch)) * pitch
    # A mesh's float32 is no other width.
    return Spot(asked if abs(width - asked) < _SAME * pitch else width, asked)


def pitch_positions(stack: Stack) -> NDArray[np.float64]:
    """Return where a meter stands over whole lamp pitches, in pitches from the scene's x = 0.

    Without end that is one pitch, on a finite panel with tubes all from the first to the last.

    Raises
    ------
    InputError
        when the panel does not reach over the pitch.
    """
    source = stack.source
    first, last = 0, 1
    if stack.extent == "panel":
        left, pitch = -stack.origin[0], source.period.across
        if source.period.along == 0 and source.count > 1:
            first = -round(float(source.count - 1) // 2)
            last = first + source.count - 1
        if last * pitch > left + stack.panel_width + 1e-6:
            raise InputError(
                f"{stack.name}: panel_width_mm: {stack.panel_width:g}: expected a whole pitch of "
                f"{pitch:g} mm beside the {source.word} at {-left:g} mm"
            )
    return np.linspace(first, last, (last - first) * (POINTS - 1) + 1)


def pitch_count(stack: Stack) -> int:
    """Return over how many lamp pitches a meter stands: one without end."""
    return (len(pitch_positions(stack)) - 1) // (POINTS - 1)


def refuse_dark(name: str, position: NDArray[np.float64], luminance: NDArray[np.float64]) -> None:
    """Raise where a whole lamp pitch has no light: it has no contrast.

    Raises
    ------
    InputError
        naming the pitch.
    """
    step = POINTS - 1
    for number in range((len(position) - 1) // step):
        if not luminance[number * step : (number + 1) * step + 1].any():
            raise InputError(
                f"{name}: luminance 0 at all points of pitch {number + 1} from the left: expected "
                "lamps that light every pitch between the first and the last"
            )
