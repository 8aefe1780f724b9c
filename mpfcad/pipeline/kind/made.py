"""Grooves as made: imperfect or measured, with the resin that the mask gives."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad import MeshCheck, StepCheck
from mpfcad.film import MadeFilm, PrismFilm
from mpfcad.film.section import Section
from mpfcad.pipeline.kind.base import FULL, Check, Print, Reprint, step_header
from mpfcad.pipeline.kind.groove import Grooves
from mpfcad.pipeline.kind.thin import left_out_words
from mpfcad.pipeline.kind.words import size_words
from mpfcad.record import ResinCheck

if TYPE_CHECKING:
    import plotly.graph_objects as go


class MadeGrooves(Grooves):
    """A row of imperfect or measured grooves: one body, by its cross-section."""

    formats: tuple[str, ...] = ("step", "stl", "3mf", "ply")
    film: MadeFilm  # type: ignore[assignment]

    @property
    def section(self) -> Section:
        """The cross-section; the same parts are left out of every file."""
        from mpfcad.cad.shape.mesh import mesh_sliver

        return self.film.section(mesh_sliver(self.film.film))

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import ply, stl, threemf
        from mpfcad.cad.shape import section_mesh
        from mpfcad.cad.step import section as section_step

        section = self.section
        if path.suffix == ".step":
            section_step.write_section_step(
                section, path, name=name, body="film",
                colour=section_step.FILM_COLOUR, header=step_header(self.table),
            )  # fmt: skip
            return
        if path.suffix == ".ply":
            ply.write_section_ply(section, path, self.angle, name=name)
            return
        mesh = section_mesh.build_section_mesh(section, self.angle)
        if path.suffix == ".3mf":
            threemf.write_3mf_meshes({"film": mesh}, path, name)
        else:
            stl.write_mesh(mesh, path, name)

    def check(self, path: Path) -> Check:
        from mpfcad.cad.check.section_file import check_section_3mf, check_section_ply

        if path.suffix == ".step":
            return self.check_step(path)
        if path.suffix == ".stl":
            return self.check_mesh(path)
        check = {".3mf": check_section_3mf, ".ply": check_section_ply}[path.suffix]
        return check(path, self.section)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.section import check_section_step

        return check_section_step(path, self.section, "film")

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad.check.section import check_section_stl

        made = self.film.imperfection
        is_parabola = made.measured is None and made.contact_angle is None
        parabolas = self.film.film if is_parabola else None
        return check_section_stl(path, self.section, self.angle, parabolas)

    def left_out(self) -> str | None:
        from mpfcad.cad.shape.mesh import mesh_sliver
        from mpfcad.film.imperfection import SLIVER, resin_reach

        film, made = self.film.film, self.film.imperfection
        if film.profile == "ideal" or made.measured is not None:
            return None
        sliver = mesh_sliver(film)
        thin = (resin_reach(film, made, SLIVER) > 0) & (resin_reach(film, made, sliver) == 0)
        return left_out_words(thin, sliver, "grooves")

    def reprint(self, piece: PrismFilm) -> Reprint | None:
        film, own = self.film, self.film.resin_factor
        # What was measured holds the resin of the print that was measured.
        if film.imperfection.measured is not None or piece.profile != "filled":
            return None
        most = FULL * film.groove.depth / 2 / (1.0 if own is None else own)
        return Reprint(
            piece.curvature,
            lambda factor: film.with_resin(np.minimum(piece.resin_height * factor, most)),
        )

    def printed(self, given: Print, ratio: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the C [1/mm] with which each groove as made holds the resin of these ratios."""
        depth = given.process.groove.depth
        height = given.process.fill_fraction(ratio) * depth / 2
        return self.film.with_resin(height).film.curvature

    def resin(self, mesh_volume: float, given: Print) -> ResinCheck | None:
        factor = self.film.resin_factor
        if factor is None:
            return super().resin(mesh_volume, given)
        width, length = self.film.size
        full = width * length * given.process.groove.depth / 2
        by_mask = {
            name: full * float(np.mean(given.process.fill_fraction(ratio) * factor))
            for name, ratio in given.ratio.items()
        }
        return ResinCheck(by_mask, mesh_volume - self.film.bare_volume, full)

    @property
    def extent(self) -> str:
        film = self.film
        return size_words((*film.size, film.thickness), f"{film.film.groove_count} grooves")

    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        return self.film

    def view(self, mesh: Path) -> "go.Figure":
        from mpfcad.report.drawing.film.groove_view import groove_view

        return groove_view(mesh, self.film)

    def mould_film(self, where: str) -> MadeFilm:
        return self.film
