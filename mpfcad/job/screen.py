"""`[process]`, `[mask]` and `[mask.mesh]`: what is printed, and the screen that prints it."""

from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from mpfcad.job.table import Positive, Table

MaskFormat = Literal["oas", "gds", "dxf", "gbr", "svg", "tif"]
FurnitureName = Literal["fiducial", "text", "coupon"]
DEFAULT_FORMATS: tuple[MaskFormat, ...] = ("oas", "gds")
DEFAULT_FURNITURE: tuple[FurnitureName, ...] = ("fiducial", "text", "coupon")


class ProcessTable(Table):
    """`[process]`: calibration or model of the screen printing, and how the resin levels."""

    calibration: str | None = None
    model: Literal["prior", "linear", "thesis"] | None = None
    solids_fraction: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] = 1.0
    viscosity_pa_s: Annotated[Positive, Field(le=1000)] | None = None
    surface_tension_mn_m: Annotated[Positive, Field(le=1000)] | None = None
    contact_angle_deg: Annotated[float, Field(ge=0, le=180, allow_inf_nan=False)] | None = None
    time_to_uv_s: Annotated[Positive, Field(le=100_000)] | None = None

    #: What a resin's levelling is worked out from, all of them or none.
    FLOW: ClassVar[tuple[str, ...]] = (
        "viscosity_pa_s",
        "surface_tension_mn_m",
        "contact_angle_deg",
        "time_to_uv_s",
    )

    @model_validator(mode="after")
    def _whole(self) -> "ProcessTable":
        given = [name for name in self.FLOW if getattr(self, name) is not None]
        # The contact angle alone gives the shape of a resin at rest (film.surface = "arc").
        if given not in ([], ["contact_angle_deg"]) and len(given) < len(self.FLOW):
            missing = ", ".join(name for name in self.FLOW if name not in given)
            raise ValueError(f"{', '.join(given)} given: expected {missing} too")
        if self.calibration is not None and self.model is not None:
            raise ValueError("expected either calibration or model")
        return self

    @property
    def flow(self) -> dict[str, float] | None:
        """Viscosity [Pa·s], surface tension [N/m], contact angle [rad], time [s]; None: unknown."""
        tension, time = self.surface_tension_mn_m, self.time_to_uv_s
        if self.viscosity_pa_s is None or tension is None or time is None:
            return None
        return {
            "viscosity": self.viscosity_pa_s,
            "surface_tension": tension / 1000,
            "contact_angle": self._inside("contact_angle_deg"),
            "time": time,
        }


class MeshTable(Table):
    """`[mask.mesh]`: the screen's mesh, by name or by count and thread, and how it is used."""

    name: str | None = None
    catalogue: str | None = None
    threads_per_cm: Annotated[Positive, Field(le=1000)] | None = None
    thread_um: Annotated[Positive, Field(le=1000)] | None = None
    opening_um: Annotated[Positive, Field(le=1000)] | None = None
    thickness_um: Annotated[Positive, Field(le=1000)] | None = None
    open_area_percent: Annotated[Positive, Field(lt=100)] | None = None
    ink_volume_cm3_m2: Annotated[Positive, Field(le=1000)] | None = None
    material: Literal["polyester", "steel", "calendered steel"] = "polyester"
    emulsion_um: Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)] = 0.0
    angle_deg: Annotated[float, Field(ge=0, le=90, allow_inf_nan=False)] = 22.5
    release: Annotated[Positive, Field(le=1)] | None = None

    #: Figures of a data sheet, which a mesh by name brings with it.
    FIGURES: ClassVar[tuple[str, ...]] = (
        "opening_um",
        "thickness_um",
        "open_area_percent",
        "ink_volume_cm3_m2",
    )

    @model_validator(mode="after")
    def _one_source(self) -> "MeshTable":
        count = (self.threads_per_cm, self.thread_um)
        if (self.name is None) == (None in count) or (self.name and any(count)):
            raise ValueError("expected either name, or threads_per_cm and thread_um")
        if self.name is None and self.catalogue is not None:
            raise ValueError("catalogue: expected with a name that is in it")
        own = [name for name in self.FIGURES if getattr(self, name) is not None]
        if self.name is not None and own:
            raise ValueError(
                f"{', '.join(own)}: expected to be left out: a mesh by name has its own"
            )
        return self

    @property
    def is_auto(self) -> bool:
        """Whether the program chooses the mesh."""
        return self.name is not None and self.name.strip().casefold() == "auto"

    @property
    def opening(self) -> float | None:
        """Between threads [mm], when it is known."""
        return None if self.opening_um is None else self._inside("opening_um")

    @property
    def thread(self) -> float:
        """Diameter of the threads [mm]."""
        return self._inside("thread_um")

    @property
    def thickness(self) -> float | None:
        """Thickness of the fabric [mm], when it is known."""
        return None if self.thickness_um is None else self._inside("thickness_um")

    @property
    def emulsion(self) -> float:
        """How far the emulsion stands below the fabric [mm]."""
        return self._inside("emulsion_um")

    @property
    def angle(self) -> float:
        """Angle of the threads to the grooves [rad]."""
        return self._inside("angle_deg")


