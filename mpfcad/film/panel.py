"""A film over the whole panel, as a mask prints it: whichever way its curvature varies."""

from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile

if TYPE_CHECKING:
    from mpfcad.film.field.field import FieldFilm


class PanelFilm(Protocol):
    """What the mask and the plan ask of a film; lengths in mm."""

    @property
    def groove(self) -> Groove:
        """The bare V groove."""

    @property
    def length(self) -> float:
        """Extent along the grooves."""

    @property
    def profile(self) -> Profile:
        """`filled` or `ideal`."""

    @property
    def varies_along(self) -> bool:
        """Whether the curvature varies along a groove too."""

    @property
    def groove_count(self) -> int:
        """Number of grooves n."""

    @property
    def width(self) -> float:
        """Extent across the grooves."""

    @property
    def tip_position(self) -> NDArray[np.float64]:
        """Tip positions x, (n+1,) float64 [mm]."""

    @property
    def groove_position(self) -> NDArray[np.float64]:
        """Groove centres x, (n,) float64 [mm]."""

    @property
    def content(self) -> tuple[NDArray[np.float64], ...]:
        """The arrays that define the curvature; that of the curvatures [1/mm] is the last."""

    def extremes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return smallest and largest curvature of each groove, (n,) float64 [1/mm]."""

    def as_field(self) -> "FieldFilm":
        """Return the film as one whose curvature is a field."""
