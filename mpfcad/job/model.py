"""The tables of a job, one model each.

Outside every quantity carries its unit in its name (`pitch_um`); the properties without a suffix
give the inside value (mm, rad).
"""

from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from mpfcad.job.film import FilmTable
from mpfcad.job.halftone import HalftoneTable
from mpfcad.job.screen import MaskTable, ProcessTable
from mpfcad.job.table import Positive, Table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Effort = Literal["quick", "standard", "final"]
_Row = Annotated[list[float], Field(min_length=2, max_length=2)]
Rows = Annotated[list[_Row], Field(min_length=2)]
#: Standard uncertainty [%] of the resin where neither process nor job states one.
ASSUMED_RESIN = 10.0
Series = Annotated[
    list[Annotated[list[Annotated[float, Field(allow_inf_nan=False)]], Field(min_length=1)]],
    Field(min_length=1, max_length=32),
]
DEFAULT_PRESET = "thesis-32in-mpf"
EFFORTS: tuple[Effort, ...] = ("quick", "standard", "final")


class MapTable(Table):
    """`[map]`: one curvature everywhere, or C over the lamp pitch or the panel: a file, or rows.

    `rows` are pairs of position_mm and curvature_per_mm, as the lines of a file would be;
    `series_per_mm` is c_ij of C = Σ c_ij cos(2πi x/Px) cos(2πj y/Py) over a cell of LEDs. Moulded
    cells may have another C along y: `curvature_along_per_mm` or `series_along_per_mm`.
    """

    MAY_LACK: ClassVar[bool] = False

    file: str | None = None
    curvature_per_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    rows: Rows | None = None
    series_per_mm: Series | None = None
    curvature_along_per_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    series_along_per_mm: Series | None = None
    extent: Literal["pitch", "panel", "cell"] = "pitch"
    repeat: Literal["repeat", "mirror"] = "repeat"

    @model_validator(mode="after")
    def _one_source(self) -> "MapTable":
        given = (self.file, self.curvature_per_mm, self.rows, self.series_per_mm)
        count = sum(value is not None for value in given)
        if count > 1 or (count == 0 and not self.MAY_LACK):
            raise ValueError("expected exactly one of file, curvature_per_mm, rows, series_per_mm")
        for name in ("series_per_mm", "series_along_per_mm"):
            if len({len(row) for row in getattr(self, name) or []}) > 1:
                raise ValueError(f"{name}: expected rows of one length")
        for own, along in (
            (self.curvature_per_mm, self.curvature_along_per_mm),
            (self.series_per_mm, self.series_along_per_mm),
        ):
            if own is None and along is not None:
                raise ValueError("of two curvatures: expected both constants, or both series")
        return self

    @property
    def states_along(self) -> bool:
        """Whether it states C along y apart from that along x; a file may hold it as well."""
        return self.curvature_along_per_mm is not None or self.series_along_per_mm is not None

    @property
    def is_given(self) -> bool:
        """Whether it states a map."""
        given = (self.file, self.curvature_per_mm, self.rows, self.series_per_mm)
        return any(value is not None for value in given)


class CrossedTable(MapTable):
    """`[crossed]`: the printed film across the first; empty: the same C at the same place."""

    MAY_LACK: ClassVar[bool] = True


class CadTable(Table):
    """`[cad]`: extent, bodies and header of the CAD files, facets' angle, height map's points."""

    extent: Literal["pitch", "panel"] = "pitch"
    bodies: Literal["separate", "fused"] = "separate"
    stl: Literal["whole", "tiles"] = "whole"
    step_protocol: Literal["ap214", "ap242"] = "ap214"
    author: Annotated[str, Field(max_length=200)] = ""
    organisation: Annotated[str, Field(max_length=200)] = ""
    length_mm: Annotated[Positive, Field(le=2000)] = 2.0
    angle_tolerance_deg: Annotated[Positive, Field(ge=0.01, le=5)] = 0.5
    width_mm: Annotated[Positive, Field(le=2000)] | None = None
    start_across_mm: Annotated[float, Field(ge=0, le=2000)] | None = None
    start_along_mm: Annotated[float, Field(ge=0, le=2000)] | None = None
    sample_across_um: Annotated[Positive, Field(le=10_000)] | None = None
    sample_along_um: Annotated[Positive, Field(le=2_000_000)] | None = None
    levels: Annotated[int, Field(ge=2, le=1024)] | None = None
    piece_mm: Annotated[Positive, Field(le=10)] | None = None

    #: The fields that cut a window out of a map that varies along the grooves too.
    WINDOW: ClassVar[tuple[str, ...]] = ("width_mm", "start_across_mm", "start_along_mm")

    def inside(self, field: str) -> float | None:
        """Return an optional length [mm]; None where it is not given."""
        return None if getattr(self, field) is None else self._inside(field)

    @property
    def length(self) -> float:
        """Length of the piece along the grooves [mm]."""
        return self._inside("length_mm")

    @property
    def angle_tolerance(self) -> float:
        """Largest angle [rad] between a facet and the surface it stands for."""
        return self._inside("angle_tolerance_deg")


