"""Write and check the CAD files of a piece, each kind of film in its own way."""

from pathlib import Path
from typing import Protocol

from mpfcad.cad import BodyCheck, MeshCheck, StepCheck
from mpfcad.film import CellFilm, MadeFilm, PrismFilm
from mpfcad.job import CadTable
from mpfcad.pipeline.made import Drawn

Check = StepCheck | MeshCheck | BodyCheck


class Drawing(Protocol):
    """The files of one kind of film, by their suffix."""

    #: The formats that this kind is written in.
    formats: tuple[str, ...]
    #: Largest relative difference between the volumes of STL and STEP.
    volume_tolerance: float

    def write(self, path: Path, name: str) -> None:
        """Write the file; `name` is that of the job."""

    def check(self, path: Path) -> Check:
        """Return what the file holds, once it is found to be the film."""


def drawing_of(film: Drawn, table: CadTable) -> Drawing:
    """Return how a film is drawn."""
    if isinstance(film, PrismFilm):
        return _Designed(film, table)
    return _Made(film, table) if isinstance(film, MadeFilm) else _Cells(film, table)


class _Designed:
    """Grooves as designed."""

    formats = ("step", "stl", "3mf", "ply")
    volume_tolerance = 1e-4

    def __init__(self, film: PrismFilm, table: CadTable) -> None:
        self.film, self.bodies, self.angle = film, table.bodies, table.angle_tolerance

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad import write_3mf, write_ply, write_step, write_stl

        if path.suffix == ".step":
            write_step(self.film, path, name=name, bodies=self.bodies)
        else:
            write = {".stl": write_stl, ".3mf": write_3mf, ".ply": write_ply}[path.suffix]
            write(self.film, path, self.angle, name=name)

    def check(self, path: Path) -> Check:
        from mpfcad.cad import check_3mf, check_ply, check_step, check_stl

        if path.suffix == ".step":
            return check_step(path, self.film, bodies=self.bodies)
        if path.suffix == ".stl":
            return check_stl(path, self.film, self.angle)
        return {".3mf": check_3mf, ".ply": check_ply}[path.suffix](path, self.film)


class _Made:
    """Imperfect or measured grooves: one body, by its cross-section."""

    formats = ("step", "stl")
    volume_tolerance = 1e-4

    def __init__(self, made: MadeFilm, table: CadTable) -> None:
        from mpfcad.cad.mesh import mesh_sliver

        self.made, self.angle = made, table.angle_tolerance
        self.sliver = mesh_sliver(made.film)

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad import section_mesh, section_step, stl

        if path.suffix == ".step":
            section_step.write_section_step(
                self.made.section(), path, name=name, body="film", colour=section_step.FILM_COLOUR
            )
        else:
            mesh = section_mesh.build_section_mesh(self.made.section(self.sliver), self.angle)
            stl.write_mesh(mesh, path, name)

    def check(self, path: Path) -> Check:
        from mpfcad.cad.section_check import check_section_step, check_section_stl

        if path.suffix == ".step":
            return check_section_step(path, self.made.section(), "film")
        parabolas = None if self.made.imperfection.measured is not None else self.made.film
        return check_section_stl(path, self.made.section(self.sliver), self.angle, parabolas)


class _Cells:
    """Pyramids or dishes: one body of patches."""

    formats = ("step", "stl")
    volume_tolerance = 1e-3

    def __init__(self, film: CellFilm, table: CadTable) -> None:
        self.film, self.angle = film, table.angle_tolerance

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad import cell_mesh, cell_step, stl

        if path.suffix == ".step":
            cell_step.write_cell_step(self.film, path, name=name)
        else:
            stl.write_mesh(cell_mesh.build_cell_mesh(self.film, self.angle), path, name)

    def check(self, path: Path) -> Check:
        from mpfcad.cad.cell_check import check_cell_step, check_cell_stl

        if path.suffix == ".step":
            return check_cell_step(path, self.film)
        return check_cell_stl(path, self.film, self.angle)
