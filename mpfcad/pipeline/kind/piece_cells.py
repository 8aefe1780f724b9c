"""Pyramids or dishes as a library: few cells, an instance a place; films of patterned cells."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CellLibrary, Imperfection, MadeFilm, PrismFilm
from mpfcad.pipeline.kind.library import PieceGrooves
from mpfcad.pipeline.kind.words import size_words, view_text


class PieceCells(PieceGrooves):
    """A film of cells whose curvature differs from one to the next."""

    film: CellLibrary  # type: ignore[assignment]  # holds and is asked the same
    template = "report/film_cells.html.j2"
    section_title = "A section through the valley of the cell at the lower left corner"
    no_mask = "no print makes dishes, or what lies under bare walls"
    view_words = view_text("Cells", "in true proportion", "film.3mf")

    @property
    def wanted(self) -> NDArray[np.float64]:
        """The map that was rounded, (n, m) [1/mm]."""
        return self.film.wanted[..., 0]

    @property
    def shown(self) -> NDArray[np.float64]:
        """The curvature at each place, (n, m) [1/mm]."""
        return self.film.curvature[self.film.chosen][..., 0]

    @property
    def extent(self) -> str:
        across, along = self.film.chosen.shape
        cells = f"{len(np.unique(self.film.chosen))} different cells at {across} × {along} places"
        return size_words((*self.film.size, self.film.base + self.film.groove.depth), cells)

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        film, curvature = self.film, np.array([self.shown[0, 0]])
        one = PrismFilm(film.groove, film.base, film.length, film.profile, curvature)
        return MadeFilm(one, Imperfection())
