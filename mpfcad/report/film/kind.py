"""What a page asks of the kind of a film: its words, its views, the template of its section.

The kinds themselves stand above the report, in `pipeline/kind`; a page never asks which one it has.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from numpy.typing import NDArray

from mpfcad.film import MadeFilm, PrismFilm

if TYPE_CHECKING:
    import plotly.graph_objects as go


class FilmKind(Protocol):
    """The words and drawings of one kind of film.

    Attributes
    ----------
    section_title
        what is drawn with its dimensions
    shows_grooves
        whether grooves above and between the lamps are drawn
    no_mask
        why there is no mask, where there is none
    view_words
        what the three-dimensional drawing shows
    """

    section_title: str
    shows_grooves: bool
    no_mask: str
    view_words: str

    @property
    def extent(self) -> str:
        """Size and number of what the CAD files hold."""

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        """Return the film as grooves, `piece` as designed; of cells, one through their tips."""

    def view(self, mesh: Path) -> "go.Figure":
        """Return the drawing of the mesh file in three dimensions."""

    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[Any],
        aperture: NDArray[Any] | None,
        recovered: list[float] | None,
    ) -> Mapping[str, Any]:
        """Return what the section on the film shows; `template` names its words in HTML.

        Position [mm] from the lamp's axis, aperture ratio and C [1/mm] from the mask by groove.
        """
