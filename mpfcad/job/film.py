"""`[film]` of a job: the designed groove, and how the film as made departs from it."""

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from mpfcad.film import Groove, PyramidGroove
from mpfcad.job.table import Positive, Table
from mpfcad.units import deg, um

#: A prism angle printed to a hundredth of a degree agrees with pitch and depth up to this [rad].
ANGLE_ROOM = 0.01 * deg
#: Prism angles [rad] that a tool can cut.
ANGLE_MIN, ANGLE_MAX = 20 * deg, 160 * deg


class FilmTable(Table):
    """`[film]`: profile, dimensions, refractive index (none: the stack's); how it is really made.

    Of pitch, depth and prism angle two give the third; with fewer, pitch is 50 µm and depth 25 µm.
    The fields of `UNUSUAL` are how the film as made departs from that groove or, with `cell`, is no
    row of grooves.
    """

    profile: Literal["filled", "ideal"] = "filled"
    pitch_um: Annotated[float, Field(ge=1, le=2000)] = 50.0
    depth_um: Annotated[float, Field(ge=0.1, le=2000)] = 25.0
    prism_angle_deg: Annotated[Positive, Field(ge=20, le=160)] = 90.0
    base_um: Annotated[Positive, Field(le=5000)] = 200.0
    refractive_index: Annotated[Positive, Field(gt=1, le=3)] | None = None
    tip_radius_um: Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)] = 0.0
    valley_radius_um: Annotated[float, Field(ge=0, le=1000, allow_inf_nan=False)] = 0.0
    prism_angle_error_deg: Annotated[float, Field(ge=-90, le=90, allow_inf_nan=False)] = 0.0
    pitch_error_um: Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)] = 0.0
    measured_file: str | None = None
    surface: Literal["parabola", "arc", "level"] = "parabola"
    resin_spread_percent: Annotated[float, Field(ge=0, le=50, allow_inf_nan=False)] = 0.0
    cell: Literal["groove", "pyramid", "paraboloid"] = "groove"

    #: The fields that make a film something else than grooves as designed.
    UNUSUAL: ClassVar[tuple[str, ...]] = (
        "tip_radius_um",
        "valley_radius_um",
        "prism_angle_error_deg",
        "pitch_error_um",
        "measured_file",
        "surface",
        "resin_spread_percent",
        "cell",
    )
    #: The three that state the groove.
    GROOVE: ClassVar[tuple[str, ...]] = ("pitch_um", "depth_um", "prism_angle_deg")

    @property
    def derived_field(self) -> str | None:
        """The one of `GROOVE` that follows from the other two; None where the job states all."""
        missing = [name for name in reversed(self.GROOVE) if name not in self.model_fields_set]
        return missing[0] if missing else None

    @model_validator(mode="after")
    def _one_groove(self) -> "FilmTable":
        name, groove = self.derived_field, self._groove_as_stated()
        found = (groove.pitch / um, groove.depth / um, groove.prism_angle / deg)
        if name is not None:
            value = found[self.GROOVE.index(name)]
            if name != "prism_angle_deg" and not value <= 2000:
                raise ValueError(
                    f"{name} = {value:.6g} follows from the other two: expected at most 2000"
                )
            # Not as an assignment: the field stays one that the job does not state.
            self.__dict__[name] = float(f"{value:.12g}")
        return self

    def _groove_as_stated(self) -> Groove:
        angle, name = self._inside("prism_angle_deg"), self.derived_field
        groove = Groove(self._inside("pitch_um"), self._inside("depth_um"))
        if name == "prism_angle_deg":
            return groove
        if name == "depth_um":
            return Groove.of_angle(groove.pitch, angle)
        if name == "pitch_um":
            return Groove(2 * groove.depth * math.tan(angle / 2), groove.depth)
        if abs(groove.prism_angle - angle) > ANGLE_ROOM:
            raise ValueError(
                f"pitch_um = {self.pitch_um:g} and depth_um = {self.depth_um:g} give "
                f"prism_angle_deg = {groove.prism_angle / deg:.6g}, found "
                f"{self.prism_angle_deg:g}: expected two of the three, or three that agree"
            )
        return groove

    @property
    def groove(self) -> Groove:
        """The designed groove: the one that mask, CAD files and trace are made of."""
        return self._kind(self._inside("pitch_um"), self._inside("depth_um"))

    @property
    def _kind(self) -> type[Groove]:
        """What is filled: a groove, or the valleys between pyramids."""
        between = self.cell == "pyramid" and self.profile == "filled"
        return PyramidGroove if between else Groove

    @property
    def groove_as_made(self) -> Groove:
        """The groove with pitch_error_um and prism_angle_error_deg.

        A wrong pitch alone keeps the prism angle, the tool's, and so changes the depth.

        Raises
        ------
        ValueError
            when the errors leave no groove.
        """
        groove = self.groove
        pitch = groove.pitch + self._inside("pitch_error_um")
        if not abs(self.pitch_error_um) <= self.pitch_um / 2:
            raise ValueError(
                f"pitch_error_um: {self.pitch_error_um:g}: expected within half the pitch, "
                f"{-self.pitch_um / 2:g} … {self.pitch_um / 2:g}"
            )
        angle = groove.prism_angle + self._inside("prism_angle_error_deg")
        if not ANGLE_MIN <= angle <= ANGLE_MAX:
            raise ValueError(
                f"prism_angle_error_deg: {self.prism_angle_error_deg:g}: expected a prism angle of "
                f"20 to 160 as made, found {angle / deg:.6g}"
            )
        if self.pitch_error_um == 0 and self.prism_angle_error_deg == 0:
            return groove
        return Groove.of_angle(pitch, angle)

    @property
    def is_plain(self) -> bool:
        """Whether the film is a row of grooves, made as designed."""
        fields = type(self).model_fields
        return all(getattr(self, name) == fields[name].default for name in self.UNUSUAL)

    @property
    def tip_radius(self) -> float:
        """Radius of the tips [mm]."""
        return self._inside("tip_radius_um")

    @property
    def valley_radius(self) -> float:
        """Radius of the bare prisms' valleys [mm]."""
        return self._inside("valley_radius_um")

    @property
    def pitch(self) -> float:
        """Groove pitch [mm]."""
        return self._inside("pitch_um")

    @property
    def depth(self) -> float:
        """Groove depth [mm]."""
        return self._inside("depth_um")

    @property
    def base(self) -> float:
        """Thickness below the valleys [mm]."""
        return self._inside("base_um")
