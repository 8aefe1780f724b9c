"""Over which width the films of a scene repeat: their grooves, and all of them with the lamps."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mpfcad.optics.element import Element
    from mpfcad.optics.solid.mesh import FilmMesh

#: Tips are what rises above this share of the relief; the spacing of equal ones scatters less.
_TIP, _EVEN = 0.5, 0.02
#: Grooves are alike within such a share of their depth.
_SAME = 1e-3
#: A pitch of whole grooves is off the lamps' by no more.
_SAME_PITCH = 0.002


def groove_pitch(mesh: "FilmMesh") -> float | None:
    """Return the spacing across [mm] of a film's tips; None where they are not evenly spaced."""
    vertex = mesh.vertex[np.unique(mesh.top)]
    x, at = np.unique(np.round(vertex[:, 0], 6), return_inverse=True)
    z = np.full(len(x), -np.inf)
    np.maximum.at(z, at, vertex[:, 2])
    if len(x) < 3 or np.ptp(z) == 0:
        return None
    # Both ends of the tile are one place.
    before, after = np.r_[z[-2], z[:-1]], np.r_[z[1:], z[1]]
    tip = x[(z > before) & (z >= after) & (z > z.min() + _TIP * np.ptp(z))]
    tip = tip[tip < mesh.size[0] - 1e-6]
    if not len(tip):
        return None
    pitch = mesh.size[0] / len(tip)
    gaps = np.diff(np.r_[tip, tip[0] + mesh.size[0]])
    return float(pitch) if np.abs(gaps - pitch).max() <= _EVEN * pitch else None


def has_equal_grooves(mesh: "FilmMesh") -> bool:
    """Return whether all grooves of a film are alike, and each is the same from end to end."""
    pitch, vertex = groove_pitch(mesh), mesh.vertex[np.unique(mesh.top)]
    if pitch is None or not _is_extruded(mesh):
        return False
    # The tile's right end is its left end again.
    x, z = np.unique(np.round(vertex[vertex[:, 0] < mesh.size[0] - 1e-6][:, [0, 2]], 6), axis=0).T
    grooves = round(mesh.size[0] / pitch)
    if len(x) % grooves:
        return False
    folded = np.stack([x, z]).reshape(2, grooves, -1)
    folded[0] -= pitch * np.arange(grooves)[:, None]
    return bool(np.ptp(folded, axis=1).max() <= _SAME * np.ptp(z))


def has_alike_films(elements: "Sequence[Element]") -> bool:
    """Return whether each film of a scene has equal grooves; so has one without a film."""
    from mpfcad.optics.element import Film, LibraryFilm

    films = [one for one in elements if isinstance(one, Film | LibraryFilm)]
    return all(isinstance(one, Film) and has_equal_grooves(one.mesh) for one in films)


def repeats_with(elements: "Sequence[Element]", pitch: float) -> bool:
    """Return whether all films repeat with a lamp pitch [mm], and are alike along the lamps."""
    from mpfcad.optics.element import Film, LibraryFilm

    for film in elements:
        if isinstance(film, LibraryFilm):
            return False
        if not isinstance(film, Film) or has_equal_grooves(film.mesh):
            continue
        times = round(pitch / film.mesh.size[0])
        is_whole = abs(times * film.mesh.size[0] / pitch - 1) <= _SAME_PITCH
        if film.rotation != 0 or not is_whole or not _is_extruded(film.mesh):
            return False
    return True


def _is_extruded(mesh: "FilmMesh") -> bool:
    """Return whether a film is the same from end to end."""
    return len(np.unique(np.round(mesh.vertex[np.unique(mesh.top), 1], 6))) <= 2
