"""One groove of the film in closed form: walls, resin, surface.

The bare groove is a V of width `pitch` and depth `depth`, walls z = s|x| with s = depth/half width.
The surface of curvature C goes through both tips (Hsieh, MPF thesis, eq. 14):

    p(x) = z0 + C/2 x²,   z0 = depth - C/2 w²,   w = pitch/2.

`ideal` is p itself, which only a mould can make below the walls. `filled` is max(s|x|, p): resin
can only be added. Above C = s/w (40 /mm for the BEF) p dives below the walls beyond the contact
point x_c = 2 s/C - w; at C = 2 s/w (80 /mm) a filled groove is empty.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.sound import refuse_unsound

Profile = Literal["filled", "ideal"]
PROFILES: tuple[Profile, ...] = ("filled", "ideal")
#: A curvature is that of an empty groove within this share of it: curvature.csv has nine digits.
BARE = 1e-9


@dataclass(frozen=True)
class Groove:
    """The bare V groove of a prism film; lengths in mm, curvatures in 1/mm.

    The BEF of the thesis is `Groove(0.050, 0.025)`: 90° prisms.
    """

    pitch: float
    depth: float

    def __post_init__(self) -> None:
        refuse_unsound("groove.pitch", self.pitch, 0.0, above=True)
        refuse_unsound("groove.depth", self.depth, 0.0, above=True)

    @classmethod
    def of_angle(cls, pitch: float, prism_angle: float) -> "Groove":
        """Return the groove of `pitch` [mm] between prisms of `prism_angle` [rad].

        depth = pitch / (2 tan(angle/2)): 25 µm for 50 µm and 90°.
        """
        return cls(pitch, pitch / 2 / math.tan(prism_angle / 2))

    @property
    def prism_angle(self) -> float:
        """Angle between the two walls of a prism, 2 atan(w / depth) [rad] (90° for the BEF)."""
        return 2 * math.atan2(self.half_width, self.depth)

    @property
    def half_width(self) -> float:
        """Half the pitch, w [mm]."""
        return self.pitch / 2

    @property
    def wall_slope(self) -> float:
        """Slope of the walls s = depth / w (1 for 90° prisms)."""
        return self.depth / self.half_width

    @property
    def area(self) -> float:
        """Cross-section of the empty groove, w·depth [mm²] (625 µm² for the BEF)."""
        return self.half_width * self.depth

    @property
    def room(self) -> float:
        """Resin that fills the groove, over the film's area [mm]: half of the depth."""
        return self.depth / 2

    @property
    def curvature_covered(self) -> float:
        """Largest C at which resin still covers the walls up to the tips, s/w [1/mm]."""
        return self.wall_slope / self.half_width

    @property
    def curvature_empty(self) -> float:
        """The C at which a filled groove holds no resin, 2 s/w [1/mm]: the printable limit."""
        return 2 * self.wall_slope / self.half_width

    def takes_resin(self, curvature: ArrayLike) -> NDArray[np.bool_]:
        """Return whether a filled groove of a curvature [1/mm] holds any resin."""
        return np.asarray(curvature, float) < self.curvature_empty * (1 - BARE)

    def curvature_most(self, profile: Profile) -> float:
        """Return the largest C [1/mm] of a profile: that of the empty groove, or none."""
        return self.curvature_empty * (1 + 1e-12) if profile == "filled" else math.inf

    def vertex_height(self, curvature: ArrayLike) -> NDArray[np.float64]:
        """Return z0 = depth - C w²/2 [mm], the height of the parabola's vertex above the valley."""
        return self.depth - np.asarray(curvature, float) / 2 * self.half_width**2

    def contact_position(self, curvature: ArrayLike) -> NDArray[np.float64]:
        """Return |x| [mm] where the parabola meets the wall: clip(2 s/C - w, 0, w)."""
        # Far below s/w the quotient is clipped anyway; the floor keeps it from overflowing.
        value = np.maximum(np.asarray(curvature, float), self.curvature_covered / 2)
        w = self.half_width
        return np.clip(2 * self.wall_slope / value - w, 0.0, w)

    def height(
        self, x: ArrayLike, curvature: ArrayLike, profile: Profile = "filled"
    ) -> NDArray[np.float64]:
        """Return the surface height z [mm] above the valley at x [mm] from the groove's centre."""
        x = np.asarray(x, float)
        # Written as depth - C/2 (w-x)(w+x) so that the tips are met exactly.
        drop = (self.half_width - x) * (self.half_width + x)
        parabola = self.depth - np.asarray(curvature, float) / 2 * drop
        if profile == "ideal":
            return parabola
        return np.maximum(self.wall_slope * np.abs(x), parabola)

    def slope(
        self, x: ArrayLike, curvature: ArrayLike, profile: Profile = "filled"
    ) -> NDArray[np.float64]:
        """Return dz/dx of the surface at x [mm]; at the contact point, that of the parabola."""
        x = np.asarray(x, float)
        curvature = np.asarray(curvature, float)
        parabola = curvature * x
        if profile == "ideal":
            return parabola
        bare = np.abs(x) > self.contact_position(curvature)
        return np.where(bare, self.wall_slope * np.sign(x), parabola)

    def fill_fraction(self, curvature: ArrayLike) -> NDArray[np.float64]:
        """Return the resin's share of the groove's area, 0…1, of the profile max(s|x|, p).

        With u = C w/s: 1 - 2u/3 for u ≤ 1; else ξ²(3-ξ)/(3(1+ξ)), ξ = x_c/w = 2/u - 1.
        """
        u = np.asarray(curvature, float) * self.half_width / self.wall_slope
        xi = self.contact_position(curvature) / self.half_width
        return np.where(u <= 1, 1 - 2 * u / 3, xi**2 * (3 - xi) / (3 * (1 + xi)))

    def curvature_of_fill(self, fill_fraction: ArrayLike) -> NDArray[np.float64]:
        """Return the C [1/mm] whose fill fraction is the given one: the inverse of `fill_fraction`.

        Above a third, C = 3/2 (1-f) s/w. Below, ξ is the root in [0, 1] of
        ξ³ - 3ξ² + 3fξ + 3f = 0 (trigonometric solution), and C = 2 s/(w(1+ξ)).
        """
        fill = np.asarray(fill_fraction, float)
        low = np.minimum(fill, 1 / 3)
        radius = np.sqrt(1 - low)
        angle = np.arccos(np.clip((1 - 3 * low) / radius**3, -1.0, 1.0))
        xi = 1 + 2 * radius * np.cos((angle - 2 * np.pi) / 3)
        # One Newton step: arccos loses half the digits as the fill vanishes.
        slope = 3 * xi**2 - 6 * xi + 3 * low
        cubic = ((xi - 3) * xi + 3 * low) * xi + 3 * low
        step = np.divide(cubic, slope, out=np.zeros_like(xi), where=np.abs(slope) > 1e-12)
        xi = np.clip(xi - step, 0.0, 1.0)
        covered = 1.5 * (1 - fill) * self.curvature_covered
        return np.where(fill >= 1 / 3, covered, self.curvature_empty / (1 + xi))

    def mean_height(self, curvature: ArrayLike, profile: Profile = "filled") -> NDArray[np.float64]:
        """Return the surface's mean height [mm] above the valley over the groove."""
        curvature = np.asarray(curvature, float)
        if profile == "ideal":
            return self.depth - curvature * self.half_width**2 / 3
        return self.depth / 2 * (1 + self.fill_fraction(curvature))

    def prism_mean_height(
        self, curvature: ArrayLike, profile: Profile = "filled"
    ) -> NDArray[np.float64]:
        """Return the mean height [mm] of the prism body alone, min(s|x|, surface)."""
        return self.mean_height(curvature, profile) - self.depth / 2 * self.fill_fraction(curvature)

    def fitted_curvature(
        self, curvature: ArrayLike, profile: Profile = "filled"
    ) -> NDArray[np.float64]:
        """Return the curvature [1/mm] of the least-squares parabola through the whole groove.

        A stylus profiler reports this one. With δ(x) the surface above the parabola of curvature C,
        C_fit = C + 2 ∫(x² - w²/3) δ dx / ∫(x² - w²/3)² dx over 0…w; the divisor is 4 w⁵/45.
        """
        curvature = np.asarray(curvature, float)
        if profile == "ideal":
            return curvature + 0.0
        w, s = self.half_width, self.wall_slope
        contact = self.contact_position(curvature)

        def antiderivative(x: NDArray[np.float64]) -> NDArray[np.float64]:
            # δ = s x - d + C/2 (w² - x²) on the bare wall, times (x² - w²/3).
            a0, a2 = -self.depth + curvature / 2 * w**2, -curvature / 2
            third = w**2 / 3
            return (
                a2 * x**5 / 5
                + s * x**4 / 4
                + (a0 - third * a2) * x**3 / 3
                - third * s * x**2 / 2
                - third * a0 * x
            )

        moment = antiderivative(np.asarray(w)) - antiderivative(contact)
        return curvature + 2 * moment / (4 * w**5 / 45)

    def curvature_of_fitted(self, fitted_curvature: float) -> float:
        """Return the C through the tips [1/mm] of a filled groove with the given fitted curvature.

        Raises
        ------
        ValueError
            when no filled groove has it (outside 0 … 75 /mm for the BEF).
        """
        from scipy.optimize import brentq

        top = float(self.fitted_curvature(self.curvature_empty))
        if not 0 <= fitted_curvature <= top * (1 + 1e-12):
            raise ValueError(f"fitted curvature {fitted_curvature:g} /mm is outside 0 … {top:g}")
        fitted_curvature = min(fitted_curvature, top)
        return float(
            brentq(
                lambda c: float(self.fitted_curvature(c)) - fitted_curvature,
                0.0,
                self.curvature_empty,
                xtol=1e-13,
            )
        )
