"""What a BSDF file does not hold, and what is taken in its place: only what the user states.

A side (light from below, light from above) or a way (transmission, reflection) that was not
measured is unknown. Transmission of the other side follows from reciprocity (H. von Helmholtz,
1867) once the user has said what the missing side reflects; reflection follows from nothing.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.table import (
    ABOVE,
    BELOW,
    REFLECT,
    SIDES,
    TRANSMIT,
    WAYS,
    BsdfTable,
)  # fmt: skip

#: Matrices (i, o) float64 [1/sr] by (way, side).
Matrices = dict[tuple[int, int], NDArray[np.float64]]
#: All that a layer in a stack needs, and what a reflector needs: it is lit from above only.
WHOLE = frozenset((way, side) for way in (TRANSMIT, REFLECT) for side in (BELOW, ABOVE))
REFLECTOR = frozenset({(REFLECT, ABOVE)})
NONE: frozenset[tuple[int, int]] = frozenset()
LOSSLESS = "lossless"


@dataclass(frozen=True)
class Taken:
    """What the user says of what a file does not hold.

    Attributes
    ----------
    symmetric
        the element is its own mirror image from below to above: a missing side is the other one
    reflection
        of a missing side: Lambertian reflectance 0 … 1, or `"lossless"`: all that is not
        transmitted, spread so that the table stays reciprocal; None where nothing is said
    transmission
        Lambertian transmittance 0 … 1 where the file holds none from either side
    reciprocal
        claimed: transmission of a missing side may be taken from the other one
    """

    symmetric: bool = False
    reflection: float | str | None = None
    transmission: float | None = None
    reciprocal: bool = False


NOTHING = Taken()


def fill_in(
    name: str,
    basis: AngleBasis,
    isotropic: bool,
    found: Matrices,
    taken: Taken = NOTHING,
    needed: frozenset[tuple[int, int]] = WHOLE,
) -> BsdfTable:
    """Return the table of what a file holds and what is taken for the rest, each with a note.

    Raises
    ------
    InputError
        when something of `needed` is neither in the file nor stated.
    """
    incidences = len(basis.azimuths) if isotropic else basis.count
    value = np.zeros((2, 2, incidences, basis.count))
    for key, matrix in found.items():
        value[key] = matrix
    table = BsdfTable(name, basis, isotropic, value)
    notes: list[str] = []
    unknown: set[tuple[int, int]] = set()
    # Transmission first: what a lossless side reflects is what it does not transmit.
    for way in (TRANSMIT, REFLECT):
        for side in (BELOW, ABOVE):
            if (way, side) in found:
                continue
            what = f"{WAYS[way]} from {SIDES[side]}"
            stated, how = _taken(table, found, way, side, taken)
            if stated is not None:
                value[way, side] = stated
            elif (way, side) in needed:
                raise InputError(f"{name}: {what}: not in the file: {_expected(way, side, found)}")
            else:
                how = "not in the file"
                unknown.add((way, side))
            notes.append(f"{what}: {how}")
    return BsdfTable(name, basis, isotropic, value, tuple(notes), frozenset(unknown))


def _taken(
    table: BsdfTable, found: Matrices, way: int, side: int, taken: Taken
) -> tuple[NDArray[np.float64] | None, str]:
    """Return the matrix of a missing side and where it comes from, or None."""
    other = 1 - side
    if taken.symmetric and (way, other) in found:
        return table.value[way, other], f"as from {SIDES[other]} (symmetric = true)"
    stated = taken.reflection if way == REFLECT else taken.transmission
    if way == TRANSMIT and (way, other) in found:
        if taken.reciprocal or taken.reflection is not None:
            back = table.reversed_value()[way, side]
            return back, f"by reciprocity from {SIDES[other]}"
        return None, ""
    if stated is None:
        return None, ""
    shape = table.value.shape[2:]
    if stated == LOSSLESS:
        return _lossless(table, side), "all that is not transmitted (reflection = lossless)"
    key = "reflection" if way == REFLECT else "transmission"
    return np.full(shape, float(stated) / np.pi), f"Lambertian ({key} = {stated:g})"


def _lossless(table: BsdfTable, side: int) -> NDArray[np.float64]:
    """Return the reciprocal reflection (i, o) of all light that is not transmitted.

    d_i d_o / Σd, d the light that is missing at an incidence.
    """
    missing = np.maximum(0.0, 1 - table.energy[TRANSMIT, side])
    total = (missing * table.incidence_projected).sum()
    leaving = missing[table.basis.ring if table.isotropic else table.basis.opposite]
    return missing[:, None] * leaving / max(total, 1e-300)


def _expected(way: int, side: int, found: Matrices) -> str:
    """Return what the user can say."""
    other = (way, 1 - side) in found
    same = "symmetric = true where both sides are the same" if other else ""
    if way == TRANSMIT and other:
        more = "reflection = 0 … 1 or lossless of the missing side, or reciprocal = true"
    elif way == TRANSMIT:
        more = "transmission = 0 … 1 (Lambertian)"
    else:
        more = "reflection = 0 … 1 (Lambertian) or lossless"
    return f"expected {', or '.join(filter(None, (more, same)))}"
