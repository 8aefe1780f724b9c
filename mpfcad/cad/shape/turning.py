"""The table from which a mould is turned: surface, slopes, and the path of the tool's centre."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import Section
from mpfcad.film.section import LINE
from mpfcad.units import deg, um

COLUMNS = ("x_um", "z_um", "slope_deg", "tool_x_um", "tool_z_um")


@dataclass(frozen=True, eq=False)
class TurningTable:
    """Points along a mould's surface from left to right, (p,) float64 each; mm and rad.

    Attributes
    ----------
    x, z
        on the surface
    slope
        angle of the surface; at a ridge's corner it turns while x and z stay
    tool_x, tool_z
        centre of the tool's nose that touches there
    """

    x: NDArray[np.float64]
    z: NDArray[np.float64]
    slope: NDArray[np.float64]
    tool_x: NDArray[np.float64]
    tool_z: NDArray[np.float64]


def build_turning_table(cut: Section, tool_radius: float, angle_step: float) -> TurningTable:
    """Return the points, at most `angle_step` [rad] of slope apart on curved pieces and corners.

    The centre is the surface moved by `tool_radius` [mm] along its normal: the offset curve.
    """
    piece = np.arange(cut.piece_count)
    ends = np.stack([np.arctan(cut.slope_on(piece, x)) for x in (cut.x[:-1], cut.x[1:])], axis=1)
    # Where a piece ends, the slope turns to that of the next: a piece without width at the corner.
    turns = np.stack([ends[:-1, 1], ends[1:, 0]], axis=1)
    spans = np.empty((2 * len(piece) - 1, 2))
    spans[::2], spans[1::2] = ends, turns
    at = np.repeat(piece, 2)[:-1]
    corner = np.arange(len(spans)) % 2 == 1
    count = np.maximum(np.ceil(np.abs(spans[:, 1] - spans[:, 0]) / angle_step - 1e-9), 1)
    straight = ~corner & (cut.kind[at] == LINE)
    still = corner & (np.abs(spans[:, 1] - spans[:, 0]) < 1e-9)
    count = np.where(straight, 1, np.where(still, 0, count)).astype(np.int64)
    start = np.concatenate(([0], np.cumsum(count)))
    span = np.repeat(np.arange(len(spans)), count)
    share = (np.arange(start[-1]) - start[span]) / count[span]
    slope = spans[span, 0] + share * (spans[span, 1] - spans[span, 0])
    owner = at[span]
    x = np.where(corner[span], cut.x[owner + 1], _place(cut, owner, slope, share))
    z = cut.height_on(owner, x)
    x, z = np.append(x, cut.width), np.append(z, cut.z[-1])
    slope = np.append(slope, ends[-1, 1])
    return TurningTable(
        x, z, slope, x - tool_radius * np.sin(slope), z + tool_radius * np.cos(slope)
    )


def _place(
    cut: Section, owner: NDArray[np.int64], slope: NDArray[np.float64], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return x [mm] on each piece where it has the slope [rad]; its left end for a line."""
    return np.where(share == 0, cut.x[owner], cut.position_of_slope(owner, slope))


def write_turning_table(table: TurningTable, path: Path) -> None:
    """Write the points as CSV in µm, 0.1 pm steps, and degrees."""
    path = Path(path)
    rows = np.stack(
        [table.x / um, table.z / um, table.slope / deg, table.tool_x / um, table.tool_z / um],
        axis=1,
    )
    part = path.with_name(f".{path.name}.part")
    with part.open("w", encoding="utf-8", newline="\n") as file:
        np.savetxt(file, rows + 0.0, "%.7f", ",", header=",".join(COLUMNS), comments="")
    part.replace(path)
