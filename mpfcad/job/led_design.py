"""The tables of a design for LEDs: how many films are printed, within what, and the search."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mpfcad.job.design import Name
from mpfcad.job.halftone import HalftoneTable
from mpfcad.job.model import (
    FilmTable,
    MaskTable,
    Positive,
    ProcessTable,
    ResinTable,
    StackTable,
    Table,
)
from mpfcad.job.reader import read_document, validate

KIND = "leds"
_MOST_BOARDS = 100
#: What holds of cells unless the design says: C [1/mm] of a print and of a mould, even films of a
#: mould [1/mm], angle of facets [°].
_PRINTED, MOULDED, _EVEN, _ANGLE = (40.0, 80.0), (20.0, 100.0), [30.0, 50.0, 70.0], 2.0
#: Between the limits of a halftone's map and its two curvatures [1/mm]: a series is held at other
#: places than those of the pieces.
_ROOM = 0.1


class LedGoalTable(Table):
    """`[goal]`: the contrast at which the search ends, and what the map is for.

    `aim`: `contrast`, of one board; or the thinnest, sparsest or fewest-LED board of `[range]`
    whose contrast reaches the target.
    """

    aim: Literal["contrast", "thinnest", "sparsest", "fewest"] = "contrast"
    contrast_target: Annotated[Positive, Field(le=1)] = 0.018


class LedRangeTable(Table):
    """`[range]`: thicknesses or LED pitches [mm], or numbers of LEDs across, that may come out."""

    min: Positive
    max: Positive
    step: Positive = 0.5

    @model_validator(mode="after")
    def _order(self) -> "LedRangeTable":
        if self.min >= self.max:
            raise ValueError(f"max = {self.max:g}: expected above {self.min:g}")
        if (self.max - self.min) / self.step > _MOST_BOARDS:
            raise ValueError(f"step = {self.step:g}: expected at most {_MOST_BOARDS} steps")
        return self


class LedConstraintTable(Table):
    """`[constraint]`: what the map may be, and how it is held.

    `angle_tolerance_deg`: of the files' facets; none is that of a job, of cells 2.
    """

    curvature_min_per_mm: Annotated[Positive, Field(le=10_000)] = 55.0
    curvature_max_per_mm: Annotated[Positive, Field(le=10_000)] = 78.0
    harmonics: Annotated[int, Field(ge=1, le=4)] = 2
    levels: Annotated[int, Field(ge=2, le=1024)] = 64
    piece_mm: Annotated[Positive, Field(le=10)] = 0.5
    angle_tolerance_deg: Annotated[Positive, Field(ge=0.01, le=5)] | None = None
    solids_fraction_min: Annotated[Positive, Field(le=1)] | None = None
    solids_fraction_max: Annotated[Positive, Field(le=1)] | None = None

    @model_validator(mode="after")
    def _order(self) -> "LedConstraintTable":
        least, most = self.solids_fraction_min or 0.0, self.solids_fraction_max or 1.0
        if least > most:
            raise ValueError(f"solids_fraction_max = {most:g}: expected at least {least:g}")
        return self


class LedSearchTable(Table):
    """`[search]`: uniform films tried first, corrections after, and paths of each trace."""

    uniform_per_mm: Annotated[list[Positive], Field(min_length=1)] = Field(
        default_factory=lambda: [58.0, 66.0, 74.0]
    )
    iterations: Annotated[int, Field(ge=0, le=20)] = 3
    paths_million: Annotated[Positive, Field(le=1000)] = 2.0


class LedToleranceTable(Table):
    """`[tolerance]`: departures from the design whose contrast is traced; 0 leaves one out.

    `shift_mm`: none is 4 % of the LEDs' smaller pitch. `resin_percent` is of films that are
    printed, `curvature_per_mm` of those that are moulded.
    """

    shift_mm: Annotated[float, Field(ge=0, le=100)] | None = None
    resin_percent: Annotated[float, Field(ge=0, le=50)] = 10.0
    curvature_per_mm: Annotated[float, Field(ge=0, le=20)] = 1.0
    flux_percent: Annotated[float, Field(ge=0, le=50)] = 5.0
    half_width: Annotated[Positive, Field(le=1)] = 0.004
    paths_million: Annotated[Positive, Field(le=1000)] = 4.0


class LedDesign(Table):
    """A whole design for LEDs.

    `films`: 1, a printed film in the job's place; 2, one more crossed over it, in the place of the
    stack's film that is turned by 90°, with the same curvature at the same place. One film may have
    `film.cell`, pyramids or dishes; with `halftone` every film is one. `process` and `mask` go into
    the job that is found; the search asks neither.
    """

    version: Literal[1] = Field(default=1, alias="schema")
    kind: Literal["leds"]
    name: Name
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    films: Literal[1, 2] = 2
    goal: LedGoalTable = LedGoalTable()
    constraint: LedConstraintTable = LedConstraintTable()
    search: LedSearchTable = LedSearchTable()
    tolerance: LedToleranceTable = LedToleranceTable()
    film: FilmTable = FilmTable()
    process: ProcessTable | None = None
    mask: MaskTable | None = None
    stack: StackTable
    resin: ResinTable | None = None
    halftone: HalftoneTable | None = None
    range: LedRangeTable | None = None

    @model_validator(mode="after")
    def _range(self) -> "LedDesign":
        if (self.goal.aim == "contrast") != (self.range is None):
            raise ValueError(
                f"range: goal.aim {self.goal.aim}: expected [range] with min, max and step for "
                "thinnest, sparsest or fewest, and only there"
            )
        if self.goal.aim == "fewest" and self.range is not None:
            ends = (self.range.min, self.range.max, self.range.step)
            if any(end != int(end) for end in ends):
                raise ValueError("range: of numbers of LEDs: expected whole numbers")
        return self

    @model_validator(mode="after")
    def _limits(self) -> "LedDesign":
        if self.has_cells:
            self._refuse_of_cells()
            low, high = _PRINTED if self.is_printed else MOULDED
            most = min(high, self.film.groove.curvature_most(self.film.profile))
            self._by_kind("constraint", "curvature_min_per_mm", low)
            self._by_kind("constraint", "curvature_max_per_mm", most)
            self._by_kind("constraint", "angle_tolerance_deg", _ANGLE)
        if self.halftone is not None:
            self._limit_halftone(self.halftone.curvature_per_mm)
        low, high = self.constraint.curvature_min_per_mm, self.constraint.curvature_max_per_mm
        if low >= high:
            raise ValueError(f"constraint.curvature_max_per_mm = {high:g}: expected above {low:g}")
        known = self.search.uniform_per_mm if self.is_printed else _EVEN
        inside = [c for c in known if low < c < high]
        self._by_kind("search", "uniform_per_mm", inside or [(low + high) / 2])
        self._refuse_outside(low, high)
        return self

    def _refuse_outside(self, low: float, high: float) -> None:
        even = self.search.uniform_per_mm
        one = self.films == 1  # about which the response is measured
        outside = [c for c in even if not low <= c <= high or (one and c in (low, high))]
        if outside:
            ends = ", off their ends" if one else ""
            raise ValueError(
                f"search.uniform_per_mm: {outside[0]:g}: expected within the limits of C, "
                f"{low:g} … {high:g}{ends}"
            )

    def _by_kind(self, table: str, name: str, value: Any) -> None:
        """Set a field of a table that the design does not state; it stays one that it does not."""
        own = getattr(self, table)
        if name not in own.model_fields_set:
            changed = own.model_copy()
            changed.__dict__[name] = value
            self.__dict__[table] = changed

    def _limit_halftone(self, printed: float) -> None:
        """Hold a halftone's limits of C, and the even films, between its two curvatures [1/mm]."""
        bare = self.film.groove.curvature_empty
        low, high = printed + _ROOM, bare - _ROOM
        self._by_kind("constraint", "curvature_min_per_mm", low)
        self._by_kind("constraint", "curvature_max_per_mm", high)
        limit = self.constraint
        for name, values, ends in (
            ("constraint.curvature_min_per_mm", [limit.curvature_min_per_mm], (low, high)),
            ("constraint.curvature_max_per_mm", [limit.curvature_max_per_mm], (low, high)),
            ("search.uniform_per_mm", self.search.uniform_per_mm, (printed, bare)),
        ):
            outside = [c for c in values if not ends[0] <= c <= ends[1]]
            if outside:
                raise ValueError(
                    f"{name}: {outside[0]:g}: expected {ends[0]:g} … {ends[1]:g}, from "
                    "halftone.curvature_per_mm to bare prisms"
                )
        states_solids = (limit.solids_fraction_min, limit.solids_fraction_max) != (None, None)
        if states_solids and self.process is not None and self.process.flow is not None:
            raise ValueError(
                "constraint.solids_fraction_min: the levelling of a halftone by viscosity_pa_s "
                "hangs on it: expected mask.levelling_length_mm, or one solids_fraction"
            )

    def _refuse_of_cells(self) -> None:
        film, limit = self.film, self.constraint
        words = f"film.cell {film.cell}, profile {film.profile}"
        if self.films != 1:
            raise ValueError(f"films = 2: {words}: expected 1: cells are patterned both ways")
        if film.cell == "paraboloid" and film.profile != "ideal":
            raise ValueError(f"{words}: expected 'ideal', a mould's")
        if "piece_mm" in limit.model_fields_set:
            raise ValueError(f"constraint.piece_mm: {words}: expected to be left out for cells")
        solids = limit.solids_fraction_min, limit.solids_fraction_max
        if not self.is_printed and solids != (None, None):
            raise ValueError(f"constraint.solids_fraction: {words}: no print makes it")

    @property
    def has_cells(self) -> bool:
        """Whether the film is pyramids or dishes."""
        return self.film.cell != "groove"

    @property
    def is_printed(self) -> bool:
        """Whether a mask prints the films; a mould makes the others."""
        return self.film.profile == "filled"

    def document(self) -> dict[str, Any]:
        """Return the design as plain JSON values, every default written out."""
        return self.model_dump(mode="json", by_alias=True)


def build_led_design(document: dict[str, Any], where: str) -> LedDesign:
    """Return the design of a document.

    Raises
    ------
    InputError
        that begins with `where`, naming the field that is wrong.
    """
    return validate(LedDesign, document, where)


def is_led_design(path: Path) -> bool:
    """Return whether a design file is for LEDs: `kind = "leds"`."""
    return read_document(path).get("kind") == KIND


def read_led_design(path: Path) -> LedDesign:
    """Return the design in the TOML file at `path`.

    Raises
    ------
    InputError
        when the file cannot be read, is no TOML (naming the line), or a field is wrong.
    """
    return build_led_design(read_document(path), str(path))
