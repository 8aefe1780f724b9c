"""The film whose inputs are changed: that of a job, or any that is given."""

from dataclasses import dataclass
from typing import Protocol

from mpfcad.film import PrismFilm, Process
from mpfcad.job import Job


class Subject(Protocol):
    """What is known of a film besides its mesh; a `Plan` is one."""

    @property
    def piece(self) -> PrismFilm | None:
        """The film as designed; None where only the mesh is known."""

    @property
    def drawn(self) -> object:
        """What the mesh holds: `piece` itself, or it as made."""

    @property
    def process(self) -> Process | None:
        """What prints it, where that is known."""

    @property
    def offset(self) -> float:
        """Position of the mesh's left edge from a lamp's axis [mm]."""

    @property
    def angle_tolerance(self) -> float:
        """Largest angle of a facet [rad]."""

    @property
    def job(self) -> Job | None:
        """The job that makes it, with its widths and limits."""


@dataclass(frozen=True, eq=False)
class GivenFilm:
    """A film that no job makes, a mesh or a plain one, or a job's film elsewhere.

    Attributes
    ----------
    offset
        position of its left edge from a lamp's axis [mm]
    angle_tolerance
        largest angle of a facet of a changed one [rad]
    piece, drawn
        as designed, and what its mesh holds; None of a mesh alone
    process
        what prints it; None where that is not known
    job
        that makes it, if there is one
    """

    offset: float
    angle_tolerance: float
    piece: PrismFilm | None = None
    drawn: object = None
    process: Process | None = None
    job: Job | None = None
