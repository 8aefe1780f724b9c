"""The cross-section of an extruded body as exact pieces: lines, parabolas and circular arcs.

A `Section` is what films with rounded tips, measured profiles and moulds have in common with a
plain film: an upper outline z(x) over a flat underside. Everything is in closed form.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError

LINE, PARABOLA, ARC = 0, 1, 2
#: Pieces narrower than this [mm] are what floating point leaves of none.
ROUNDING = 1e-10


@dataclass(frozen=True, eq=False)
class Section:
    """The outline over 0 ≤ x ≤ width, from left to right, and the body's length along y; mm.

    Attributes
    ----------
    length
        extent along y
    x, z
        (m+1,) float64, the corners between pieces, x increasing
    kind
        (m,) int64: LINE, PARABOLA or ARC
    centre_x, centre_z
        (m,) float64, vertex of a parabola, centre of an arc; 0 for a line
    bend
        (m,) float64: curvature of a parabola [1/mm], radius of an arc [mm], both positive where the
        outline is concave (a valley) and negative where it is convex (a tip); 0 for a line
    underside
        z [mm] of the flat underside
    """

    length: float
    x: NDArray[np.float64]
    z: NDArray[np.float64]
    kind: NDArray[np.int64]
    centre_x: NDArray[np.float64]
    centre_z: NDArray[np.float64]
    bend: NDArray[np.float64]
    underside: float = 0.0

    @property
    def piece_count(self) -> int:
        """Number of pieces m."""
        return len(self.kind)

    @property
    def width(self) -> float:
        """Extent across [mm]."""
        return float(self.x[-1])

    @property
    def thickness(self) -> float:
        """Greatest height [mm] over the underside, at a corner or between two."""
        top = self.x[:-1].copy()
        convex = self.bend < 0
        inside = np.clip(self.centre_x, self.x[:-1], self.x[1:])
        top[convex] = inside[convex]
        highest = max(self.z.max(), self.height_on(np.arange(self.piece_count), top).max())
        return float(highest) - self.underside

    @property
    def area(self) -> float:
        """Area [mm²] between outline and underside, in closed form."""
        return float(self.area_to(np.array([self.width]))[0])

    @property
    def volume(self) -> float:
        """Volume of the body [mm³]."""
        return self.area * self.length

    def piece_of(self, x: ArrayLike) -> NDArray[np.int64]:
        """Return the piece at each x [mm]; a corner belongs to the piece on its right."""
        found = np.searchsorted(self.x, np.asarray(x, float), side="right") - 1
        return np.clip(found, 0, self.piece_count - 1)

    def height(self, x: ArrayLike) -> NDArray[np.float64]:
        """Return z [mm] at x [mm]."""
        x = np.asarray(x, float)
        return self.height_on(self.piece_of(x), x)

    def height_on(self, piece: NDArray[np.int64], x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return z [mm] at x [mm] on the given pieces, also just beyond their ends."""
        kind, bend = self.kind[piece], self.bend[piece]
        local = x - self.centre_x[piece]
        share = (x - self.x[piece]) / (self.x[piece + 1] - self.x[piece])
        line = self.z[piece] + share * (self.z[piece + 1] - self.z[piece])
        parabola = self.centre_z[piece] + bend / 2 * local**2
        arc = self.centre_z[piece] - np.sign(bend) * np.sqrt(np.maximum(bend**2 - local**2, 0.0))
        return np.select([kind == LINE, kind == PARABOLA], [line, parabola], arc)

    def area_to(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the area [mm²] between outline and underside from the left end to each x [mm]."""
        piece = np.arange(self.piece_count)
        whole = np.concatenate(([0.0], np.cumsum(self._area_on(piece, self.x[1:]))))
        piece = self.piece_of(x)
        return whole[piece] + self._area_on(piece, x)

    def _area_on(self, piece: NDArray[np.int64], x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the area [mm²] below each piece from its left end to x [mm]."""
        start, kind, bend = self.x[piece], self.kind[piece], self.bend[piece]
        across = x - start
        ends = (self.z[piece] + self.height_on(piece, x)) / 2 - self.underside
        # A parabola's chord lies C Δx³/12 above it; an arc's by its circular segment.
        parabola = bend * across**3 / 12
        radius = np.where(kind == ARC, bend, np.inf)
        rise = np.where(kind == ARC, self.height_on(piece, x) - self.z[piece], 0.0)
        angle = 2 * np.arcsin(np.clip(np.hypot(across, rise) / np.abs(2 * radius), 0.0, 1.0))
        curved = np.where(kind == ARC, bend, 0.0)
        arc = np.sign(curved) * curved**2 / 2 * (angle - np.sin(angle))
        return across * ends - np.select([kind == LINE, kind == PARABOLA], [0.0, parabola], arc)

    def slope_on(self, piece: NDArray[np.int64], x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return dz/dx at x [mm] on the given pieces."""
        kind, bend = self.kind[piece], self.bend[piece]
        local = x - self.centre_x[piece]
        rise = (self.z[piece + 1] - self.z[piece]) / (self.x[piece + 1] - self.x[piece])
        height = np.sqrt(np.maximum(bend**2 - local**2, 1e-6 * bend**2 + (kind != ARC)))
        arc = np.sign(bend) * local / height
        return np.select([kind == LINE, kind == PARABOLA], [rise, bend * local], arc)

    def position_of_slope(
        self, piece: NDArray[np.int64], angle: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return x [mm] where curved pieces have the slope `angle` [rad]; no meaning for lines."""
        bend = np.where(self.kind[piece] == LINE, 1.0, self.bend[piece])
        local = np.where(self.kind[piece] == ARC, np.sin(angle) * bend, np.tan(angle) / bend)
        return self.centre_x[piece] + local

    def turned_over(self, level: float, backing: float) -> "Section":
        """Return what lies over the outline, turned over about the y axis: left becomes right.

        The plane at z = `level` [mm] becomes z = 0, with `backing` [mm] of material below it.
        """
        curved = self.kind != LINE
        return replace(
            self,
            x=self.width - self.x[::-1],
            z=level - self.z[::-1],
            kind=self.kind[::-1],
            centre_x=np.where(curved, self.width - self.centre_x, 0.0)[::-1],
            centre_z=np.where(curved, level - self.centre_z, 0.0)[::-1],
            bend=-self.bend[::-1],
            underside=-backing,
        )

    def scaled(self, factor: float) -> "Section":
        """Return the section with every length multiplied by `factor`."""
        bend = np.where(self.kind == PARABOLA, self.bend / factor, self.bend * factor)
        return replace(
            self,
            length=self.length * factor,
            x=self.x * factor,
            z=self.z * factor,
            centre_x=self.centre_x * factor,
            centre_z=self.centre_z * factor,
            bend=bend,
            underside=self.underside * factor,
        )


def join_pieces(
    length: float,
    x: NDArray[np.float64],
    kind: NDArray[np.int64],
    centre: NDArray[np.float64],
    bend: NDArray[np.float64],
    end_height: NDArray[np.float64],
) -> Section:
    """Return the section of pieces side by side; those without width are left out.

    Parameters
    ----------
    length
        extent along y [mm]
    x
        (m, 2) float64 [mm], left and right end of each piece
    kind
        (m,) int64
    centre
        (m, 2) float64 [mm], vertex or centre (x, z) of each piece
    bend
        (m,) float64, as in `Section`
    end_height
        (m, 2) float64 [mm], z at the two ends

    Raises
    ------
    InputError
        when the outline cuts through the underside.
    """
    kept = x[:, 1] - x[:, 0] > ROUNDING
    x, kind, centre = x[kept], kind[kept], centre[kept]
    bend, end_height = bend[kept], end_height[kept]
    section = Section(
        length,
        np.append(x[:, 0], x[-1, 1]),
        np.append(end_height[:, 0], end_height[-1, 1]),
        kind,
        np.where(kind == LINE, 0.0, centre[:, 0]),
        np.where(kind == LINE, 0.0, centre[:, 1]),
        np.where(kind == LINE, 0.0, bend),
    )
    lowest = np.where(
        section.bend > 0, np.clip(section.centre_x, section.x[:-1], section.x[1:]), section.x[:-1]
    )
    height = section.height_on(np.arange(section.piece_count), lowest)
    if not height.min() > 0:
        at = float(lowest[int(np.argmin(height))])
        raise InputError(
            f"film: surface at x = {at:.6g} mm: {height.min() * 1000:.4g} µm above the underside: "
            "expected above 0"
        )
    return section