class StackTable(Table):
    """`[stack]`: the backlight, a preset or a file, its thickness and single values overridden."""

    preset: str | None = None
    file: str | None = None
    thickness_mm: Annotated[Positive, Field(le=1000)] | None = None
    override: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _one_source(cls, table: Any) -> Any:
        if isinstance(table, dict):
            if "preset" in table and "file" in table:
                raise ValueError("give either preset or file, not both")
            if "preset" not in table and "file" not in table:
                return {**table, "preset": DEFAULT_PRESET}
        return table

    @property
    def thickness(self) -> float | None:
        """Reflector to the plate's underside [mm]; None leaves the preset's own."""
        return None if self.thickness_mm is None else self._inside("thickness_mm")


class ResinTable(Table):
    """`[resin]`: the fill's own material, particles in it, or what they scatter; else as prisms."""

    particle_radius_um: Positive | None = None
    particle_index: Annotated[Positive, Field(ge=1, le=4)] | None = None
    particle_density_per_mm3: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    scattering_per_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    asymmetry: Annotated[float, Field(ge=-0.99, le=0.99)] | None = None
    index: Annotated[float, Field(ge=1, le=4)] | None = None
    absorption_per_mm: Annotated[float, Field(ge=0, le=100)] | None = None

    @model_validator(mode="after")
    def _one_source(self) -> "ResinTable":
        particles = (self.particle_radius_um, self.particle_index, self.particle_density_per_mm3)
        material = self.index is not None or self.absorption_per_mm is not None
        if material and particles == (None, None, None) and self.scattering_per_mm is None:
            return self
        if (None in particles) == (self.scattering_per_mm is None):
            raise ValueError(
                "give either particle_radius_um, particle_index and particle_density_per_mm3, or "
                "scattering_per_mm, or index or absorption_per_mm alone"
            )
        if any(p is not None for p in particles) and self.asymmetry is not None:
            raise ValueError("particles have their own asymmetry: leave it out")
        return self

    def document(self) -> dict[str, float]:
        """Return the values by the stack's names of them."""
        values = self.model_dump(mode="json", exclude_none=True)
        return {f"resin_{key}": value for key, value in values.items()}


class GateTable(Table):
    """`[gates]`: the limits of the lamp-Mura contrast, of colour, and of what the screen prints."""

    contrast_pass: Annotated[Positive, Field(le=1)] = 0.012
    contrast_marginal: Annotated[Positive, Field(le=1)] = 0.018
    ratio_min: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] = 0.10
    ratio_max: Annotated[Positive, Field(le=1)] = 0.85
    ripple_curvature_per_mm: Positive = 0.5
    ripple_luminance: Annotated[Positive, Field(le=1)] = 0.005
    registration_curvature_per_mm: Positive = 1.0
    confidence_min: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] | None = None
    colour_max: Annotated[Positive, Field(le=1)] | None = None

    @model_validator(mode="after")
    def _order(self) -> "GateTable":
        if self.contrast_pass > self.contrast_marginal:
            raise ValueError(
                f"contrast_pass = {self.contrast_pass:g}: expected at most "
                f"contrast_marginal = {self.contrast_marginal:g}"
            )
        return self


class TraceTable(Table):
    """`[trace]`: how long to trace."""

    effort: Effort = "standard"


class BaselineTable(Table):
    """`[baseline]`: the backlight, with a plain BEF in it, that the film's light is compared with.

    Without the table it is the job's own backlight.
    """

    preset: str


