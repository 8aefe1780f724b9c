"""What every kind of film brings to a run: CAD files, their checks, what the mask gives."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.cad import Agreement, BodyCheck, MeshCheck, StepCheck
from mpfcad.cad.file.height import HeightGrid, build_height_grid
from mpfcad.cad.step.file import Header
from mpfcad.errors import InputError
from mpfcad.film import CellLibrary, MadeFilm, PanelFilm, PieceLibrary, PrismFilm, Process
from mpfcad.job import CadTable
from mpfcad.record import ResinCheck
from mpfcad.units import um

if TYPE_CHECKING:
    import plotly.graph_objects as go

Check = StepCheck | MeshCheck | BodyCheck
#: Points over a groove or a cell, and the points' distance along grooves, unless the job says.
POINTS_PER_PITCH, DISTANCE_ALONG = 20, 50 * um
#: Fill up to where a groove is as good as full.
FULL = 0.999


def step_header(table: CadTable) -> Header:
    """Return what the job's STEP files say of themselves."""
    return Header(table.step_protocol, table.author, table.organisation)


@dataclass(frozen=True, eq=False)
class Print:
    """What the mask files give the grooves of a piece.

    Attributes
    ----------
    process
        the printing process
    ratio
        by mask file, (n,) float64, aperture ratio of each groove of the piece, read back
    wanted
        (n,) float64, mean aperture ratio that each should have
    """

    process: Process
    ratio: Mapping[str, NDArray[np.float64]]
    wanted: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reprint:
    """A film that can be printed again with more or less resin.

    Attributes
    ----------
    places
        float64 of any shape, C [1/mm] that each place is printed for
    film
        the film with the resin of each place times a factor of that shape; up to nearly full
    """

    places: NDArray[np.float64]
    film: Callable[[NDArray[np.float64]], Any]


class Kind(ABC):
    """A film of one kind, and how its job draws it.

    Attributes
    ----------
    formats, run_formats
        suffixes of the CAD files that it is written in, and of those that a run makes; the last of
        these is traced
    section_title, shows_grooves, no_mask, view_words
        what a page says of it, as `report.film.kind.FilmKind` has it
    """

    formats: tuple[str, ...] = ("step", "stl")
    run_formats: tuple[str, ...] = ("step", "stl")
    film: Any
    section_title = "The first groove of the piece"
    shows_grooves = True
    no_mask = "an ideal film cannot be printed"
    view_words = ""

    def __init__(self, film: Any, table: CadTable) -> None:
        self.film, self.table, self.angle = film, table, table.angle_tolerance

    @abstractmethod
    def write(self, path: Path, name: str) -> None:
        """Write a CAD file by its suffix; `name` is that of the job."""

    @abstractmethod
    def check_step(self, path: Path) -> StepCheck:
        """Return what film.step holds, measured against the film."""

    @abstractmethod
    def check_mesh(self, path: Path) -> MeshCheck:
        """Return what film.stl holds, measured against the film."""

    @abstractmethod
    def compare(self, step: Path, stl: Path, volume: float) -> Agreement:
        """Return how well both agree; `volume` [mm³] is what OCCT found in the STEP."""

    def check(self, path: Path) -> Check | None:
        """Return what a CAD file holds, by its suffix; None: it agrees, and is no body."""
        return self.check_step(path) if path.suffix == ".step" else self.check_mesh(path)

    def height(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the height [mm] of the surface over (x, y) [mm]."""
        return self.film.height(x, y)

    def grid(self) -> HeightGrid:
        """Return where the heights of the piece are taken for a height map."""
        across = self.table.inside("sample_across_um")
        across = across or self.film.groove.pitch / POINTS_PER_PITCH
        along = self.table.inside("sample_along_um")
        along = self.distance_along(across) if along is None else along
        return build_height_grid(self.film.size, (across, along), self.height)

    def distance_along(self, across: float) -> float:
        """Return the distance [mm] of a height map's points along y unless the job says."""
        return DISTANCE_ALONG

    def left_out(self) -> str | None:
        """Return what of the resin is too thin for the CAD files, in words; None: nothing."""
        return None

    def tile(self, first: int, count: int) -> "Kind | None":
        """Return some whole grooves of the piece as a film of its own; None: it is one piece."""
        return None

    @abstractmethod
    def curvature_difference(
        self, found: NDArray[np.float64], mapped: NDArray[np.float64], given: Print | None
    ) -> float | None:
        """Return the largest |C of the mask - C of the mesh| [1/mm].

        `found` is C recovered from the mesh, `mapped` (n,) the map's, which stands in for the
        mask's where `given` is None. None: there is nothing to compare.
        """

    def resin(self, mesh_volume: float, given: Print) -> ResinCheck | None:
        """Return the resin that the masks give, and that of a mesh of this volume [mm³]."""
        width, length = self.film.size
        full = width * length * given.process.groove.room
        by_mask = {
            name: full * float(np.mean(given.process.fill_fraction(ratio)))
            for name, ratio in given.ratio.items()
        }
        return ResinCheck(by_mask, mesh_volume - self.film.bare_volume, full)

    def reprint(self, piece: PrismFilm) -> Reprint | None:
        """Return how the film is printed with other resin, `piece` as designed.

        None: no print sets the resin, or no film with other resin is made of this kind.
        """
        return None

    @property
    def pieces(self) -> PieceLibrary | CellLibrary | None:
        """The film as a library of pieces or cells; None: it is made of none."""
        return None

    def refuse_trace(self, printed: PanelFilm, stack: Stack, where: str) -> None:
        """Refuse to trace a piece that is not what lies beside it on the panel, `printed`.

        Raises
        ------
        InputError
            that begins with `where`; a film of grooves is traced as it is.
        """
        return None  # the same all along; across, a piece is as wide as what repeats

    @property
    @abstractmethod
    def extent(self) -> str:
        """Size and number of what the CAD files hold, in words."""

    @abstractmethod
    def as_grooves(self, piece: PrismFilm) -> MadeFilm:
        """Return the film as grooves, `piece` as designed; of cells, one through their tips."""

    @abstractmethod
    def view(self, mesh: Path) -> "go.Figure":
        """Return the drawing of the mesh file in three dimensions."""

    @abstractmethod
    def film_section(
        self,
        piece: PrismFilm,
        position: NDArray[np.float64],
        aperture: NDArray[np.float64] | None,
        recovered: list[float] | None,
    ) -> dict[str, Any]:
        """Return what a page's section on the film shows, `template` among it.

        Position [mm] from the lamp's axis, aperture ratio and C [1/mm] from the mask by groove.
        """

    def mould_film(self, where: str) -> MadeFilm:
        """Return the grooves that a mould is made of.

        Raises
        ------
        InputError
            that begins with `where`, for a film that cannot be turned.
        """
        raise InputError(f"{where}: such a film cannot be turned: expected grooves for a mould")
