"""What the user wants: curvature over position, laid onto the grooves; and what is refused.

A map of extent `pitch` has position 0 above a lamp and covers one lamp pitch (`repeat`), or half of
one (`mirror`), which then serves every lamp. A map of extent `panel` runs from the panel's left
edge. Between its rows a map is linear.
"""

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove, Profile
from mpfcad.sound import refuse_unknown, refuse_unsound

Extent = Literal["pitch", "panel"]
Repeat = Literal["repeat", "mirror"]

#: Decimals of a distance in mm kept in a lookup: float noise must not tell two mirror images apart.
LOOKUP_DECIMALS = 9


@dataclass(frozen=True, eq=False)
class CurvatureMap:
    """Curvature over position across the grooves.

    Attributes
    ----------
    position
        (m,) float64 [mm], increasing; from a lamp's axis (`pitch`) or the panel's edge (`panel`)
    curvature
        (m,) float64 [1/mm], C through the tips
    extent
        `pitch` or `panel`
    repeat
        `repeat` (the map is one lamp pitch) or `mirror` (it is half of one); no meaning for `panel`
    """

    position: NDArray[np.float64]
    curvature: NDArray[np.float64]
    extent: Extent
    repeat: Repeat

    def __post_init__(self) -> None:
        for name in ("position", "curvature"):
            values = np.array(getattr(self, name), dtype=np.float64)
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        refuse_unknown("map.extent", self.extent, get_args(Extent))
        refuse_unknown("map.repeat", self.repeat, get_args(Repeat))
        refuse_unsound("map.position", self.position)
        refuse_unsound("map.curvature", self.curvature, 0.0)
        if self.position.shape != self.curvature.shape or self.position.ndim != 1:
            raise InputError(
                f"map: {self.position.shape} positions and {self.curvature.shape} curvatures: "
                "expected as many, in one row"
            )
        refuse_unsound("map.position: step", np.diff(self.position), 0.0, above=True)

    @classmethod
    def uniform(cls, curvature: float) -> "CurvatureMap":
        """Return the map that gives every groove the same curvature [1/mm]."""
        return cls(np.zeros(1), np.array([curvature]), "panel", "repeat")

    def on_grooves(
        self, position: ArrayLike, lamp_pitch: float, lamp_position: float
    ) -> NDArray[np.float64]:
        """Return the curvature [1/mm] at groove centres.

        Parameters
        ----------
        position
            (n,) float64 [mm], groove centres on the panel
        lamp_pitch
            distance between lamps [mm]
        lamp_position
            position [mm] on the panel of any one lamp's axis
        """
        x = np.asarray(position, float)
        if self.extent == "pitch":
            offset = x - lamp_position
            if self.repeat == "mirror":
                x = np.abs(offset - lamp_pitch * np.rint(offset / lamp_pitch))
            else:
                x = offset - lamp_pitch * np.floor(np.round(offset / lamp_pitch, LOOKUP_DECIMALS))
            x = np.round(x, LOOKUP_DECIMALS)
        return np.interp(x, self.position, self.curvature)


#: How far, as a share of it, a limit may be passed by rounding alone.
ROUNDING = 1e-12
#: Curvatures of which the largest is this share of the bare groove's or less were given in 1/µm;
#: a mould may be curved more than a print.
MICROMETRE_SHARE = {"filled": 1e-3, "ideal": 5e-3}


def curvature_range(groove: Groove, profile: Profile) -> str:
    """Return the expected curvatures of a profile as text for a message."""
    if profile == "ideal":
        return "0 or more"
    return f"0 … {groove.curvature_empty:.12g}"


def digits_apart(value: float, limit: float) -> str:
    """Return a value with digits enough to tell it from a limit that is shown with twelve."""
    text = f"{value:.12g}"
    return repr(float(value)) if text == f"{limit:.12g}" else text


def find_bad_curvature(
    curvature: NDArray[np.float64], groove: Groove, profile: Profile
) -> tuple[int, str] | None:
    """Return the index of a curvature [1/mm] that is refused and why, or None."""
    expected = f"expected {curvature_range(groove, profile)}"
    bad = np.flatnonzero(~np.isfinite(curvature))
    if bad.size:
        return int(bad[0]), f"{curvature[bad[0]]:g}: expected a finite number, {expected[9:]}"
    bad = np.flatnonzero(curvature < 0)
    if bad.size:
        return int(bad[0]), f"{curvature[bad[0]]:.12g}: negative: {expected}"
    top = int(np.argmax(curvature))
    limit = groove.curvature_empty * MICROMETRE_SHARE[profile]
    if 0 < curvature[top] <= limit:
        return top, (
            f"{curvature[top]:g}: the largest value looks like 1/µm; multiply by 1000: "
            f"{expected} /mm, not all of {limit:g} or less"
        )
    bad = np.flatnonzero(curvature > groove.curvature_empty * (1 + ROUNDING))
    if profile == "filled" and bad.size:
        shown = digits_apart(float(curvature[bad[0]]), groove.curvature_empty)
        return int(bad[0]), (
            f"{shown}: not printable: {expected} for a filled film (at "
            f"{groove.curvature_empty:.12g} /mm the groove is empty and resin can only be added; "
            f"profile 'ideal' is for moulds)"
        )
    return None


def check_curvature(curvature: float, groove: Groove, profile: Profile, where: str) -> None:
    """Refuse a uniform curvature [1/mm] that a map would be refused for.

    Raises
    ------
    InputError
        that begins with `where` (file and field).
    """
    trouble = find_bad_curvature(np.array([curvature], dtype=float), groove, profile)
    if trouble:
        raise InputError(f"{where}: {trouble[1]}")
