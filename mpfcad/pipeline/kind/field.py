"""Grooves whose curvature varies along them too, C(x, y): one body of patches."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.errors import InputError
from mpfcad.film import FieldPiece, MadeFilm
from mpfcad.pipeline.kind.base import Kind, Print, step_header
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS
from mpfcad.record import ResinCheck


class FieldGrooves(Kind):
    """A window of a map in both directions.

    A mask tells the mean ratio of whole grooves, the mesh C at each place: both are compared with
    the map.
    """

    formats: tuple[str, ...] = ("step", "stl", *HEIGHT_FORMATS)
    film: FieldPiece

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import stl
        from mpfcad.cad.shape import field_mesh
        from mpfcad.cad.step import field as field_step

        if path.suffix == ".step":
            field_step.write_field_step(self.film, path, name=name, header=step_header(self.table))
        else:
            stl.write_mesh(field_mesh.build_field_mesh(self.film, self.angle), path, name)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.step import check_film_body

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

    def mould_film(self, where: str) -> MadeFilm:
        raise InputError(
            f"{where}: map.file: varies along the grooves too: a mould is turned: expected a map "
            "that varies across them only"
        )
