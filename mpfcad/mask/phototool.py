"""How the artwork is handed over: polarity, mirroring, emulsion side, furniture, resolution."""

from dataclasses import dataclass
from typing import Literal

Polarity = Literal["open", "closed"]
EmulsionSide = Literal["film", "squeegee"]
Furniture = Literal["fiducial", "text", "coupon"]
FURNITURE: tuple[Furniture, ...] = ("fiducial", "text", "coupon")


@dataclass(frozen=True)
class Phototool:
    """How the artwork is handed over.

    Attributes
    ----------
    polarity
        what is drawn on the aperture layer: what resin passes (`open`), or the rest (`closed`)
    mirror
        drawn as seen from the film's side instead of from the squeegee's
    emulsion_side
        side of the screen that carries the emulsion: `film` or `squeegee`
    furniture
        what is drawn around the panel; the outline always is
    dpi
        pixels per inch of a TIFF
    notes
        lines of the order, ASCII, that stand below the first two in every file
    """

    polarity: Polarity = "open"
    mirror: bool = False
    emulsion_side: EmulsionSide = "film"
    furniture: tuple[Furniture, ...] = FURNITURE
    dpi: float = 2540.0
    notes: tuple[str, ...] = ()

    @property
    def statement(self) -> str:
        """The line of text that says how to look at the artwork."""
        seen = "mirrored: seen from the film side" if self.mirror else "seen from the squeegee side"
        return f"drawn = {self.polarity}; {seen}; emulsion on the {self.emulsion_side} side"
