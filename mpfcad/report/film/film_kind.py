"""What a page says and draws of each kind of film; the kinds are told apart here alone."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from numpy.typing import NDArray

from mpfcad.film import CellFilm, FieldPiece, Imperfection, MadeFilm, PrismFilm
from mpfcad.report.drawing.cell_view import cell_view
from mpfcad.report.drawing.field_view import field_figure, field_view
from mpfcad.report.drawing.figure import film_figure
from mpfcad.report.drawing.groove_view import groove_view
from mpfcad.report.drawing.plot import plot
from mpfcad.units import um

if TYPE_CHECKING:
    import plotly.graph_objects as go

Drawn = PrismFilm | MadeFilm | CellFilm | FieldPiece
Values = dict[str, Any]
_FILLED = (
    "C of z = z_{0} + C/2 · x² through the tips, and the value a profiler's least-squares fit "
    "reports; fill = resin area / groove area; aperture ratio = open area / cell area, as read "
    "back from the mask file."
)


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
    def made(self) -> MadeFilm:
        """The film as grooves; of cells, one groove with their section through the tips."""

    @property
    def extent(self) -> str:
        """Size and number of what the CAD files hold."""

    def view(self, stl: Path) -> "go.Figure":
        """Return the drawing of film.stl in three dimensions."""

    def values(
        self, position: NDArray[Any], aperture: NDArray[Any] | None, recovered: list[float] | None
    ) -> Values:
        """Return what the section on the film shows.

        Position [mm] from the lamp's axis, aperture ratio and C [1/mm] from the mask by groove.
        """


def kind_of(drawn: Drawn, piece: PrismFilm) -> FilmKind:
    """Return the kind of what the CAD files hold; `piece` is it as designed."""
    if isinstance(drawn, CellFilm):
        return Cells(drawn, piece)
    if isinstance(drawn, FieldPiece):
        return Field(drawn, piece)
    return Grooves(drawn if isinstance(drawn, MadeFilm) else MadeFilm(piece, Imperfection()), piece)


def _size(size: tuple[float, ...], number: str) -> str:
    return " × ".join(f"{part:.6g}" for part in size) + f" mm, {number}"


def _range(curvature: NDArray[Any]) -> str:
    return f"{curvature.min():.4g} … {curvature.max():.4g}"


def _turning(what: str, how: str) -> str:
    return (
        f"{what} in the middle of the piece {how}; turn with the mouse. The surface is that of "
        "film.stl; the base goes on below."
    )


@dataclass(frozen=True, eq=False)
class Grooves:
    """Grooves with one curvature each, as designed or as made."""

    made: MadeFilm
    piece: PrismFilm
    section_title = "The first groove of the piece"
    shows_grooves = True
    no_mask = "an ideal film cannot be printed"
    view_words = _turning("Grooves", "in true proportion")

    @property
    def extent(self) -> str:
        """Size and number of grooves."""
        film = self.made.film
        return _size((film.width, film.length, film.thickness), f"{film.groove_count} grooves")

    def view(self, stl: Path) -> "go.Figure":
        """Return a few grooves."""
        return groove_view(stl, self.made)

    def values(
        self, position: NDArray[Any], aperture: NDArray[Any] | None, recovered: list[float] | None
    ) -> Values:
        """Return curvature, fill and aperture over the piece."""
        piece, curvature = self.piece, self.piece.curvature
        if piece.profile == "ideal":
            figure = film_figure(position, curvature, curvature, [], None, None)
            caption = "Curvature of each groove."
            return {"kind": "ideal", "plot": plot(figure, "film"), "caption": caption}
        fitted = piece.groove.fitted_curvature(curvature, piece.profile)
        figure = film_figure(position, curvature, fitted, piece.fill_fraction, aperture, recovered)
        return {
            "kind": "groove",
            "range": _range(curvature),
            "count": piece.groove_count,
            "limit": f"{piece.groove.curvature_empty:g}",
            "plot": plot(figure, "film"),
            "caption": _FILLED,
        }


@dataclass(frozen=True, eq=False)
class Cells:
    """Pyramids or paraboloids in both directions."""

    drawn: CellFilm
    piece: PrismFilm
    section_title = "A section through the cells' tips"
    shows_grooves = False
    no_mask = "cells have no printing process"
    view_words = _turning("Cells", "in true proportion")

    @property
    def made(self) -> MadeFilm:
        """One groove with the cells' section through the tips."""
        return MadeFilm(self.piece.cut(0, 1, self.piece.length), Imperfection())

    @property
    def extent(self) -> str:
        """Size and number of cells."""
        across, along = self.drawn.count
        return _size((*self.drawn.size, self.drawn.thickness), f"{across} × {along} cells")

    def view(self, stl: Path) -> "go.Figure":
        """Return a few cells."""
        return cell_view(stl, self.drawn)

    def values(
        self, position: NDArray[Any], aperture: NDArray[Any] | None, recovered: list[float] | None
    ) -> Values:
        """Return shape, pitch and curvature: all cells are alike."""
        return {
            "kind": "cell",
            "plot": None,
            "shape": self.drawn.shape,
            "pitch_um": f"{self.piece.groove.pitch / um:g}",
            "curvature": f"{self.drawn.curvature:g}",
        }


@dataclass(frozen=True, eq=False)
class Field:
    """Grooves whose curvature varies along them."""

    drawn: FieldPiece
    piece: PrismFilm
    section_title = "The first groove of the piece"
    shows_grooves = True
    no_mask = "an ideal film cannot be printed"
    view_words = _turning(
        "Grooves", "over its whole length, drawn shortened; a section is in true proportion"
    )

    @property
    def made(self) -> MadeFilm:
        """The section at the piece's lower end."""
        return MadeFilm(self.piece, Imperfection())

    @property
    def extent(self) -> str:
        """Size, number of grooves, and where the piece lies along the panel."""
        piece = self.drawn
        number = f"{piece.groove_count} grooves; y = 0 is {piece.origin[1]:.6g} mm along the panel"
        return _size((*piece.size, piece.thickness), number)

    def view(self, stl: Path) -> "go.Figure":
        """Return a few grooves over the piece's length."""
        return field_view(stl, self.drawn)

    def values(
        self, position: NDArray[Any], aperture: NDArray[Any] | None, recovered: list[float] | None
    ) -> Values:
        """Return the map over the piece."""
        return {
            "kind": "field",
            "range": _range(self.drawn.curvature),
            "count": self.drawn.groove_count,
            "across": f"{self.drawn.origin[0]:.6g}",
            "along": f"{self.drawn.origin[1]:.6g}",
            "plot": plot(field_figure(self.drawn), "film"),
            "caption": "C of z = z_{0} + C/2 · x² through the tips, over the piece that is drawn.",
        }
