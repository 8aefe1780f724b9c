"""Write and check the CAD files of a piece, each kind of film in its own way."""

from pathlib import Path
from typing import Protocol

from mpfcad.cad import Agreement, BodyCheck, MeshCheck, StepCheck
from mpfcad.cad.step.file import Header
from mpfcad.film import CellFilm, FieldPiece, MadeFilm, PrismFilm
from mpfcad.job import CadTable
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS
from mpfcad.pipeline.plan.made import Drawn

Check = StepCheck | MeshCheck | BodyCheck


class Drawing(Protocol):
    """The files of one kind of film, by their suffix."""

    #: The formats that this kind is written in.
    formats: tuple[str, ...]

    def write(self, path: Path, name: str) -> None:
        """Write the file; `name` is that of the job."""

    def check(self, path: Path) -> Check:
        """Return what a file holds, measured against the film."""

    def check_step(self, path: Path) -> StepCheck:
        """Return what film.step holds, measured against the film."""

    def check_mesh(self, path: Path) -> MeshCheck:
        """Return what film.stl holds, measured against the film."""

    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        """Return how well both agree; `volume` [mm³] is what OCCT found in the STEP."""


def drawing_of(film: Drawn, table: CadTable) -> Drawing:
    """Return how a film is drawn."""
    if isinstance(film, PrismFilm):
        return _Designed(film, table)
    if isinstance(film, FieldPiece):
        return _Field(film, table)
    return _Made(film, table) if isinstance(film, MadeFilm) else _Cells(film, table)


def step_header(table: CadTable) -> Header:
    """Return what the job's STEP files say of themselves."""
    return Header(table.step_protocol, table.author, table.organisation)


class _Checked:
    """Films of which film.step and film.stl are checked, each in its own way."""

    def check_step(self, path: Path) -> StepCheck:
        raise NotImplementedError

    def check_mesh(self, path: Path) -> MeshCheck:
        raise NotImplementedError

    def check(self, path: Path) -> Check:
        return self.check_step(path) if path.suffix == ".step" else self.check_mesh(path)


class _Exact(_Checked):
    """Films whose STEP states surfaces that `check_agreement` knows."""

    #: Largest relative difference between the volumes of STL and STEP.
    volume_tolerance: float

    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        from mpfcad.cad import check_agreement

        return check_agreement(step, stl, volume, self.volume_tolerance)


class _Designed(_Exact):
    """Grooves as designed."""

    formats = ("step", "stl", "3mf", "ply", *HEIGHT_FORMATS)
    volume_tolerance = 1e-4

    def __init__(self, film: PrismFilm, table: CadTable) -> None:
        self.film, self.bodies, self.angle = film, table.bodies, table.angle_tolerance
        self.header = step_header(table)

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad import write_3mf, write_ply, write_step, write_stl

        if path.suffix == ".step":
            write_step(self.film, path, name=name, bodies=self.bodies, header=self.header)
        else:
            write = {".stl": write_stl, ".3mf": write_3mf, ".ply": write_ply}[path.suffix]
            write(self.film, path, self.angle, name=name)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad import check_step

        return check_step(path, self.film, bodies=self.bodies)

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad import check_stl

        return check_stl(path, self.film, self.angle)

    def check(self, path: Path) -> Check:
        from mpfcad.cad import check_3mf, check_ply

        if path.suffix in (".step", ".stl"):
            return super().check(path)
        return {".3mf": check_3mf, ".ply": check_ply}[path.suffix](path, self.film)


class _Made(_Exact):
    """Imperfect or measured grooves: one body, by its cross-section."""

    formats = ("step", "stl", "3mf", "ply")
    volume_tolerance = 1e-4

    def __init__(self, made: MadeFilm, table: CadTable) -> None:
        from mpfcad.cad.shape.mesh import mesh_sliver

        self.made, self.angle = made, table.angle_tolerance
        self.header = step_header(table)
        self.sliver = mesh_sliver(made.film)

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import ply, stl, threemf
        from mpfcad.cad.shape import section_mesh
        from mpfcad.cad.step import section as section_step

        # The same parts are left out of every file.
        section = self.made.section(self.sliver)
        if path.suffix == ".step":
            section_step.write_section_step(
                section, path, name=name, body="film",
                colour=section_step.FILM_COLOUR, header=self.header,
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

        if path.suffix in (".step", ".stl"):
            return super().check(path)
        check = {".3mf": check_section_3mf, ".ply": check_section_ply}[path.suffix]
        return check(path, self.made.section(self.sliver))

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.section import check_section_step

        return check_section_step(path, self.made.section(self.sliver), "film")

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad.check.section import check_section_stl

        section = self.made.section(self.sliver)
        parabolas = None if self.made.imperfection.measured is not None else self.made.film
        return check_section_stl(path, section, self.angle, parabolas)


class _Cells(_Exact):
    """Pyramids or dishes: one body of patches."""

    formats = ("step", "stl", *HEIGHT_FORMATS)
    volume_tolerance = 1e-3

    def __init__(self, film: CellFilm, table: CadTable) -> None:
        self.film, self.angle = film, table.angle_tolerance
        self.header = step_header(table)

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import stl
        from mpfcad.cad.shape import cell_mesh
        from mpfcad.cad.step import cell as cell_step

        if path.suffix == ".step":
            cell_step.write_cell_step(self.film, path, name=name, header=self.header)
        else:
            stl.write_mesh(cell_mesh.build_cell_mesh(self.film, self.angle), path, name)

    def check_step(self, path: Path) -> StepCheck:
        from mpfcad.cad.check.step import check_film_body

        return check_film_body(path, self.film)

    def check_mesh(self, path: Path) -> MeshCheck:
        from mpfcad.cad.check.cell import check_cell_stl

        return check_cell_stl(path, self.film, self.angle)


class _Field(_Checked):
    """Grooves whose curvature varies along them: one body of patches."""

    formats = ("step", "stl", *HEIGHT_FORMATS)

    def __init__(self, film: FieldPiece, table: CadTable) -> None:
        self.film, self.angle = film, table.angle_tolerance
        self.header = step_header(table)

    def write(self, path: Path, name: str) -> None:
        from mpfcad.cad.file import stl
        from mpfcad.cad.shape import field_mesh
        from mpfcad.cad.step import field as field_step

        if path.suffix == ".step":
            field_step.write_field_step(self.film, path, name=name, header=self.header)
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
