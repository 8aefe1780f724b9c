"""Grooves as a library: few pieces, an instance at each place; the film under LEDs."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.errors import InputError
from mpfcad.film import CellLibrary, Imperfection, MadeFilm, PieceLibrary, PrismFilm
from mpfcad.pipeline.kind.base import Check, Kind, Print, step_header
from mpfcad.pipeline.kind.thin import is_thin, left_out_words
from mpfcad.pipeline.kind.words import (
    CORNER_WORDS,
    CURVATURE_WORDS,
    range_words,
    size_words,
    view_text,
)
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS
from mpfcad.record import ResinCheck

#: Side of the squares [mm] over which the rounded curvatures are compared with the map.
SQUARE = 1.0

if TYPE_CHECKING:
    import plotly.graph_objects as go


class PieceGrooves(Kind):
    """A film of groove pieces whose instances alone say where they stand: 3MF can hold that."""

    formats: tuple[str, ...] = ("3mf", "step", "stl", "csv", *HEIGHT_FORMATS)
    run_formats: tuple[str, ...] = ("3mf",)
    film: PieceLibrary
    template = "report/film_library.html.j2"
    section_title = "The piece at the film's lower left corner"
    shows_grooves = False
    view_words = view_text("Grooves", "in true proportion", "film.3mf")

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file.library import write_library
        from mpfcad.cad.file.library_window import write_window
        from mpfcad.cad.file.placement import write_placement
        from mpfcad.cad.step.library import write_library_step

        if path.suffix == ".step":
            write_library_step(self.window, path, name=name, header=step_header(self.table))
        elif path.suffix == ".stl":
            write_window(self.window, path, self.angle, name)
        elif path.suffix == ".csv":
            write_placement(self.film, path)
        else:
            write_library(self.film, path, self.angle, name=name)

    def check(self, path: Path) -> Check | None:
        from mpfcad.cad.check.library import check_library
        from mpfcad.cad.file.library_window import check_window
        from mpfcad.cad.file.placement import check_placement

        if path.suffix == ".csv":
            check_placement(path, self.film)
            return None
        if path.suffix == ".stl":
            return check_window(path, self.window)
        return super().check(path) if path.suffix == ".step" else check_library(path, self.film)

    @property
    def window(self) -> Any:
        """What STEP and STL hold: `cad.width_mm` by `length_mm` from the LED on."""
        across, along = self.film.chosen.shape
        width, length = self.table.inside("width_mm") or self.table.length, self.table.length
        n = min(max(1, round(width / self.film.groove.pitch)), across)
        return self.film.cut((n, min(max(1, round(length / self.film.length)), along)))

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.step.library import check_library_step

        return check_library_step(path, self.window)

    def check_mesh(self, path: Path) -> MeshCheck:
        raise self._none(path)

    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        raise self._none(stl)

    def _none(self, path: Path) -> InputError:
        return InputError(f"{path.name}: a film of pieces: expected to be compared piece by piece")

    def curvature_difference(
        self, found: NDArray[np.float64], mapped: NDArray[np.float64], given: Print | None
    ) -> float | None:
        from mpfcad.cad.check.library import mean_difference

        off = mean_difference(self.film, found, SQUARE)
        if given is None:
            return off
        wanted = given.process.curvature(given.wanted)
        means = [given.process.curvature(ratio) - wanted for ratio in given.ratio.values()]
        return off + max(float(np.abs(mean).max()) for mean in means)

    def resin(self, mesh_volume: float, given: Print) -> ResinCheck | None:
        film, found = self.film, super().resin(mesh_volume, given)
        if found is None:
            return None
        # A mask tells of whole grooves: what it gives more than is wanted, on top of the map's.
        by_map = found.full * float(np.mean(film.groove.fill_fraction(self.wanted)))
        whole = found.full * float(np.mean(given.process.fill_fraction(given.wanted)))
        by_mask = {name: by_map + volume - whole for name, volume in found.by_mask.items()}
        return ResinCheck(by_mask, found.in_mesh, found.full)

    def left_out(self) -> str | None:
        from mpfcad.cad.step.outline import drawn_sliver

        groove, sliver = self.film.groove, drawn_sliver(self.film.groove.pitch)
        thin = is_thin(groove, self.film.curvature, sliver).reshape(len(self.film.curvature), -1)
        each = np.asarray(thin.all(axis=1))[self.film.chosen]
        return left_out_words(each, sliver, "places", groove)

    @property
    def wanted(self) -> NDArray[np.float64]:
        """The map that was rounded, (n, m) [1/mm]."""
        return self.film.wanted

    @property
    def shown(self) -> NDArray[np.float64]:
        """The curvature at each place, (n, m) [1/mm]."""
        return self.film.curvature[self.film.chosen]

    @property
    def pieces(self) -> PieceLibrary | CellLibrary:
        return self.film

    @property
    def extent(self) -> str:
        across, along = self.film.chosen.shape
        pieces = f"{len(np.unique(self.film.chosen))} pieces at {across} × {along} places"
        return size_words((*self.film.size, self.film.base + self.film.groove.depth), pieces)

    @property
    def corner(self) -> PrismFilm:
        """The groove at the film's lower left corner; of cells, one through their valley."""
        return self.film.piece(int(self.film.chosen[0, 0]))

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        return MadeFilm(self.corner, Imperfection())

    def view(self, mesh: Path) -> "go.Figure":
        from mpfcad.report.drawing.film.library_view import library_view

        return library_view(mesh, self.film)

    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[np.float64],
        aperture: NDArray[np.float64] | None,
        recovered: list[float] | None,
    ) -> dict[str, Any]:
        from mpfcad.report.drawing.film.field_view import curvature_figure
        from mpfcad.report.drawing.plot import plot

        film = self.film
        curvature = self.shown
        across, along = (np.arange(0.5, n) for n in film.chosen.shape)
        figure = curvature_figure(across * film.groove.pitch, along * film.length, curvature)
        return {
            "template": self.template,
            "prints": True,
            "range": range_words(curvature),
            "count": len(np.unique(film.chosen)),
            "places": " × ".join(map(str, film.chosen.shape)),
            "length": f"{film.length:.6g}",
            "plot": plot(figure, "film"),
            "caption": f"{CURVATURE_WORDS}, of the piece at each place. {CORNER_WORDS}",
        }
