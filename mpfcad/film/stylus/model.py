"""A stylus trace as a function of its grooves.

The trace is base + t(x - centre), t what the tip traces of grooves (`DilatedGroove`) in a row. The
base is offset, tilt and, over four prism widths or more, cosines of half-waves down to about a
prism width: waviness. It is linear and projected out, so that what is sought is: centre, pitch,
slope of the walls, rounding of the prism tips, the shape of the menisci, and of each groove, over
four prism widths or more, its own fill. A fill's name is u = C·w/slope, C the curvature of the
parabola through the tips that has it. All but the place and the fills have priors, for a covered
groove shows no wall, few points no rounding, and a blunt tip no shape.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.dilated import DilatedGroove
from mpfcad.film.stylus.meniscus import Meniscus
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.units import nm, um

CENTRE, PITCH, SLOPE, ROUNDING, WETTING, ROUNDNESS, FLATNESS, FILL = range(8)
#: Prior standard deviations: of pitch and of slope, as shares; of the rounding [mm].
PITCH_OFF, SLOPE_OFF, ROUND = 0.02, 0.03, 1.0 * um
#: Of the wetting about that of parabolas through the tips; mean and deviation of the roundness,
#: which is 0 of parabolas and 1 of circles.
WETTING_OFF, LIKELY_ROUND, ROUNDNESS_OFF = 0.4, 0.5, 0.5
#: Of the flatness, 0 of resin at rest: scale of a Student t with one degree of freedom, whose long
#: tails let resin that dried be as flat as a trace shows it; least and largest.
FLATNESS_OFF, LEAST_FLAT, MOST_FLAT = 0.15, -0.5, 1.2
#: How many priors there are.
PRIORS = 6
#: Prism widths from which each groove has its own fill.
OWN_FILL = 4
#: Largest departures of pitch and slope, as shares, and largest rounding [mm].
MOST_OFF, MOST_ROUND = 0.12, 6.0 * um
#: The largest u of a profile that may dip below the walls.
_STEEPEST = 4.0

#: By how much the values are changed for differences. Less wetting changes every meniscus, and
#: walls that are less steep every trace.
_DIFFERENCES = (
    (slice(CENTRE, PITCH), 2 * nm), (slice(PITCH, SLOPE), 0.01 * nm),
    (slice(SLOPE, ROUNDING), -1e-6), (slice(ROUNDING, WETTING), 1 * nm),
    (slice(WETTING, ROUNDNESS), -1e-4), (slice(ROUNDNESS, FLATNESS), 1e-3),
    (slice(FLATNESS, FILL), 1e-4), (slice(FILL, None), 1e-5),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class TraceModel:
    """A trace and the groove that it should show.

    Attributes
    ----------
    x, z
        (n,) float64 [mm], positions from the middle, heights
    base
        (n, k) float64, orthonormal columns of offset, tilt and waviness
    grooves
        how many have a u of their own
    held_slope
        the walls' slope, where it is not sought
    wettings
        the least and the largest above that of parabolas through the tips; from 0 where resin is
        taken to reach them
    least_fill
        the least u of each groove
    parabolic
        whether the menisci are parabolas through the tips
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    groove: Groove
    profile: Profile
    tip: StylusTip | None
    base: NDArray[np.float64]
    grooves: int
    held_slope: float | None = None
    wettings: tuple[float, float] = (-1.0, 1.0)
    least_fill: float = 0.0
    parabolic: bool = False

    @classmethod
    def of(
        cls,
        x: NDArray[np.float64],
        z: NDArray[np.float64],
        groove: Groove,
        profile: Profile,
        tip: StylusTip | None,
        widths: int,
    ) -> "TraceModel":
        """Return the model of heights at positions from the middle."""
        span = np.ptp(x)
        columns = [np.ones_like(x), x / span]
        columns += [np.cos(np.pi * j * (x / span + 0.5)) for j in range(2, max(widths - 1, 2))]
        base = np.linalg.qr(np.column_stack(columns))[0]
        return cls(x, z, groove, profile, tip, base, widths + 1 if widths >= OWN_FILL else 1)

    def at(self, kept: NDArray[np.bool_]) -> "TraceModel":
        """Return the model of some of the heights."""
        base = np.linalg.qr(self.base[kept])[0]
        return replace(self, x=self.x[kept], z=self.z[kept], base=base)

    @property
    def top(self) -> float:
        """The largest u: an empty groove, or as steep as is tried."""
        return 2.0 if self.profile == "filled" else _STEEPEST

    def place(self, value: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return x from the nearest groove's centre [mm], and which groove that is, (n,) each."""
        from mpfcad.film.stylus.kernel import place

        local, number = np.empty(len(self.x)), np.empty(len(self.x), np.int64)
        place(self.x, float(value[CENTRE]), float(value[PITCH]), local, number)
        return local, np.clip(number - number.min(), 0, self.grooves - 1)

    def local(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return x from the nearest groove's centre, (n,) [mm]."""
        return self.place(value)[0]

    def number(self, value: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the groove of each height, (n,), from 0."""
        return self.place(value)[1]

    def groove_of(self, value: NDArray[np.float64]) -> Groove:
        """Return the groove of fitted pitch and slope."""
        return Groove(float(value[PITCH]), float(value[SLOPE] * value[PITCH] / 2))

    def surface(
        self,
        value: NDArray[np.float64],
        *,
        traced: bool = True,
        touch: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return the height above the bare groove's valley, (n,): traced, or of the film itself.

        touch: where the tip touches the resin, if known.
        """
        made = self._dilated(value, self.tip if traced else None)
        local, number = self.place(value)
        return made.over(local, self.menisci(value), number, touch)

    def traced_at(
        self, value: NDArray[np.float64], local: NDArray[np.float64], number: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return the traced height at x (m,) [mm] from the centres of grooves `number`, (m,)."""
        return self._dilated(value, self.tip).over(local, self.menisci(value), number)

    def _dilated(self, value: NDArray[np.float64], tip: StylusTip | None) -> DilatedGroove:
        return DilatedGroove(self.groove_of(value), self.profile, tip, float(value[ROUNDING]))

    def menisci(self, value: NDArray[np.float64]) -> Meniscus:
        """Return the grooves' menisci, (grooves,)."""
        groove = self.groove_of(value)
        if self.profile == "ideal":
            return Meniscus.through_tips(groove, value[FILL:] * groove.curvature_covered, "ideal")
        return Meniscus.holding(
            groove,
            value[FILL:],
            float(value[WETTING]),
            float(value[ROUNDNESS]),
            float(value[FLATNESS]),
        )

    def residual(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what base and groove leave of the heights, (n,) [mm]."""
        left = self.z - self.surface(value)
        return left - self.base @ (self.base.T @ left)

    def levelled(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the heights without the base, (n,) [mm]."""
        left = self.z - self.surface(value)
        return self.z - self.base @ (self.base.T @ left)

    def jacobian(self, value: NDArray[np.float64], *, central: bool = True) -> NDArray[np.float64]:
        """Return d(surface)/d(value), (n, FILL + grooves), by differences inside the bounds.

        central: to both sides, where that is possible; else to one, in half of the time.
        """
        touch = None
        if self.tip is not None and self.tip.radius > 0:
            # The tip rests where it lies highest: what moves that point does not move the tip.
            local, number = self.place(value)
            touch = self._dilated(value, self.tip).touch(local, self.menisci(value), number)
        there = None if central else self.surface(value, touch=touch)
        low, high = self.bounds()
        columns = []
        for part, step in _DIFFERENCES:
            ahead, back = value.copy(), value.copy()
            ahead[part] = np.clip(value[part] + step, low[part], high[part])
            inside = ahead[part] != value[part]
            if central or not np.all(inside):
                aside = np.clip(value[part] - step, low[part], high[part])
                back[part] = np.where(inside & (not central), value[part], aside)
            gap = ahead[part] - back[part]
            from_ = self.surface(back, touch=touch) if there is None or np.any(~inside) else there
            change = self.surface(ahead, touch=touch) - from_
            gap = np.where(gap == 0, np.inf, gap)  # a value that is held does not change
            columns.append(change / (gap[0] if self.grooves == 1 or part.start < FILL
                                     else gap[self.number(value)]))  # fmt: skip
        if self.grooves == 1:
            return np.column_stack(columns)
        own = np.zeros((len(self.x), self.grooves))
        own[np.arange(len(self.x)), self.number(value)] = columns.pop()
        return np.column_stack([*columns, own])

    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the least and the largest value of each."""
        pitch, slope = self.groove.pitch, self.groove.wall_slope
        low = [-np.inf, pitch * (1 - MOST_OFF), slope * (1 - MOST_OFF), 0.0]
        high = [np.inf, pitch * (1 + MOST_OFF), slope * (1 + MOST_OFF), MOST_ROUND]
        low += [self.wettings[0], LIKELY_ROUND - 2 * ROUNDNESS_OFF]
        high += [self.wettings[1], LIKELY_ROUND + 2 * ROUNDNESS_OFF]
        low, high = [*low, LEAST_FLAT], [*high, MOST_FLAT]
        if self.profile == "ideal" or self.parabolic:
            low[WETTING:] = high[WETTING:] = [0.0, 0.0, 0.0]
        if self.held_slope is not None:
            low[SLOPE] = high[SLOPE] = self.held_slope
        fills = [self.least_fill] * self.grooves, [self.top] * self.grooves
        return np.array(low + fills[0]), np.array(high + fills[1])

    def prior(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how many prior standard deviations all that have priors are off, (PRIORS,)."""
        flat = value[FLATNESS] / FLATNESS_OFF
        return np.array([
            (value[PITCH] / self.groove.pitch - 1) / PITCH_OFF,
            (value[SLOPE] / self.groove.wall_slope - 1) / SLOPE_OFF,
            value[ROUNDING] / ROUND,
            value[WETTING] / WETTING_OFF,
            (value[ROUNDNESS] - LIKELY_ROUND) / ROUNDNESS_OFF,
            np.sign(flat) * np.sqrt(2 * np.log1p(flat**2)),
        ])  # fmt: skip

    def prior_jacobian(self, value: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return d(prior)/d(value), (PRIORS, FILL + grooves)."""
        rows = np.zeros((PRIORS, FILL + self.grooves))
        rows[0, PITCH] = 1 / (PITCH_OFF * self.groove.pitch)
        rows[1, SLOPE] = 1 / (SLOPE_OFF * self.groove.wall_slope)
        rows[2, ROUNDING] = 1 / ROUND
        rows[3, WETTING] = 1 / WETTING_OFF
        rows[4, ROUNDNESS] = 1 / ROUNDNESS_OFF
        flat = abs(value[FLATNESS]) / FLATNESS_OFF
        # d√(2 ln(1 + t²))/dt, √2 at 0.
        steep = 2 * flat / (1 + flat**2) / np.sqrt(2 * np.log1p(flat**2)) if flat > 1e-4 else 2**0.5
        rows[5, FLATNESS] = steep / FLATNESS_OFF
        return rows
