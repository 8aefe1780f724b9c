"""Grooves whose curvature varies along them too, C(x, y): one body of patches."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.errors import InputError
from mpfcad.film import FieldPiece, Imperfection, MadeFilm, PanelFilm, PrismFilm
from mpfcad.pipeline.kind.base import FULL, Kind, Print, Reprint, step_header
from mpfcad.pipeline.kind.thin import is_thin, left_out_words
from mpfcad.pipeline.kind.words import CURVATURE_WORDS, range_words, size_words, view_text
from mpfcad.pipeline.plan.field import refuse_single
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS
from mpfcad.record import ResinCheck

if TYPE_CHECKING:
    import plotly.graph_objects as go


class FieldGrooves(Kind):
    """A window of a map in both directions.

    A mask tells the mean ratio of whole grooves, the mesh C at each place: both are compared with
    the map.
    """

    formats: tuple[str, ...] = ("step", "stl", *HEIGHT_FORMATS)
    film: FieldPiece
    view_words = view_text(
        "Grooves", "over its whole length, drawn shortened; a section is in true proportion"
    )

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import stl
        from mpfcad.cad.shape import field_mesh
        from mpfcad.cad.step import field as field_step

        if path.suffix == ".step":
            field_step.write_field_step(self.film, path, name=name, header=step_header(self.table))
        else:
            stl.write_mesh(field_mesh.build_field_mesh(self.film, self.angle), path, name)

    def reprint(self, piece: PrismFilm) -> Reprint | None:
        if self.film.profile != "filled":
            return None
        groove = self.film.groove

        def film(factor: NDArray[np.float64]) -> FieldPiece:
            fill = np.clip(groove.fill_fraction(self.film.curvature) * factor, 0, FULL)
            return replace(self.film, curvature=groove.curvature_of_fill(fill))

        return Reprint(self.film.curvature, film)

    def left_out(self) -> str | None:
        from mpfcad.cad.shape.field_mesh import mesh_sliver

        film, sliver = self.film, mesh_sliver(self.film)
        if film.profile == "ideal":
            return None
        thin = is_thin(film.groove, film.curvature, sliver)
        # Patches end exactly where the resin does.
        files = "meshes, not the STEP,"
        return left_out_words(thin, sliver, "places of the map", film.groove, files)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.step.body import check_film_body

        return check_film_body(path, self.film)

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad.check.field import check_field_stl

        return check_field_stl(path, self.film, self.angle)

    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        from mpfcad.cad.check.field import VOLUME_LIMIT
        from mpfcad.cad.check.field_agreement import check_field_agreement

        return check_field_agreement(step, stl, volume, VOLUME_LIMIT)

    def curvature_difference(
        self, found: NDArray[np.float64], mapped: NDArray[np.float64], given: Print | None
    ) -> float | None:
        from mpfcad.cad.check.field import curvature_difference

        off = 0.0
        if given is not None:
            wanted = given.process.curvature(given.wanted)
            for ratio in given.ratio.values():
                means = given.process.curvature(ratio) - wanted
                off = max(off, float(np.abs(means).max()))
        return off + curvature_difference(self.film, found)

    def resin(self, mesh_volume: float, given: Print) -> ResinCheck | None:
        found = super().resin(mesh_volume, given)
        if found is None:
            return None
        by_map = self.film.volume - self.film.bare_volume
        whole = found.full * float(np.mean(given.process.fill_fraction(given.wanted)))
        by_mask = {name: by_map + volume - whole for name, volume in found.by_mask.items()}
        return ResinCheck(by_mask, found.in_mesh, found.full)

    def refuse_trace(self, printed: PanelFilm, stack: Stack, where: str) -> None:
        refuse_single(printed.as_field(), self.film, stack, where)

    @property
    def extent(self) -> str:
        piece = self.film
        number = f"{piece.groove_count} grooves; y = 0 is {piece.origin[1]:.6g} mm along the panel"
        return size_words((*piece.size, piece.thickness), number)

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        """Return the section at the piece's lower end."""
        return MadeFilm(piece, Imperfection())

    def view(self, mesh: Path) -> "go.Figure":
        from mpfcad.report.drawing.film.field_view import field_view

        return field_view(mesh, self.film)

    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[np.float64],
        aperture: NDArray[np.float64] | None,
        recovered: list[float] | None,
    ) -> dict[str, Any]:
        from mpfcad.report.drawing.film.field_view import field_figure
        from mpfcad.report.drawing.plot import plot

        across, along = self.film.origin
        return {
            "template": "report/film_field.html.j2",
            "prints": True,
            "range": range_words(self.film.curvature),
            "count": self.film.groove_count,
            "across": f"{across:.6g}",
            "along": f"{along:.6g}",
            "plot": plot(field_figure(self.film), "film"),
            "caption": f"{CURVATURE_WORDS}, over the piece that is drawn.",
        }

    def mould_film(self, where: str) -> MadeFilm:
        raise InputError(
            f"{where}: map.file: varies along the grooves too: a mould is turned: expected a map "
            "that varies across them only"
        )