#: Periods of the patterns [µm] when the job gives none: cells as long as a groove is wide for dots.
DEFAULT_PERIOD = {"staggered": 50.0, "angled": 50.0, "blue-noise": 50.0, "error-diffused": 50.0}


class MaskTable(Table):
    """`[mask]`: pattern and rules of the screen."""

    pattern: Literal["slot", "dot", "staggered", "angled", "blue-noise", "error-diffused"] = "slot"
    period_um: Annotated[float, Field(ge=1, le=10_000, allow_inf_nan=False)] = 400.0
    min_aperture_um: Positive = 15.0
    min_web_um: Positive = 15.0
    angle_deg: Annotated[float, Field(gt=0, lt=90, allow_inf_nan=False)] = 22.5
    dot_um: Annotated[Positive, Field(le=2000)] | None = None
    levelling_length_mm: Annotated[Positive, Field(le=100)] = 1.0
    pixel_um: Annotated[Positive, Field(le=10_000)] | None = None
    viewing_distance_mm: Annotated[Positive, Field(le=100_000)] = 500.0
    mesh: MeshTable | None = None
    registration_um: Annotated[float, Field(ge=0, le=10_000, allow_inf_nan=False)] = 200.0
    formats: list[MaskFormat] = Field(default_factory=lambda: list(DEFAULT_FORMATS), min_length=1)
    polarity: Literal["open", "closed"] = "open"
    mirror: bool = False
    emulsion_side: Literal["film", "squeegee"] = "film"
    furniture: list[FurnitureName] = Field(default_factory=lambda: list(DEFAULT_FURNITURE))
    revision: Annotated[str, Field(pattern=r"^[A-Za-z0-9._-]{1,16}$")] = "A"
    squeegee: Literal["along", "across"] = "along"
    frame_mm: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None
    tif_dpi: Annotated[float, Field(ge=2540, le=25_400, allow_inf_nan=False)] = 2540.0

    @model_validator(mode="before")
    @classmethod
    def _default_period(cls, table: Any) -> Any:
        if isinstance(table, dict) and isinstance(table.get("mesh"), str):
            table = {**table, "mesh": {"name": table["mesh"]}}
        if isinstance(table, dict) and "period_um" not in table:
            period = DEFAULT_PERIOD.get(str(table.get("pattern")))
            return table if period is None else {**table, "period_um": period}
        return table

    @field_validator("mesh", mode="before")
    @classmethod
    def _mesh(cls, mesh: Any) -> Any:
        if mesh is not None and not isinstance(mesh, dict | MeshTable):
            raise ValueError('expected a name such as "120-34", "auto", or a table')
        return mesh

    @field_validator("formats", "furniture")
    @classmethod
    def _once(cls, names: list[str]) -> list[str]:
        twice = next((name for i, name in enumerate(names) if name in names[:i]), None)
        if twice is not None:
            raise ValueError(f"expected {twice!r} once")
        return names

    @model_validator(mode="after")
    def _dots(self) -> "MaskTable":
        if self.dot_um is not None and self.pattern not in ("blue-noise", "error-diffused"):
            raise ValueError(
                f"dot_um = {self.dot_um:g}: expected with pattern 'blue-noise' or 'error-diffused'"
            )
        return self

    @model_validator(mode="after")
    def _room(self) -> "MaskTable":
        smallest = self.min_aperture_um + self.min_web_um
        if smallest > self.period_um:
            raise ValueError(
                f"min_aperture_um + min_web_um = {smallest:g}: expected at most "
                f"period_um = {self.period_um:g}"
            )
        return self

    @property
    def angle(self) -> float:
        """Angle of the rows of an angled lattice to the across direction [rad]."""
        return self._inside("angle_deg")

    @property
    def dot(self) -> float | None:
        """Side of the dots of a stochastic pattern [mm], when it is given."""
        return None if self.dot_um is None else self._inside("dot_um")

    @property
    def levelling_length(self) -> float:
        """Over which the resin levels along a groove, full width at half maximum [mm]."""
        return self._inside("levelling_length_mm")

    @property
    def pixel(self) -> float | None:
        """Pitch of the display's pixels [mm], when it is given."""
        return None if self.pixel_um is None else self._inside("pixel_um")

    @property
    def viewing_distance(self) -> float:
        """From where the film is looked at [mm]."""
        return self._inside("viewing_distance_mm")

    @property
    def period(self) -> float:
        """Period of the apertures along the grooves [mm]."""
        return self._inside("period_um")

    @property
    def min_aperture(self) -> float:
        """Smallest aperture the screen maker keeps [mm]."""
        return self._inside("min_aperture_um")

    @property
    def min_web(self) -> float:
        """Smallest web between apertures [mm]."""
        return self._inside("min_web_um")
