"""Pyramids or dishes as a library: few cells, an instance a place; films of patterned cells."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import CellLibrary, PrismFilm
from mpfcad.pipeline.kind.library import PieceGrooves
from mpfcad.pipeline.kind.words import CORNER_WORDS, range_words, size_words, view_text


class PieceCells(PieceGrooves):
    """A film of cells whose curvature differs from one to the next."""

    film: CellLibrary  # type: ignore[assignment]  # holds and is asked the same
    template = "report/film_cells.html.j2"
    section_title = "A section through the valley of the cell at the lower left corner"
    no_mask = "no print makes dishes, or what lies under bare walls"
    view_words = view_text("Cells", "in true proportion", "film.3mf")

    def left_out(self) -> str | None:
        return None if self.film.profile == "ideal" else super().left_out()

    @property
    def wanted(self) -> NDArray[np.float64]:
        """The map that was rounded, (n, m) [1/mm]."""
        return self.film.wanted[..., 0]

    @property
    def shown(self) -> NDArray[np.float64]:
        """The curvature at each place, (n, m) [1/mm]; of cells with two that along x."""
        return self.film.curvature[self.film.chosen][..., 0]

    @property
    def along(self) -> NDArray[np.float64] | None:
        """The curvature along y at each place, (n, m) [1/mm]; None where it is the same."""
        both = self.film.curvature
        same = np.array_equal(both[:, 0], both[:, 1])
        return None if same else both[self.film.chosen][..., 1]

    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[np.float64],
        aperture: NDArray[np.float64] | None,
        recovered: list[float] | None,
    ) -> dict[str, Any]:
        from mpfcad.report.drawing.film.field_view import curvature_figure
        from mpfcad.report.drawing.plot import plot

        section = super().film_section(piece, position, aperture, recovered)
        if self.along is None:
            return section | {"plot_along": None}
        size = self.film.groove.pitch
        across, along = (np.arange(0.5, n) * size for n in self.film.chosen.shape)
        return section | {
            "caption": f"Curvature along x of the cell at each place. {CORNER_WORDS}",
            "range": f"{section['range']} along x and {range_words(self.along)} along y",
            "plot_along": plot(curvature_figure(across, along, self.along), "film-along"),
        }

    @property
    def extent(self) -> str:
        across, along = self.film.chosen.shape
        cells = f"{len(np.unique(self.film.chosen))} different cells at {across} × {along} places"
        return size_words((*self.film.size, self.film.base + self.film.groove.depth), cells)

    @property
    def corner(self) -> PrismFilm:
        film, curvature = self.film, np.array([self.shown[0, 0]])
        return PrismFilm(film.groove, film.base, film.length, film.profile, curvature)
