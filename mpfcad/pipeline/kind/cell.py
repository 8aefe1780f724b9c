"""Cells in both directions: pyramids or dishes, one body of patches."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.errors import InputError
from mpfcad.film import CellFilm, Imperfection, MadeFilm, PrismFilm
from mpfcad.pipeline.kind.base import Kind, Print, step_header
from mpfcad.pipeline.kind.thin import is_thin, left_out_words
from mpfcad.pipeline.kind.words import size_words, view_text
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS
from mpfcad.record import ResinCheck
from mpfcad.units import um

if TYPE_CHECKING:
    import plotly.graph_objects as go


class Cells(Kind):
    """Equal cells of one curvature; the printing process is calibrated for grooves only."""

    formats: tuple[str, ...] = ("step", "stl", *HEIGHT_FORMATS)
    film: CellFilm
    section_title = "A section through the cells' tips"
    shows_grooves = False
    no_mask = "cells have no printing process"
    view_words = view_text("Cells", "in true proportion")

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import stl
        from mpfcad.cad.shape import cell_mesh
        from mpfcad.cad.step import cell as cell_step

        if path.suffix == ".step":
            cell_step.write_cell_step(self.film, path, name=name, header=step_header(self.table))
        else:
            stl.write_mesh(cell_mesh.build_cell_mesh(self.film, self.angle), path, name)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.step.body import check_film_body

        return check_film_body(path, self._drawn)

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad.check.cell import check_cell_stl

        return check_cell_stl(path, self._drawn, self.angle)

    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        from mpfcad.cad import check_agreement
        from mpfcad.cad.check.cell import VOLUME_LIMIT

        return check_agreement(step, stl, volume, VOLUME_LIMIT)

    def left_out(self) -> str | None:
        thin = np.full(self.film.count, self._is_thin)
        return left_out_words(thin, self._sliver, "cells", self.film.groove)

    @property
    def _sliver(self) -> float:
        from mpfcad.cad.step.outline import drawn_sliver

        return drawn_sliver(max(self.film.size))

    @property
    def _is_thin(self) -> bool:
        film = self.film
        thin = is_thin(film.groove, np.array([film.curvature]), self._sliver)
        return film.profile == "filled" and bool(thin[0])

    @property
    def _drawn(self) -> CellFilm:
        """The film as its files have it: without resin that is too thin for them."""
        film = self.film
        return replace(film, curvature=film.groove.curvature_empty) if self._is_thin else film

    def distance_along(self, across: float) -> float:
        return across

    def curvature_difference(
        self, found: NDArray[np.float64], mapped: NDArray[np.float64], given: Print | None
    ) -> float | None:
        return float(np.max(np.abs(self.film.curvature - found)))

    def resin(self, mesh_volume: float, given: Print) -> ResinCheck | None:
        return None

    @property
    def extent(self) -> str:
        across, along = self.film.count
        return size_words((*self.film.size, self.film.thickness), f"{across} × {along} cells")

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        return MadeFilm(piece.cut(0, 1, piece.length), Imperfection())

    def view(self, mesh: Path) -> "go.Figure":
        from mpfcad.report.drawing.film.cell_view import cell_view

        return cell_view(mesh, self.film)

    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[np.float64],
        aperture: NDArray[np.float64] | None,
        recovered: list[float] | None,
    ) -> dict[str, Any]:
        return {
            "template": "report/film_cell.html.j2",
            "prints": False,
            "plot": None,
            "shape": self.film.shape,
            "pitch_um": f"{piece.groove.pitch / um:g}",
            "curvature": f"{self.film.curvature:g}",
        }

    def mould_film(self, where: str) -> MadeFilm:
        raise InputError(f"{where}: film.cell: {self.film.shape}: expected 'groove' for a mould")
