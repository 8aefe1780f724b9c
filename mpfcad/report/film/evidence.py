"""What the report shows besides verification.json: the folder, the stack and the film."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.film import PrismFilm
from mpfcad.mask.screen.levelled import LevelledWindow
from mpfcad.report.film.kind import FilmKind


@dataclass(frozen=True, eq=False)
class Evidence:
    """What was examined.

    Attributes
    ----------
    folder
        where the files are
    stack
        the backlight that was traced
    panel, piece
        the film over the panel, and its part that film.step and film.stl hold, as designed; of
        grooves whose curvature varies along them, the section at the piece's lower end
    kind
        what they hold: words and drawings of the film's kind
    first_groove
        groove of the panel that is the first of the piece
    lamp_position
        position [mm] on the panel of the lamp that the traced pitch starts at
    mask_period
        period of the apertures along the grooves [mm]
    aperture_ratio
        (n,) float64 of the piece's grooves, read back from the mask; None without a mask
    levelled
        a few grooves before and after the resin levels; None where there is nothing to draw
    traced
        name of the file that was traced
    """

    folder: Path
    stack: Stack
    panel: PrismFilm
    piece: PrismFilm
    kind: FilmKind
    first_groove: int
    lamp_position: float
    mask_period: float
    aperture_ratio: NDArray[np.float64] | None
    levelled: LevelledWindow | None = None
    traced: str = "film.stl"

    @property
    def shown_groove(self) -> dict[str, int]:
        """Where the drawings look: title -> groove of the piece, above a lamp and between two."""
        pitch, last = self.piece.groove.pitch, self.piece.groove_count - 1
        lamp = (self.lamp_position - self.piece.origin) / pitch
        between = lamp + self.stack.period.across / 2 / pitch
        word = self.stack.source.word
        places = {f"above the {word}": lamp, f"between the {word}s": between}
        return {title: min(max(round(at), 0), last) for title, at in places.items()}

    @property
    def position(self) -> NDArray[np.float64]:
        """Position of the piece's grooves from the lamp's axis, (n,) float64 [mm]."""
        return self.piece.groove_position + self.piece.origin - self.lamp_position
