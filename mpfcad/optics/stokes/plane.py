"""A plane layer that acts on polarisation: polariser, reflective polariser, retarder."""

import math
from dataclasses import dataclass

from mpfcad.errors import InputError
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import uniform
from mpfcad.optics.stokes.state import change, mirror_light, refer_to
from mpfcad.sound import refuse_unsound

#: The columns of such a layer in `Scene.parameter`.
COSINE, SINE, PASS_ALONG, PASS_ACROSS, BACK_ALONG, BACK_ACROSS, RETARDATION = range(7)


@dataclass(frozen=True)
class PlaneLayer:
    """A thin layer with an axis in its plane, alike from both sides and at all angles.

    Attributes
    ----------
    axis
        angle [rad] from y, anticlockwise seen from above: the transmission axis, or the slow one
    transmittance, reflectance
        of light along the axis and of light across it, 0…1; what is left is absorbed
    retardation
        phase [rad] by which light along the axis comes later than light across it
    """

    axis: float
    transmittance: tuple[float, float] = (1.0, 1.0)
    reflectance: tuple[float, float] = (0.0, 0.0)
    retardation: float = 0.0
    name: str = "polariser"

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.axis", self.axis)
        refuse_unsound(f"{self.name}.retardation", self.retardation)
        for way, passed, back in zip(
            ("along", "across"), self.transmittance, self.reflectance, strict=True
        ):
            refuse_unsound(f"{self.name}.transmittance {way}", passed, 0.0, 1.0)
            refuse_unsound(f"{self.name}.reflectance {way}", back, 0.0, 1.0)
            if passed + back > 1.0 + 1e-12:
                raise InputError(
                    f"{self.name}: {passed:g} transmitted and {back:g} reflected {way} the axis: "
                    "expected at most 1 together, as a passive layer has"
                )

    def is_mirrored(self, period: float) -> bool:
        """Tell whether its axis runs along y or across."""
        return abs(math.sin(2.0 * self.axis)) < 1e-12


@kernel
def refer_to_axis(light, cx, cy, dx, dy, dz):
    """Refer the state to the axis of a plane layer, across which lies c = (cx, cy, 0).

    Light is split into two states: one across both the ray and c, the other across that: the
    ordinary and the extraordinary wave of a sheet whose molecules lie along c (Chipman, Lam and
    Young, "Polarized light and optical systems", 2018).
    """
    tx, ty, tz = -dz * cy, dz * cx, dx * cy - dy * cx
    square = tx * tx + ty * ty + tz * tz
    if square > 0.0:
        scale = 1.0 / math.sqrt(square)
        refer_to(light, scale * tx, scale * ty, scale * tz, dx, dy, dz)


@kernel
def plane_passage(parameter, dx, dy, dz, light, rng):
    """Pass or mirror a ray at such a layer: (passed, dz, share of its weight that is left)."""
    refer_to_axis(light, parameter[COSINE], parameter[SINE], dx, dy, dz)
    along, across = parameter[PASS_ALONG], parameter[PASS_ACROSS]
    back_along, back_across = parameter[BACK_ALONG], parameter[BACK_ACROSS]
    a, b = 0.5 * (along + across), 0.5 * (along - across)
    back_a, back_b = 0.5 * (back_along + back_across), 0.5 * (back_along - back_across)
    passing = a + b * light[0, 1]
    left = passing + back_a + back_b * light[0, 1]
    if uniform(rng) * left < passing:
        both, phase = math.sqrt(along * across), parameter[RETARDATION]
        change(light, a, b, both * math.cos(phase), -both * math.sin(phase))
        return True, dz, left
    change(light, back_a, back_b, math.sqrt(back_along * back_across), 0.0)
    mirror_light(light, 0.0, 0.0, 1.0)
    return False, -dz, left
