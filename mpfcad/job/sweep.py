"""The tables of a sweep: a job's, and the axes along which its values vary."""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mpfcad.job.design import ConstraintTable, GoalTable, Name, SearchTable
from mpfcad.job.reader import read_document, validate
from mpfcad.job.table import Positive, Table

#: Axes besides the fields of a job: fill in the curvature's place, lamps spread evenly over the
#: panel, and the film's place.
FILL_AXIS, LAMP_AXIS = "fill_fraction", "lamp_count"
REGISTRATION_AXES = ("shift_mm", "stretch_percent", "rotation_deg", "lamp_pitch_error_mm")
#: Those under LEDs: registration of the board and of each film, their print, the board's binning.
LED_AXES = (
    "board_shift_x_mm", "board_shift_y_mm", "shift_x_mm", "shift_y_mm", "turn_deg",
    "crossed_shift_x_mm", "crossed_shift_y_mm", "crossed_turn_deg", "stretch_percent",
    "curvature_error_per_mm", "pattern_percent", "resin_percent",
    "led_repeat", "led_seed", "dead_led", FILL_AXIS,
)  # fmt: skip
_OWN_AXES = tuple(dict.fromkeys((FILL_AXIS, LAMP_AXIS, *REGISTRATION_AXES, *LED_AXES)))
#: Tables that ask for something even where they are empty.
_ASKING = ("crossed", "confidence")
_TABLES = ("map", "film", "process", "mask", "cad", "stack", "halftone", *_ASKING)
Value = Annotated[float, Field(allow_inf_nan=False)] | str


class SweepTraceTable(Table):
    """`[trace]`: how long each point is traced."""

    half_width: Annotated[float, Field(ge=0, le=1)] = 0.003
    paths_million: Annotated[Positive, Field(le=1000)] = 6.0


class SweepDesignTable(Table):
    """`[design]`: every point's map is searched, as `mpfcad design` does."""

    goal: GoalTable = GoalTable()
    constraint: ConstraintTable = ConstraintTable()
    search: SearchTable = SearchTable()


class Sweep(Table):
    """A whole sweep: the job of every point, and `[axis]`: a list of values each."""

    version: Literal[1] = Field(default=1, alias="schema")
    name: Name
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    contrast_limit: Annotated[Positive, Field(le=1)] = 0.018
    axis: Annotated[dict[str, Annotated[list[Value], Field(min_length=1)]], Field(min_length=1)]
    trace: SweepTraceTable = SweepTraceTable()
    design: SweepDesignTable | None = None
    map: dict[str, Any] = Field(default_factory=dict)
    film: dict[str, Any] = Field(default_factory=dict)
    process: dict[str, Any] = Field(default_factory=dict)
    mask: dict[str, Any] = Field(default_factory=dict)
    cad: dict[str, Any] = Field(default_factory=dict)
    stack: dict[str, Any] = Field(default_factory=dict)
    halftone: dict[str, Any] = Field(default_factory=dict)
    crossed: dict[str, Any] | None = None
    confidence: dict[str, Any] | None = None

    @model_validator(mode="after")
    def _known_axes(self) -> "Sweep":
        for axis, values in self.axis.items():
            if axis.partition(".")[0] not in _TABLES or "." not in axis:
                if axis not in _OWN_AXES:
                    raise ValueError(
                        f"axis {axis}: expected table.field of a job or one of "
                        f"{', '.join(_OWN_AXES)}"
                    )
                if not all(isinstance(value, float) for value in values):
                    raise ValueError(f"axis {axis}: expected numbers")
            if len(set(values)) < len(values) or len({type(v) for v in values}) > 1:
                raise ValueError(f"axis {axis}: expected all numbers or all words, none twice")
            free = "." in axis or axis == LAMP_AXIS
            if self.design and (not free or axis[:4] == "map."):
                raise ValueError(f"axis {axis}: has no meaning where [design] finds the map")
        if self.design and self.design.goal.aim == "confidence":
            raise ValueError('design.goal.aim = "confidence": expected another aim in a sweep')
        if self.design and self.map:
            raise ValueError("map: expected no map where [design] finds it")
        return self

    def document(self) -> dict[str, Any]:
        """Return the sweep as plain JSON values, every default written out."""
        return self.model_dump(mode="json", by_alias=True)

    def points(self) -> Iterator[dict[str, Value]]:
        """Give the coordinates of every point, the last axis fastest."""
        for values in itertools.product(*self.axis.values()):
            yield dict(zip(self.axis, values, strict=True))

    def job_document(self, point: dict[str, Value]) -> dict[str, Any]:
        """Return the document of a point's job; fill and registration are not in it."""
        document = {"schema": 1, "name": self.name, "seed": self.seed}
        for table in _TABLES:
            given = getattr(self, table)
            if given or (table in _ASKING and given is not None):
                document[table] = _copied(given)
        for axis, value in point.items():
            *tables, field = axis.split(".")
            if not tables:
                continue
            place: dict[str, Any] = document
            for table in tables:
                place = place.setdefault(table, {})
            place[field] = value
        return document


def _copied(table: dict[str, Any]) -> dict[str, Any]:
    return {k: _copied(v) if isinstance(v, dict) else v for k, v in table.items()}


def read_sweep(path: Path) -> Sweep:
    """Return the sweep in the TOML file at `path`.

    Raises
    ------
    InputError
        when the file cannot be read, is no TOML (naming the line), or a field is wrong.
    """
    return validate(Sweep, read_document(path), str(path))
