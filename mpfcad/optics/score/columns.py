"""Which values of a scene have scores: columns of `Scene.parameter`, by the kind of the element."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics import sheet, slab
from mpfcad.optics.cavity import endless
from mpfcad.optics.element import CAVITY, FILM, SHEET, SLAB, Element
from mpfcad.optics.film import passage as film
from mpfcad.optics.lowering import Shared, lower_element
from mpfcad.optics.scene import Scene

#: The columns of each kind, in the order of its scores (`score.state`).
SCORED: dict[int, tuple[int, ...]] = {
    CAVITY: (endless.LAMP_REFLECTANCE, endless.REFLECTANCE, endless.SPECULAR_FRACTION),
    SLAB: (slab.SCATTERING, slab.ABSORPTION, slab.ASYMMETRY),
    SHEET: (
        sheet.SIGMA, sheet.ACROSS, sheet.WIDE, sheet.SHARE, sheet.TRANSMISSION, sheet.INDEX,
    ),
    FILM: (film.ABSORPTION,),
}  # fmt: skip


class Columns(NamedTuple):
    """The scores of a scene, k of them.

    Attributes
    ----------
    first
        (e+1,) int64, the number of each element's first score
    place
        (k, 2) int64, element and column of each score's value
    known
        (k,) bool, whether the trace tells its derivative: not where what is drawn has no density at
        that value, as the moves of a sheet of width 0
    """

    first: NDArray[np.int64]
    place: NDArray[np.int64]
    known: NDArray[np.bool_]

    @classmethod
    def of(cls, scene: Scene) -> "Columns":
        """Return the scores of a scene."""
        place, known, first = [], [], [0]
        for e, kind in enumerate(scene.kind.tolist()):
            columns = SCORED.get(kind, ())
            place += [(e, column) for column in columns]
            known += _KNOWN[kind](scene.parameter[e]) if columns else []
            first.append(len(place))
        if len(scene.led):
            known[: first[1]] = [False] * first[1]
        if scene.polarised:
            known = [False] * len(known)
        return cls(np.array(first), np.array(place).reshape(-1, 2), np.array(known, bool))


def _cavity(row: NDArray[np.float64]) -> list[bool]:
    reflects = row[endless.REFLECTANCE] > 0 and row[endless.BRDF] < 0
    share = row[endless.SPECULAR_FRACTION]
    return [row[endless.LAMP_REFLECTANCE] > 0, reflects, reflects and 0 < share < 1]


def _slab(row: NDArray[np.float64]) -> list[bool]:
    scatters = row[slab.SCATTERING] > 0
    return [scatters, True, scatters and row[slab.PHASE] < 0 and abs(row[slab.ASYMMETRY]) < 1]


def _sheet(row: NDArray[np.float64]) -> list[bool]:
    share = row[sheet.SHARE]
    along, across = row[sheet.SIGMA] > 0, row[sheet.ACROSS] > 0
    two = along and across and row[sheet.WIDE] > 0 and 0 < share < 1
    one = share == 0
    passes = row[sheet.TRANSMISSION] > 0
    return [along and (one or two), across and (one or two), two, two, passes, True]


def _film(row: NDArray[np.float64]) -> list[bool]:
    # A resin of its own takes light, too: what is left does not tell which took it.
    return [row[film.ABSORPTION] > 0 and row[film.RESIN_INDEX] == 0]


_KNOWN = {CAVITY: _cavity, SLAB: _slab, SHEET: _sheet, FILM: _film}


def direction(
    columns: Columns, low: list[Element], high: list[Element], step: float
) -> NDArray[np.float64] | None:
    """Return the derivative of a scene's scored columns by a value, (k,) float64.

    `low` and `high` are its elements with the value less and more by half a `step`. None where
    anything else changes with the value, or a column whose derivative no trace tells.
    """
    found = np.zeros(len(columns.known))
    for e, (one, other) in enumerate(zip(low, high, strict=True)):
        if any(
            _differs(a, b) for a, b in zip(vars(one).values(), vars(other).values(), strict=True)
        ):
            return None
        change = lower_element(other, Shared())[1] - lower_element(one, Shared())[1]
        for column in np.flatnonzero(change):
            number = np.flatnonzero((columns.place == (e, column)).all(axis=1))
            if len(number) == 0 or not columns.known[number[0]]:
                return None
            found[number[0]] = change[column] / step
    return found


def _differs(one: object, other: object) -> bool:
    """Return whether two values that are no numbers differ, or anything within them."""
    if one is other:
        return False
    if isinstance(one, float | int) and isinstance(other, float | int):
        return False
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.tobytes() != other.tobytes()
    if hasattr(one, "__dict__") and type(one) is type(other):
        pairs = zip(vars(one).values(), vars(other).values(), strict=True)
        return any(_differs(a, b) or _is_other(a, b) for a, b in pairs)
    return one != other


def _is_other(one: object, other: object) -> bool:
    """Return whether two numbers within a value differ."""
    return isinstance(one, float | int) and one != other
