"""Grooves as designed, one curvature each."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.film import Imperfection, MadeFilm, PrismFilm
from mpfcad.pipeline.kind.base import FULL, Check, Kind, Print, Reprint, step_header
from mpfcad.pipeline.kind.thin import is_thin, left_out_words
from mpfcad.pipeline.kind.words import CURVATURE_WORDS, range_words, size_words, view_text
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS

if TYPE_CHECKING:
    import plotly.graph_objects as go

_FILLED = (
    f"{CURVATURE_WORDS}, and the value a profiler's least-squares fit reports; fill = resin area "
    "/ groove area; aperture ratio = open area / cell area, as read back from the mask file."
)


class Grooves(Kind):
    """A row of grooves as designed."""

    formats: tuple[str, ...] = ("step", "stl", "3mf", "ply", *HEIGHT_FORMATS)
    film: PrismFilm
    view_words = view_text("Grooves", "in true proportion")

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad import write_3mf, write_ply, write_step, write_stl

        if path.suffix == ".step":
            header, bodies = step_header(self.table), self.table.bodies
            write_step(self.film, path, name=name, bodies=bodies, header=header)
        else:
            write = {".stl": write_stl, ".3mf": write_3mf, ".ply": write_ply}[path.suffix]
            write(self.film, path, self.angle, name=name)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad import check_step

        return check_step(path, self.film, bodies=self.table.bodies)

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad import check_stl

        return check_stl(path, self.film, self.angle)

    def check(self, path: Path) -> Check | None:
        from mpfcad.cad import check_3mf, check_ply

        if path.suffix in (".step", ".stl"):
            return super().check(path)
        return {".3mf": check_3mf, ".ply": check_ply}[path.suffix](path, self.film)

    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        from mpfcad.cad import check_agreement

        return check_agreement(step, stl, volume)

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.film.height(x) + 0 * y

    def left_out(self) -> str | None:
        from mpfcad.cad.shape.mesh import mesh_sliver

        film, sliver = self.film, mesh_sliver(self.film)
        if film.profile == "ideal":
            return None
        thin = is_thin(film.groove, film.curvature, sliver)
        return left_out_words(thin, sliver, "grooves", film.groove)

    def tile(self, first: int, count: int) -> Kind:
        return type(self)(self.film.cut(first, count, self.film.size[1]), self.table)

    def curvature_difference(
        self, found: NDArray[np.float64], mapped: NDArray[np.float64], given: Print | None
    ) -> float | None:
        expected = [mapped]
        if given is not None:
            expected = [self.printed(given, ratio) for ratio in given.ratio.values()]
        return max(float(np.max(np.abs(values - found))) for values in expected)

    def reprint(self, piece: PrismFilm) -> Reprint | None:
        if piece.profile != "filled":
            return None

        def film(factor: NDArray[np.float64]) -> PrismFilm:
            fill = np.clip(self.film.fill_fraction * factor, 0, FULL)
            return replace(self.film, curvature=self.film.groove.curvature_of_fill(fill))

        return Reprint(piece.curvature, film)

    def printed(self, given: Print, ratio: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the C [1/mm] of each groove that aperture ratios give."""
        return given.process.curvature(ratio)

    @property
    def extent(self) -> str:
        film = self.film
        return size_words((*film.size, film.thickness), f"{film.groove_count} grooves")

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        return MadeFilm(piece, Imperfection())

    def view(self, mesh: Path) -> "go.Figure":
        from mpfcad.report.drawing.film.groove_view import groove_view

        return groove_view(mesh, self.as_grooves(self.film))

    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[np.float64],
        aperture: NDArray[np.float64] | None,
        recovered: list[float] | None,
    ) -> dict[str, Any]:
        from mpfcad.report.drawing.figure import film_figure
        from mpfcad.report.drawing.plot import plot

        curvature = piece.curvature
        if piece.profile == "ideal":
            figure = film_figure(position, curvature, curvature, [], None, None)
            return {
                "template": "report/film_ideal.html.j2",
                "prints": False,
                "plot": plot(figure, "film"),
                "caption": "Curvature of each groove.",
            }
        fitted = piece.groove.fitted_curvature(curvature, piece.profile)
        fill = piece.fill_fraction
        figure = film_figure(position, curvature, fitted, fill, aperture, recovered)
        return {
            "template": "report/film_groove.html.j2",
            "prints": True,
            "range": range_words(curvature),
            "count": piece.groove_count,
            "limit": f"{piece.groove.curvature_empty:g}",
            "plot": plot(figure, "film"),
            "caption": _FILLED,
        }

    def mould_film(self, where: str) -> MadeFilm:
        return MadeFilm(self.film, Imperfection())