class ConfidenceTable(Table):
    """`[confidence]`: how well film and print are known (standard uncertainties), and the traces.

    `covariance` is a CSV of inputs that hang together; `names` and `matrix` are what it holds.
    `resin_percent` is for a process that does not state its own width.
    """

    resin_percent: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] | None = None
    registration_mm: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] = 0.3
    depth_um: Annotated[float, Field(ge=0, le=100, allow_inf_nan=False)] = 0.25
    base_um: Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)] = 5.0
    paths_million: Annotated[Positive, Field(le=10_000)] = 6.5
    covariance: str | None = None
    names: list[str] | None = None
    matrix: list[list[float]] | None = None

    @model_validator(mode="after")
    def _one_covariance(self) -> "ConfidenceTable":
        if (self.names is None) != (self.matrix is None):
            raise ValueError("expected both names and matrix, or neither")
        if self.covariance is not None and self.names is not None:
            raise ValueError("expected either covariance or names and matrix")
        if self.names is not None and self.matrix is not None:
            self._check_matrix(self.names, self.matrix)
        return self

    @staticmethod
    def _check_matrix(names: list[str], matrix: list[list[float]]) -> None:
        import numpy as np

        from mpfcad.confidence import covariance_fault

        if not names or [len(row) for row in matrix] != [len(names)] * len(names):
            raise ValueError(
                f"matrix: expected {len(names) or 'some'} rows of as many numbers, one each name"
            )
        fault = covariance_fault(names, np.array(matrix, np.float64))
        if fault:
            raise ValueError(f"matrix: {fault}")

    @property
    def resin_or_assumed(self) -> float:
        """`resin_percent`, or what is assumed without one."""
        return ASSUMED_RESIN if self.resin_percent is None else self.resin_percent

    def covariance_of(self) -> "tuple[list[str], NDArray[np.float64]] | None":
        """Return names and covariance (n, n) of the inputs that hang together."""
        if self.names is None:
            return None
        import numpy as np

        return self.names, np.array(self.matrix, np.float64)

    def sigmas(self) -> dict[str, float]:
        """Return the standard uncertainties that the covariance states."""
        found = self.covariance_of()
        if found is None:
            return {}
        return {name: float(found[1][i, i]) ** 0.5 for i, name in enumerate(found[0])}


class Job(Table):
    """A whole job; `name` and `[map]` are all that must be given."""

    version: Literal[1] = Field(default=1, alias="schema")
    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,63}$")]
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1
    map: MapTable
    film: FilmTable = FilmTable()
    process: ProcessTable = ProcessTable()
    mask: MaskTable = MaskTable()
    cad: CadTable = CadTable()
    stack: StackTable = StackTable(preset=DEFAULT_PRESET)
    resin: ResinTable | None = None
    gates: GateTable = GateTable()
    trace: TraceTable = TraceTable()
    baseline: BaselineTable | None = None
    crossed: CrossedTable | None = None
    halftone: HalftoneTable | None = None
    confidence: ConfidenceTable | None = None

    @property
    def has_cells(self) -> bool:
        """Whether the film is pyramids or dishes held as a library: of a map, or of two C."""
        varies = self.map.curvature_per_mm is None or self.map.states_along
        return self.film.cell != "groove" and varies

    @property
    def is_printed(self) -> bool:
        """Whether a mask prints the film: grooves, or valleys between pyramids, with resin."""
        cell = self.film.cell == "groove" or (self.film.cell == "pyramid" and self.has_cells)
        return self.film.profile == "filled" and cell

    @property
    def wants_confidence(self) -> bool:
        """Whether the verdict's confidence is to be found."""
        return self.confidence is not None or self.gates.confidence_min is not None

    @property
    def confidence_table(self) -> ConfidenceTable:
        """`[confidence]`, or its defaults."""
        return self.confidence or ConfidenceTable()

    def document(self) -> dict[str, Any]:
        """Return the job as plain JSON values, every default written out."""
        absent = {"halftone"} if self.halftone is None else None  # as jobs before it were written
        return self.model_dump(mode="json", by_alias=True, exclude=absent)

    def given(self) -> dict[str, Any]:
        """Return only what the job's file states; `build_job` makes the same job of it again."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)
