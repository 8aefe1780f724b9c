"""Curvature that varies in both directions, C(x, y), and the film that has it.

Between its nodes a field is bilinear. The film is cut into cells, one groove wide and a given
length along; its curvatures are computed for some grooves at a time and never stand in memory
together: a 32-inch panel has over a hundred million cells.
"""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import PROFILES, Groove, Profile
from mpfcad.sound import refuse_unknown, refuse_unsound


class PanelField(Protocol):
    """A curvature over the panel, however it is held; lengths in mm from the lower left corner."""

    @property
    def across(self) -> NDArray[np.float64]:
        """Nodes across, (mx,) float64."""

    @property
    def along(self) -> NDArray[np.float64]:
        """Nodes along, (my,) float64."""

    @property
    def curvature(self) -> NDArray[np.float64]:
        """Every curvature that there is, along by across, float64 [1/mm]."""

    @property
    def content(self) -> tuple[NDArray[np.float64], ...]:
        """The arrays that define the curvature; that of the curvatures [1/mm] is the last."""

    @property
    def stored(self) -> tuple[NDArray[np.float64], ...]:
        """What its file holds: positions across and along, and curvatures along by across."""

    def on_grooves(self, position: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at the nodes along of grooves at `position`, (n, my)."""

    def extremes(self, position: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
        """Return the smallest and largest curvature [1/mm] of grooves at `position`, (n,)."""

    def at(self, across: ArrayLike, along: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at points."""


@dataclass(frozen=True, eq=False)
class CurvatureField:
    """Curvature over position across and along the panel, from its lower left corner.

    Attributes
    ----------
    across
        (mx,) float64 [mm], increasing
    along
        (my,) float64 [mm], increasing
    curvature
        (my, mx) float64 [1/mm], C through the tips
    """

    across: NDArray[np.float64]
    along: NDArray[np.float64]
    curvature: NDArray[np.float64]

    def __post_init__(self) -> None:
        for name in ("across", "along", "curvature"):
            values = np.array(getattr(self, name), dtype=np.float64)
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        refuse_unsound("field.curvature", self.curvature, 0.0)
        if self.curvature.shape != (len(self.along), len(self.across)):
            raise InputError(
                f"field.curvature: shape {self.curvature.shape}: expected "
                f"({len(self.along)}, {len(self.across)}), along by across"
            )
        refuse_unsound("field.across: step", np.diff(self.across), 0.0, above=True)
        refuse_unsound("field.along: step", np.diff(self.along), 0.0, above=True)

    def on_grooves(self, position: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at the nodes along of grooves at `position` mm, (n, my)."""
        index, weight = bracket(self.across, position)
        left, right = self.curvature[:, index], self.curvature[:, index + 1]
        return np.ascontiguousarray((left + weight * (right - left)).T)

    @property
    def content(self) -> tuple[NDArray[np.float64], ...]:
        """The nodes across and along [mm], and the curvatures, (my, mx) [1/mm]."""
        return self.across, self.along, self.curvature

    @property
    def stored(self) -> tuple[NDArray[np.float64], ...]:
        """What its file holds: all of it."""
        return self.content

    def at(self, across: ArrayLike, along: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at points [mm]."""
        i, u = bracket(self.across, across)
        j, v = bracket(self.along, along)
        c = self.curvature
        low = c[j, i] + u * (c[j, i + 1] - c[j, i])
        high = c[j + 1, i] + u * (c[j + 1, i + 1] - c[j + 1, i])
        return low + v * (high - low)

    def extremes(self, position: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
        """Return the smallest and largest curvature [1/mm] of grooves at `position` mm, (n,)."""
        low, high = np.empty(len(position)), np.empty(len(position))
        for first in range(0, len(position), 64):
            part = slice(first, first + 64)
            node = self.on_grooves(position[part])
            low[part], high[part] = node.min(axis=1), node.max(axis=1)
        return low, high


def bracket(node: NDArray[np.float64], position: ArrayLike) -> tuple[NDArray, NDArray]:
    """Return the node before each position, and the way to the next, 0…1; held beyond the ends."""
    position = np.asarray(position, float)
    index = np.clip(np.searchsorted(node, position, side="right") - 1, 0, len(node) - 2)
    weight = (position - node[index]) / (node[index + 1] - node[index])
    return index, np.clip(weight, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class FieldFilm:
    """A filled film on a panel whose curvature is a field; lengths in mm.

    Attributes
    ----------
    groove
        the bare V groove
    length
        extent along the grooves
    groove_count
        number of grooves
    field
        the curvature over the panel
    """

    groove: Groove
    length: float
    groove_count: int
    field: PanelField
    profile: Profile = "filled"
    varies_along: ClassVar[bool] = True

    def __post_init__(self) -> None:
        refuse_unknown("film.profile", self.profile, PROFILES)
        refuse_unsound("film.length", self.length, 0.0, above=True)
        refuse_unsound("film.groove_count", self.groove_count, 1)

    @property
    def width(self) -> float:
        """Extent across the grooves [mm]."""
        return self.groove_count * self.groove.pitch

    @property
    def tip_position(self) -> NDArray[np.float64]:
        """Tip positions x, (n+1,) float64 [mm]."""
        return np.arange(self.groove_count + 1.0) * self.groove.pitch

    @property
    def groove_position(self) -> NDArray[np.float64]:
        """Groove centres x, (n,) float64 [mm]."""
        return np.arange(0.5, self.groove_count) * self.groove.pitch

    @property
    def content(self) -> tuple[NDArray[np.float64], ...]:
        """The field's nodes across and along [mm], and its curvatures, (my, mx) [1/mm]."""
        return self.field.content

    def extremes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return smallest and largest curvature of each groove, (n,) float64 [1/mm]."""
        return self.field.extremes(self.groove_position)

    def as_field(self) -> "FieldFilm":
        """Return the film itself."""
        return self

    def curvature_at(self, across: ArrayLike, along: ArrayLike) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at points [mm]."""
        return self.field.at(across, along)
