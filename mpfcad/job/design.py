"""The tables of a design: what is wanted, within what, and how it is searched."""

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mpfcad.job.model import (
    BaselineTable,
    CadTable,
    ConfidenceTable,
    FilmTable,
    GateTable,
    MaskTable,
    Positive,
    ProcessTable,
    StackTable,
    Table,
    TraceTable,
)
from mpfcad.job.reader import read_document, validate

Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]


class GoalTable(Table):
    """`[goal]`: least contrast, most luminance within it, a trade of both, or most confidence."""

    aim: Literal["contrast", "luminance", "trade", "confidence"] = "contrast"
    contrast_target: Annotated[Positive, Field(le=1)] = 0.008
    luminance_weight: Annotated[Positive, Field(le=100)] | None = None

    @model_validator(mode="after")
    def _weight_for_trade(self) -> "GoalTable":
        if (self.aim == "trade") != (self.luminance_weight is not None):
            raise ValueError('luminance_weight belongs to aim = "trade"')
        return self


class ConstraintTable(Table):
    """`[constraint]`: what the map may be."""

    curvature_min_per_mm: Annotated[Positive, Field(le=10_000)] = 20.0
    curvature_max_per_mm: Annotated[Positive, Field(le=10_000)] | None = None
    change_max_per_mm2: Annotated[Positive, Field(le=10_000)] = 10.0
    harmonics: Annotated[int, Field(ge=1, le=12)] = 4
    levels: Annotated[int, Field(ge=2, le=1000)] | None = None
    registration_mm: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] = 0.0


class ThicknessTable(Table):
    """`[thickness]`: the least one that serves is searched, in the place of the stack's."""

    min_mm: Annotated[Positive, Field(le=1000)]
    max_mm: Annotated[Positive, Field(le=1000)]
    step_mm: Annotated[Positive, Field(le=1000)] = 0.5

    @model_validator(mode="after")
    def _order(self) -> "ThicknessTable":
        if self.min_mm >= self.max_mm:
            raise ValueError(f"max_mm = {self.max_mm:g}: expected above min_mm = {self.min_mm:g}")
        return self

    def values(self) -> list[float]:
        """Return the thicknesses [mm] that may come out, ascending; the largest among them."""
        count = math.ceil((self.max_mm - self.min_mm) / self.step_mm - 1e-9)
        inner = [round(self.min_mm + i * self.step_mm, 6) for i in range(count)]
        return [*inner, self.max_mm]


class SearchTable(Table):
    """`[search]`: the method and what it may trace."""

    method: Literal["response", "thesis"] = "response"
    iterations: Annotated[int, Field(ge=1, le=100)] = 4
    paths_million: Annotated[Positive, Field(le=1000)] = 3.0
    uniform_per_mm: Annotated[list[Positive], Field(min_length=2)] | None = None

    @model_validator(mode="after")
    def _ascending(self) -> "SearchTable":
        films = self.uniform_per_mm
        if films is not None and sorted(set(films)) != films:
            raise ValueError("uniform_per_mm: expected ascending numbers")
        return self


class Design(Table):
    """A whole design: the tables of a job but its map, and what the map has to do."""

    version: Literal[1] = Field(default=1, alias="schema")
    name: Name
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    goal: GoalTable = GoalTable()
    constraint: ConstraintTable = ConstraintTable()
    search: SearchTable = SearchTable()
    thickness: ThicknessTable | None = None
    film: FilmTable = FilmTable()
    process: ProcessTable = ProcessTable()
    mask: MaskTable = MaskTable()
    cad: CadTable = CadTable()
    stack: StackTable = StackTable(preset="thesis-32in-mpf")
    gates: GateTable = GateTable()
    trace: TraceTable = TraceTable()
    baseline: BaselineTable | None = None
    confidence: ConfidenceTable | None = None

    @model_validator(mode="after")
    def _one_aim(self) -> "Design":
        if self.goal.aim != "confidence":
            return self
        if self.search.method == "thesis":
            raise ValueError('goal.aim = "confidence": expected search.method = "response"')
        if self.thickness is not None:
            raise ValueError('goal.aim = "confidence": expected one thickness, no [thickness]')
        return self

    @model_validator(mode="after")
    def _one_thickness(self) -> "Design":
        if self.thickness is None:
            return self
        if self.stack.thickness_mm is not None:
            raise ValueError("stack.thickness_mm: expected no such field beside [thickness]")
        if self.search.method == "thesis":
            raise ValueError('search.method = "thesis" has no model to find a thickness by')
        return self

    def at_thickness(self, thickness: float, override: dict[str, Any] | None = None) -> "Design":
        """Return the design for one thickness [mm], with further values of the stack changed."""
        change: dict[str, Any] = {"thickness_mm": thickness}
        if override:
            change["override"] = {**self.stack.override, **override}
        stack = self.stack.model_copy(update=change)
        return self.model_copy(update={"stack": stack, "thickness": None})

    def document(self) -> dict[str, Any]:
        """Return the design as plain JSON values, every default written out."""
        return self.model_dump(mode="json", by_alias=True)

    def job_document(self, map_file: str) -> dict[str, Any]:
        """Return the document of the job of a map, with what the design states."""
        given = self.model_dump(mode="json", by_alias=True, exclude_unset=True)
        tables = {key: given[key] for key in JOB_TABLES if key in given}
        head = {"schema": 1, "name": self.name, "seed": self.seed}
        return {**head, "map": {"file": map_file, "extent": "pitch"}, **tables}


#: Tables that a design hands on to its job.
JOB_TABLES = ("film", "process", "mask", "cad", "stack", "gates", "trace", "baseline", "confidence")


def read_design(path: Path) -> Design:
    """Return the design in the TOML file at `path`.

    Raises
    ------
    InputError
        when the file cannot be read, is no TOML (naming the line), or a field is wrong.
    """
    return validate(Design, read_document(path), str(path))
