"""A cross-section of exact pieces as a closed triangle mesh, for any outline. Plain numpy.

Corners are rounded to float32 in x first and z is taken on the piece at the rounded x, so that the
facets of parabolas and arcs keep their slope.
"""

import math

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.shape.mesh import VOLUME_SHARE, Mesh
from mpfcad.errors import InputError
from mpfcad.film import Section
from mpfcad.film.section import ARC, LINE
from mpfcad.units import deg

#: Corners of the outline over one piece of the underside.
BLOCK = 8
#: Share of the angle tolerance that the chords may use; the rest is for rounding in z.
SHARE = 0.85
#: Width of the narrowest chords of an arc, in steps of float32.
ARC_STEPS = 4


def build_outline(
    section: Section, angle_tolerance: float
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.int64]]:
    """Return the polyline (x, z) [mm] with normals within `angle_tolerance` [rad], and its pieces.

    The third array, one shorter, is the piece of the section that each chord stands for.

    Raises
    ------
    InputError
        when float32 cannot hold so fine a polyline.
    """
    piece = np.arange(section.piece_count)
    steep = [np.arctan(section.slope_on(piece, x)) for x in (section.x[:-1], section.x[1:])]
    turn = np.abs(steep[1] - steep[0])
    # Of chords between equal turns each is off by half its turn; rounding widens a chord by a step.
    tolerance = piece_tolerance(section, angle_tolerance)
    rounding = 0.75 * _step(section) * _sharpest(section)
    room = np.maximum(SHARE * tolerance - rounding, tolerance / 8)
    needed = np.maximum(turn / (2 * room), _chords_for_volume(section))
    count = np.where(section.kind == LINE, 1, np.maximum(np.ceil(needed), 1))
    count = count.astype(np.int64)
    start = np.concatenate(([0], np.cumsum(count)))
    owner = np.repeat(piece, count)
    share = (np.arange(start[-1]) - start[owner]) / count[owner]
    angle = steep[0][owner] + share * (steep[1] - steep[0])[owner]
    place = np.where(share == 0, section.x[owner], section.position_of_slope(owner, angle))
    # Stretched by less than half a step to end at the rounded width, at the height of its start.
    stretch = float(np.float32(section.width)) / section.width
    x: NDArray[np.float32] = (np.append(place, section.width) * stretch).astype(np.float32)
    z = section.height_on(_lender(owner, x), x.astype(float) / stretch)
    z[-1] = z[0]
    z = z.astype(np.float32)
    wide = x.astype(float)
    angle = _chord_angle(section, owner, wide, z.astype(float))
    if not np.all(angle <= chord_tolerance(section, angle_tolerance, owner, wide[:-1], wide[1:])):
        raise InputError(
            f"angle_tolerance: {angle_tolerance / deg:g} deg: too fine for the float32 coordinates "
            f"of an STL file {section.width:g} mm wide"
        )
    return x, z.astype(np.float32), owner


def piece_tolerance(section: Section, angle_tolerance: float) -> NDArray[np.float64]:
    """Return the angle [rad], (m,), within which the facets of each piece stay.

    It is `angle_tolerance`, but for arcs so small that float32 has no chords for it: theirs are
    about `ARC_STEPS` float32 steps wide.
    """
    needed = np.where(section.kind == ARC, ARC_STEPS * _step(section) * _sharpest(section), 0.0)
    return np.maximum(angle_tolerance, needed)


