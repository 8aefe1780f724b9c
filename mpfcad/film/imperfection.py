"""Films as they are really made: rounded tips and valleys, or a measured surface.

`build_section` turns a film and its imperfection into exact pieces. A tip is rounded by the circle
inside the material that touches both neighbouring surfaces; a valley of the bare prisms by the
circle above it that touches both walls, before the resin is filled in. Where a tip's circle would
reach past a short bare wall, the parabola is taken up to the tip in that wall's place.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.groove_tip import Flank, round_tips
from mpfcad.film.measured_section import measured_section
from mpfcad.film.meniscus import meniscus, meniscus_section
from mpfcad.film.section import ARC, LINE, PARABOLA, Section, join_pieces
from mpfcad.units import nm, um

#: Parts narrower than this are merged into their neighbours unless asked otherwise.
SLIVER = 10 * nm
#: The smallest radius drawn: below it a tip is sharp to every tool and every reader.
SMALLEST_RADIUS = 0.2 * um


@dataclass(frozen=True, eq=False)
class Imperfection:
    """How a film departs from sharp prisms and a parabola; lengths in mm.

    Attributes
    ----------
    tip_radius, valley_radius
        0 is sharp
    measured
        (k, 3) float64 or None: a surface as `average_groove` gives it, which every groove gets in
        the parabola's place; in a `filled` film with as much of its resin as the groove holds with
        its C
    contact_angle
        of resin and wall [rad]: its surface is then the arc that meets the walls so, with as much
        resin as the groove holds with its C; None: the parabola through the tips
    """

    tip_radius: float = 0.0
    valley_radius: float = 0.0
    measured: NDArray[np.float64] | None = None
    contact_angle: float | None = None


def build_section(
    film: PrismFilm, imperfection: Imperfection | None = None, sliver: float = SLIVER
) -> Section:
    """Return the film's cross-section; without imperfection it is the plain film's.

    Parts narrower than `sliver` [mm] are merged into their neighbours.

    Raises
    ------
    InputError
        when a radius is larger than the grooves allow, or the surface reaches the underside.
    """
    made = imperfection or Imperfection()
    if made.measured is not None:
        if made.tip_radius or made.valley_radius:
            raise InputError(
                "film: profile measured: has its own tips and valleys: expected radii of 0"
            )
        return measured_section(film, made.measured)
    if made.contact_angle is not None:
        return meniscus_section(film, made.contact_angle, sliver)
    for name in ("tip_radius", "valley_radius"):
        radius = getattr(made, name)
        if radius and not SMALLEST_RADIUS <= radius < np.inf:
            raise InputError(
                f"film: {name}: {radius / um:g} µm: expected 0 or at least "
                f"{SMALLEST_RADIUS / um:g} µm"
            )
    return _Drawing(film, made, sliver).section()


def resin_reach(film: PrismFilm, made: Imperfection, sliver: float) -> NDArray[np.float64]:
    """Return how far [mm] from each groove's centre resin is drawn, (n,) float64; 0: none.

    The film is `filled`, and not of a measured surface; `sliver` [mm] as `build_section` has it.
    """
    if made.contact_angle is None:
        reach = _Drawing(film, made, sliver).contact
    else:
        reach = meniscus(film, made.contact_angle)[0]
        reach = np.where(reach < sliver, 0.0, reach)
    return np.where(film.groove.takes_resin(film.curvature), reach, 0.0)


class _Drawing:
    """The pieces of every groove, seven columns: wall, arc, parabola, arc, wall, and the tip."""

    def __init__(self, film: PrismFilm, made: Imperfection, sliver: float) -> None:
        self.film = film
        self.sliver = sliver
        self.made = made
        groove, count = film.groove, film.groove_count
        self.half_width, self.wall = groove.half_width, groove.wall_slope
        self.contact = np.full(count, self.half_width)
        self.arc_end = np.zeros(count)
        self.arc_centre = 0.0
        if film.profile == "filled":
            contact = groove.contact_position(film.curvature)
            contact = np.where(contact < sliver, 0.0, contact)
            self.contact = np.where(self.half_width - contact < sliver, self.half_width, contact)
        self._round_valleys()
        self._round_tips()

    def _round_valleys(self) -> None:
        """Set where the valley's arc ends, and how far resin reaches over it."""
        radius, limit = self.made.valley_radius, self._sharpest()
        if not radius:
            return
        reach = radius * self.wall / np.hypot(1.0, self.wall)
        if radius > limit or reach > self.half_width / 2:
            most = min(limit, self.half_width / 2 * np.hypot(1.0, self.wall) / self.wall)
            raise InputError(
                f"film: valley_radius: {radius / um:g} µm: larger than the groove allows: expected "
                f"at most {most / um:.4g} µm"
            )
        if self.film.profile == "ideal":
            return
        self.arc_centre = radius * np.hypot(1.0, self.wall)
        vertex = self.film.groove.vertex_height(self.film.curvature)
        # Where z0 + C/2 q = zc - sqrt(r² - q), q = x²: a quadratic in q.
        c, gap = self.film.curvature, self.arc_centre - vertex
        b = c * gap - 1
        root = np.maximum(b**2 - c**2 * (gap**2 - radius**2), 0.0)
        square = 2 * (gap**2 - radius**2) / (-b + np.sqrt(root)) * -1
        filled = (gap < radius) & (c > 0)
        meet = np.where(filled, np.sqrt(np.maximum(square, 0.0)), 0.0)
        meet = np.where(meet < self.sliver, 0.0, meet)
        # What the resin covers, or all but a sliver, is not drawn.
        over = (self.contact >= reach) | (meet > reach - self.sliver)
        self.arc_end = np.where(over, 0.0, reach)
        self.contact = np.where(over, self.contact, meet)

    def _sharpest(self) -> float:
        """Return the largest valley radius [mm] that no resin surface is sharper than."""
        curvature = self.film.groove.curvature_empty
        if self.film.profile == "ideal":
            curvature = float(max(self.film.curvature.max(), 1e-9))
        return 1 / curvature

    def _round_tips(self) -> None:
        """Set the two ends of each tip's arc, from the tip, and its centre from the tip."""
        count, radius = self.film.groove_count, self.made.tip_radius
        self.tip_reach = np.zeros((count + 1, 2))
        self.tip_centre = np.zeros((count + 1, 2))
        # A flank that the circle leaves behind makes room for the parabola: at most twice.
        while radius:
            flank = self._flanks()
            # Tip i stands between groove i-1 and groove i; the film repeats at its ends.
            right = np.arange(count + 1) % count
            left = (right - 1) % count
            reach, centre = round_tips(flank.take(left), flank.take(right), radius)
            walls = (self.contact < self.half_width) & (flank.slope == self.wall)
            room = self.half_width - np.maximum(self.contact, self.arc_end)
            past = walls & (np.maximum(reach[:-1, 1], reach[1:, 0]) > room - self.sliver)
            past &= self.contact > 0
            # Between flat surfaces there is nothing to round.
            self.tip_reach = np.where(reach.max(axis=1, keepdims=True) < self.sliver, 0.0, reach)
            self.tip_centre = centre
            if not past.any():
                break
            self.contact = np.where(past, self.half_width, self.contact)
        inner = np.maximum(self.contact * (self.contact < self.half_width), self.arc_end)
        free = self.half_width - inner - np.maximum(self.tip_reach[:-1, 1], self.tip_reach[1:, 0])
        if radius and not free.min() > 0:
            raise InputError(
                f"film: tip_radius: {radius / um:g} µm: larger than groove "
                f"{int(np.argmin(free))} allows: expected a surface between tip and valley"
            )

    def _flanks(self) -> Flank:
        """Return each groove's surface beside its tips: a wall, or its parabola."""
        bare = self.contact < self.half_width
        curvature = self.film.curvature
        slope = np.where(bare, self.wall, curvature * self.half_width)
        return Flank(slope, np.where(bare, 0.0, curvature))

    def section(self) -> Section:
        """Return the pieces, left to right."""
        film, w = self.film, self.half_width
        left, right = -w + self.tip_reach[:-1, 1], w - self.tip_reach[1:, 0]
        outer = np.maximum(self.contact, self.arc_end)
        bounds = [left]
        for inner in (-outer, -self.contact, self.contact, outer):
            bounds.append(np.clip(inner, left, right))
        bounds.append(right)
        # A bare V without arc or resin keeps its corner at 0.
        local = np.stack(bounds, axis=1)
        x = film.groove_position[:, None] + local
        x[:, 0] = film.tip_position[:-1] + self.tip_reach[:-1, 1]
        x[:, -1] = film.tip_position[1:] - self.tip_reach[1:, 0]
        kind = np.array([LINE, ARC, PARABOLA, ARC, LINE])
        centre_z = np.zeros((film.groove_count, 5))
        centre_z[:, [1, 3]] = film.base + self.arc_centre
        drop = film.curvature / 2 * w**2
        centre_z[:, 2] = film.thickness - drop
        bend = np.zeros((film.groove_count, 5))
        bend[:, [1, 3]] = self.made.valley_radius
        bend[:, 2] = film.curvature
        flat = drop < 1e-3 * nm
        kinds = np.tile(kind, (film.groove_count, 1))
        kinds[flat, 2] = LINE
        height = self._heights(local)
        centre_x = np.repeat(film.groove_position[:, None], 5, axis=1)
        return self._with_tips(x, kinds, np.stack([centre_x, centre_z], 2), bend, height)

    def _heights(self, local: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return z [mm] of the corners, (n, 6), at x from each groove's centre."""
        film, w = self.film, self.half_width
        wall = film.base + self.wall * np.abs(local)
        parabola = film.thickness - film.curvature[:, None] / 2 * (w - local) * (w + local)
        radius = self.made.valley_radius
        arc = film.base + self.arc_centre - np.sqrt(np.maximum(radius**2 - local**2, 0.0))
        resin = (np.abs(local) <= self.contact[:, None]) & (self.contact[:, None] > 0)
        rounded = np.abs(local) < self.arc_end[:, None]
        return np.where(resin, parabola, np.where(rounded, arc, wall))

    def _with_tips(
        self,
        x: NDArray[np.float64],
        kind: NDArray[np.int64],
        centre: NDArray[np.float64],
        bend: NDArray[np.float64],
        height: NDArray[np.float64],
    ) -> Section:
        """Return the section with an arc after each groove, and half an arc at both ends."""
        film, count, radius = self.film, self.film.groove_count, self.made.tip_radius
        tips, reach = film.tip_position, self.tip_reach
        start, end = tips - reach[:, 0], tips + reach[:, 1]
        start[0], end[-1] = 0.0, film.width
        centre_x, centre_z = tips + self.tip_centre[:, 0], film.thickness + self.tip_centre[:, 1]
        top = [
            centre_z + np.sqrt(np.maximum(radius**2 - (at - centre_x) ** 2, 0.0))
            for at in (start, end)
        ]
        # The arc's ends inside the film are the grooves' corners, to the last bit.
        start[1:], end[:-1] = x[:, -1], x[:, 0]
        top[0][1:], top[1][:-1] = height[:, -1], height[:, 0]
        top[1][-1] = top[0][0]  # the film repeats
        whole = np.full(count + 1, ARC)
        tip = (
            np.stack([start, end], 1),
            whole,
            np.stack([centre_x, centre_z], 1),
            np.full(count + 1, -radius),
            np.stack(top, 1),
        )
        groove = (
            np.stack([x[:, :-1], x[:, 1:]], 2),
            kind,
            centre,
            bend,
            np.stack([height[:, :-1], height[:, 1:]], 2),
        )
        rows = [
            np.concatenate([t[:1], *_weave(g, t[1:])]) for t, g in zip(tip, groove, strict=True)
        ]
        return join_pieces(film.length, *rows)


def _weave(groove: NDArray, tip: NDArray) -> list[NDArray]:
    """Return the pieces of each groove with the tip on its right after them."""
    joined = np.concatenate([groove, tip[:, None]], axis=1)
    return [joined.reshape(-1, *joined.shape[2:])]
