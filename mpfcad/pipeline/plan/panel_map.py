"""What a job wants of each place of the panel: a curvature a groove, or a map C(x, y)."""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.film import FieldFilm, Groove, PrismFilm
from mpfcad.job import Job
from mpfcad.pipeline.plan.field import cut_window, field_section
from mpfcad.pipeline.plan.made import Drawn, draw_piece
from mpfcad.pipeline.plan.printed.nearest import Asked
from mpfcad.pipeline.plan.size import groove_count, refuse_mesh

#: Equal cells along each side of what is traced under LEDs.
_EQUAL = 4


class Laid(NamedTuple):
    """A map laid onto the panel, and its part that the CAD files hold; as `Plan` has them."""

    panel: PrismFilm
    piece: PrismFilm
    drawn: Drawn
    first_groove: int
    field_film: FieldFilm | None
    measured: NDArray[np.float64] | None
    along: NDArray[np.float64] | None = None


class PanelMap(Protocol):
    """The map of a job over the panel, as the export will hold it."""

    @property
    def curvature(self) -> NDArray[np.float64]:
        """Every curvature [1/mm] that a screen has to print, one axis."""

    @property
    def is_grooves(self) -> bool:
        """Whether that is one a groove, counted from 0."""

    @property
    def crossed(self) -> "PanelMap | None":
        """The map of a second film that lies across, if there is one."""

    def lay(self, job: Job, stack: Stack, measured: NDArray[np.float64] | None, where: str) -> Laid:
        """Return the panel and its piece; `measured` is the job's mean groove, if it has one.

        Raises
        ------
        InputError
            that begins with `where`, for what cannot be drawn.
        """


@dataclass(frozen=True, eq=False)
class GrooveMap:
    """A curvature a groove, (n,) float64 [1/mm]."""

    curvature: NDArray[np.float64]
    is_grooves: ClassVar[bool] = True
    crossed: ClassVar[None] = None

    def lay(self, job: Job, stack: Stack, measured: NDArray[np.float64] | None, where: str) -> Laid:
        """Return the panel of these grooves, and the piece as the job says it is made."""
        panel = PrismFilm(
            groove=job.film.groove,
            base=job.film.base,
            length=stack.panel_length,
            profile=job.film.profile,
            curvature=self.curvature,
        )
        first, piece = _cut_piece(job, stack, panel)
        refuse_mesh(job, piece.groove_count, where)
        drawn = draw_piece(job, piece, measured, where)
        return Laid(panel, piece, drawn, first, None, measured)


@dataclass(frozen=True, eq=False)
class FieldMap:
    """A curvature that varies along the grooves too."""

    film: FieldFilm
    is_grooves: ClassVar[bool] = False
    crossed: ClassVar[None] = None

    @property
    def curvature(self) -> NDArray[np.float64]:
        """The curvature [1/mm] of every node of the map."""
        return np.ravel(self.film.field.curvature)

    def lay(self, job: Job, stack: Stack, measured: NDArray[np.float64] | None, where: str) -> Laid:
        """Return the panel's section at the window's lower end, and the window."""
        first, window = cut_window(job, self.film, stack, where)
        if stack.needs_prism:
            raise InputError(
                f"{where}: resin: scatters or is of another material: expected a map that does "
                "not vary along the grooves"
            )
        panel = field_section(self.film, window.origin[1], job.film.base)
        piece = panel.cut(first, window.groove_count, window.size[1])
        return Laid(panel, piece, window, first, self.film, None)


def asked_of(panel_map: PanelMap) -> Asked:
    """Return what a screen has to print of a map."""
    return Asked(panel_map.curvature, is_grooves=panel_map.is_grooves)


def as_written(curvature: NDArray[np.float64], groove: Groove) -> NDArray[np.float64]:
    """Return the curvatures as curvature.csv holds them, so that it alone defines the film."""
    # Nine digits may lie above the empty groove's curvature where all digits do not.
    written = np.array([float(f"{value:.9g}") for value in curvature])
    over = (written > groove.curvature_empty) & (curvature <= groove.curvature_empty * (1 + 1e-12))
    return np.where(over, [float(f"{value * (1 - 5e-10):.9g}") for value in curvature], written)


def _cut_piece(job: Job, stack: Stack, panel: PrismFilm) -> tuple[int, PrismFilm]:
    """Return the first groove and the piece: a lamp pitch from a central lamp on, or all."""
    if job.cad.extent == "panel":
        return 0, panel
    pitch = panel.groove.pitch
    if stack.period.along > 0:
        # Equal cells under LEDs: a small square that repeats is the whole film.
        count = min(_EQUAL, panel.groove_count)
        return 0, panel.cut(0, count, count * pitch)
    count = min(groove_count(stack.period.across, pitch), panel.groove_count)
    first = round(stack.origin[0] / pitch)
    first = min(max(first, 0), panel.groove_count - count)
    return first, panel.cut(first, count, job.cad.length)