def chord_tolerance(
    section: Section,
    angle_tolerance: float,
    piece: NDArray[np.int64],
    left: NDArray[np.float64],
    right: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the angle [rad] within which chords from x = left to right on their pieces stay.

    It is that of the piece, and what half a float32 step does to a chord that ends at a kink.
    """
    kink = np.zeros(section.piece_count + 1)
    inner = np.arange(1, section.piece_count)
    corner = section.x[1:-1]
    kink[1:-1] = np.abs(section.slope_on(inner, corner) - section.slope_on(inner - 1, corner))
    step = _step(section)[piece]
    width = np.maximum(right - left, step)
    tolerance = piece_tolerance(section, angle_tolerance)[piece]
    for end, at in ((piece, left), (piece + 1, right)):
        touches = np.abs(at - section.x[end]) <= 2 * step
        tolerance = tolerance + np.where(touches, kink[end] * step / width, 0.0)
    return tolerance


def _step(section: Section) -> NDArray[np.float64]:
    """Return the float32 step [mm] at each piece, (m,)."""
    return np.spacing(section.x[1:].astype(np.float32)).astype(float)


def _sharpest(section: Section) -> NDArray[np.float64]:
    """Return the largest turn of the surface per width, (m,) [rad/mm]."""
    piece = np.arange(section.piece_count)
    slope = [np.abs(section.slope_on(piece, x)) for x in (section.x[:-1], section.x[1:])]
    bend = np.where(section.kind == LINE, 1.0, section.bend)
    arc = np.hypot(1.0, np.maximum(*slope)) / np.abs(bend)
    return np.select([section.kind == LINE, section.kind == ARC], [0.0, arc], np.abs(bend))


def _chords_for_volume(section: Section) -> NDArray[np.float64]:
    """Return how many chords each piece needs, (m,), to add `VOLUME_SHARE` of volume at most.

    k chords over a width w that bends by at most κ are off by κ w³/(12 k²) in area.
    """
    mean = section.area / section.width
    return np.diff(section.x) * np.sqrt(_sharpest(section) / (12 * VOLUME_SHARE * mean))


def _lender(owner: NDArray[np.int64], x: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the piece on which each corner's z is taken: that of the narrower chord beside it.

    A corner at a kink is off the other piece by up to half a step; the wider chord turns less.
    """
    wide = np.diff(x.astype(float))
    wide = np.concatenate(([np.inf], wide, [np.inf]))
    before, after = np.append(owner[0], owner), np.append(owner, owner[-1])
    return np.where(wide[:-1] < wide[1:], before, after)


def _chord_angle(
    section: Section, owner: NDArray[np.int64], x: NDArray[np.float64], z: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the larger angle [rad] between each chord and the surface at its two ends."""
    if not np.all(np.diff(x) > 0):
        return np.full(len(owner), np.inf)
    chord = np.arctan2(np.diff(z), np.diff(x))
    ends = [np.abs(chord - np.arctan(section.slope_on(owner, at))) for at in (x[:-1], x[1:])]
    return np.maximum(*ends)


def build_section_mesh(section: Section, angle_tolerance: float) -> Mesh:
    """Return the body as one closed mesh with facets within `angle_tolerance` [rad] of the surface.

    Raises
    ------
    InputError
        when float32 cannot hold so fine a mesh.
    """
    if not (math.isfinite(angle_tolerance) and angle_tolerance > 0):
        raise InputError(f"angle_tolerance: {angle_tolerance / deg:g} deg: expected above 0 deg")
    x, z, _ = build_outline(section, angle_tolerance)
    corners = len(x)
    foot = np.unique(np.append(np.arange(0, corners, BLOCK), corners - 1))
    cap = _cap(corners, foot)
    if _smallest_area(x, z - np.float32(section.underside), x[foot], cap) <= 0:
        foot = np.arange(corners)
        cap = _cap(corners, foot)
    below = x[foot]
    across = np.concatenate([x, below])
    up = np.concatenate([z, np.full_like(below, section.underside)])
    near = np.stack([across, np.zeros_like(across), up], axis=1)
    far = np.stack([across, np.full_like(across, section.length), up], axis=1)
    along = len(across)
    chain = np.concatenate([np.arange(corners), np.arange(along - 1, corners - 1, -1)])
    ahead = np.roll(chain, -1)
    first = np.stack([chain, ahead, ahead + along], axis=1)
    second = np.stack([chain, ahead + along, chain + along], axis=1)
    strip = np.stack([first, second], axis=1).reshape(-1, 3)
    return Mesh(np.concatenate([near, far]), np.concatenate([strip, cap, cap[:, ::-1] + along]))


def _cap(corners: int, foot: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the triangles of the cap at y = 0; foot k stands below corner `foot[k]`.

    Between two feet the left half of the chords is fanned from the left foot, the right half from
    the right one, with the triangle of both feet and the middle corner between.
    """
    chord = np.arange(corners - 1)
    block = np.searchsorted(foot, chord, side="right") - 1
    middle = (foot[:-1] + foot[1:]) // 2
    below = corners + block + (chord >= middle[block])
    fan = np.stack([below, chord + 1, chord], axis=1)
    stand = corners + np.arange(len(foot) - 1)
    return np.concatenate([fan, np.stack([stand, stand + 1, middle], axis=1)])


def _smallest_area(
    x: NDArray[np.float32], z: NDArray[np.float32], below: NDArray[np.float32], cap: NDArray
) -> float:
    """Return the smallest signed area [mm²] of the cap's triangles."""
    across = np.concatenate([x, below]).astype(float)[cap]
    up = np.concatenate([z, np.zeros_like(below)]).astype(float)[cap]
    first = (across[:, 1] - across[:, 0]) * (up[:, 2] - up[:, 0])
    return float((first - (across[:, 2] - across[:, 0]) * (up[:, 1] - up[:, 0])).min() / 2)
