"""The stylus's tip: a ball on a cone, and what it does to a profile (grey-scale morphology)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.units import deg, um

#: Full angle [rad] of the cone where only a radius is stated.
USUAL_ANGLE = 60 * deg
#: Full angles [rad] of the cones that makers of stylus profilers sell.
USUAL_ANGLES = (60 * deg, 90 * deg)
#: Radii [mm] that makers of stylus profilers sell.
USUAL_RADII = (0.7 * um, 2.0 * um, 2.5 * um, 5.0 * um, 10.0 * um, 12.5 * um)


@dataclass(frozen=True)
class StylusTip:
    """A ball of `radius` [mm] that ends a cone of full `angle` [rad].

    radius_off: by how much [mm] the radius may be another, 95 %.
    """

    radius: float
    angle: float = USUAL_ANGLE
    radius_off: float = 0.0

    @property
    def flank_slope(self) -> float:
        """Slope of the cone's flank: cot(angle/2)."""
        return float(1 / np.tan(self.angle / 2))

    def told(self, steepest: float) -> "list[StylusTip]":
        """Return the tips that a stated one may be over walls of a slope up to `steepest`.

        A cone that is blunter than that draws its own flank; where the trace is steeper all the
        same, the heights' scale is off, or the angle, and the ball is on a usual cone.
        """
        if self.flank_slope > steepest or self.angle <= USUAL_ANGLE:
            return [self]
        return [self, StylusTip(self.radius)]

    def height(self, offset: ArrayLike) -> NDArray[np.float64]:
        """Return the tip's surface [mm] above its lowest point at an offset [mm] from its axis."""
        u = np.abs(np.asarray(offset, float))
        slope = self.flank_slope
        touch = self.radius * slope / np.hypot(1.0, slope)
        ball = self.radius - np.sqrt(np.maximum(self.radius**2 - np.minimum(u, touch) ** 2, 0.0))
        return ball + slope * np.maximum(u - touch, 0.0)


def parse_radius(text: str) -> tuple[float, float]:
    """Return the radius and how far off it may be [mm] that `2.5±0.5` or `2.5` states in µm.

    Raises
    ------
    InputError
        naming the option where it states neither.
    """
    parts = text.replace("+-", "±").split("±")
    try:
        radius, off = (float(part) for part in (*parts, "0")[: max(len(parts), 2)])
    except ValueError:
        radius = off = -1.0
    if not (0 <= radius <= 100 and 0 <= off <= radius):
        raise InputError(
            f"--tip-radius-um: {text!r}: expected 0 … 100, or such as 2.5±0.5, the second no larger"
        )
    return radius * um, off * um


def dilate(
    height: NDArray[np.float64], step: float, tip: StylusTip, *, periodic: bool
) -> NDArray[np.float64]:
    """Return what a tip traces: t(x) = max over u of h(x+u) - tip(u).

    height: (n,) float64 [mm] at steps of `step` [mm]; outside it repeats, or is not there.
    Villarrubia, J. Res. Natl. Inst. Stand. Technol. 102, 425 (1997), eq. 6.
    """
    return -_lowest(-height, step, tip, periodic)


def erode(
    trace: NDArray[np.float64], step: float, tip: StylusTip, *, periodic: bool
) -> NDArray[np.float64]:
    """Return the highest surface that gives a trace: h(x) = min over u of t(x-u) + tip(u).

    It is the surface itself wherever the tip touched it, and above it elsewhere (ibid., eq. 10).
    """
    return _lowest(trace, step, tip, periodic)


def _lowest(
    value: NDArray[np.float64], step: float, tip: StylusTip, periodic: bool
) -> NDArray[np.float64]:
    """Return min over u of value(x+u) + tip(u), (n,); the tip is symmetric."""
    span = float(np.ptp(value))
    # Beyond where the tip stands higher than the whole relief nothing can be lower.
    reach = int(np.ceil((tip.radius + span / tip.flank_slope) / step)) + 1
    reach = min(reach, len(value) // 2 if periodic else len(value) - 1)
    shape = tip.height(np.arange(-reach, reach + 1) * step)
    wide = np.pad(value, reach, mode="wrap") if periodic else np.pad(
        value, reach, constant_values=np.inf
    )  # fmt: skip
    lowest = np.full(len(value), np.inf)
    for k, above in enumerate(shape):
        np.minimum(lowest, wide[k : k + len(value)] + above, out=lowest)
    return lowest
