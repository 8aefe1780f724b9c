"""The film, prism and resin together, as one closed triangle mesh. Plain numpy.

The cross-section is a polyline refined by *angle*: a chord of the parabola has the slope of its
middle, so a facet of width Δx is off by C·Δx/2 at its ends. A binary STL holds float32, of which
one step is 30 nm at x = 390 mm. So each half groove is moved, as it is, to where its tip is
rounded to (by at most one step). Its corners are whole steps of the film's far side away from the
tip, and z is evaluated there: grooves of equal C are the same wherever they lie. Contact points
stay on the walls and lift the parabola by less than a step, so walls and parabolas have their
slopes, and tips the full height. Of the x within a fraction of a facet the one is taken whose z
rounds best. The same polyline in float64 is neither moved nor rounded.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.cad.shape.rounding import coarsest_step, round_contact, round_tips, settle
from mpfcad.cad.step.outline import check_drawable, drawn_contact, drawn_sliver
from mpfcad.errors import InputError
from mpfcad.film import PrismFilm
from mpfcad.units import deg, nm

#: Share of the volume that the chords may add, however coarse an angle is asked.
VOLUME_SHARE = 3e-5
#: Chords narrower than this are not drawn: float32 in z alone would spoil their angle.
FINEST_CHORD = 10 * nm


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh: `vertices` (v, 3) float32 or float64 [mm], `triangles` (t, 3), outward."""

    vertices: NDArray[np.floating]
    triangles: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class CrossSection:
    """The polyline across the film, left to right, as the file will hold it.

    Attributes
    ----------
    x, z
        (m,) float32 or float64 [mm], the corners
    tip
        (n+1,) int64, index of each tip
    centre
        (n,) int64, index of each groove's lowest corner
    """

    x: NDArray[np.floating]
    z: NDArray[np.floating]
    tip: NDArray[np.int64]
    centre: NDArray[np.int64]


def mesh_sliver(film: PrismFilm) -> float:
    """Return the width [mm] below which the mesh merges a part: 0.1 µm or four float32 steps."""
    return drawn_sliver(film.width)


def mesh_contact(film: PrismFilm) -> NDArray[np.float64]:
    """Return |x| [mm], (n,) float64, up to which each groove is meshed as a parabola."""
    if film.profile == "ideal":
        return np.full(film.groove_count, film.groove.half_width)
    return drawn_contact(film, mesh_sliver(film))


def build_cross_section(
    film: PrismFilm, angle_tolerance: float, number: type[np.floating] = np.float32
) -> CrossSection:
    """Return the polyline whose normals are nowhere more than `angle_tolerance` [rad] off.

    Both halves of a groove have the same number of corners at the same distances from its centre;
    the centre, the contact points and the tips are corners; a straight wall is one piece.

    Raises
    ------
    InputError
        when the film cannot be drawn, or float32 cannot hold so fine a polyline.
    """
    check_drawable(film)
    if not (math.isfinite(angle_tolerance) and angle_tolerance > 0):
        raise InputError(f"angle_tolerance: {angle_tolerance / deg:g} deg: expected above 0 deg")
    contact = mesh_contact(film)
    reach = np.arctan(film.curvature * contact)
    # A chord may come out one step wider than planned.
    step = coarsest_step(film, number)
    room = np.maximum(angle_tolerance - film.curvature * step / 2, angle_tolerance / 4)
    pieces = np.maximum(reach / (2 * room), _pieces_for_volume(film, contact))
    pieces = np.where(contact > 0, np.clip(np.ceil(pieces), 1, 10**9), 0).astype(np.int64)
    finest = max(2 * step, FINEST_CHORD)
    _, alike = np.unique(film.curvature, return_inverse=True)
    while np.all(pieces * finest <= contact):
        section, chord, groove = _lay_out(film, contact, reach, pieces, number)
        # Grooves of equal curvature have equally many chords, wherever they lie.
        off = np.bincount(alike[groove], chord > angle_tolerance) > 0
        if not off.any():
            return section
        pieces = pieces + off[alike] * np.maximum(pieces // 8, 1)
    raise InputError(
        f"angle_tolerance: {angle_tolerance / deg:g} deg: too fine for the float32 coordinates of"
        f" an STL file {film.width:g} mm wide"
    )


def _pieces_for_volume(film: PrismFilm, contact: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how many chords each half parabola needs, (n,), to add `VOLUME_SHARE` at most.

    A chord of width Δx adds C Δx³/12 to the cross-section; of k chords that turn by the same angle,
    from slope 0 to s = C x_c, Δx = atan(s) (1 + slope²)/(k C). Summed over both halves that is
    atan²(s) x_c (1 + 2s²/3 + s⁴/5)/(6 C k²).
    """
    section = film.volume / film.length / film.groove_count
    curvature = np.maximum(film.curvature, np.finfo(float).tiny)
    steep = curvature * contact
    widening = 1 + 2 * steep**2 / 3 + steep**4 / 5
    added = np.arctan(steep) * (np.arctan(steep) / curvature) * contact * widening / 6
    return np.sqrt(added / (VOLUME_SHARE * section))


def _lay_out(
    film: PrismFilm,
    contact: NDArray[np.float64],
    reach: NDArray[np.float64],
    pieces: NDArray[np.int64],
    number: type[np.floating],
) -> tuple[CrossSection, NDArray[np.float64], NDArray[np.int64]]:
    """Return the polyline with `pieces` chords in each half parabola, and how far each is off.

    `number` is the coordinates' type. The second array is the largest angle [rad] between a chord
    and the parabola at its two ends (0 for a wall), the third the groove of each piece, both
    (m-1,).
    """
    half_width = film.groove.half_width
    bare = contact < half_width
    lift = np.zeros_like(contact)
    step = coarsest_step(film, number)
    if number is np.float32:
        contact, lift = round_contact(film, contact, step)
    count = 2 * pieces + 2 * bare
    start = np.concatenate(([0], np.cumsum(count)))
    groove = np.repeat(np.arange(film.groove_count), count)
    # Corner 0 … 2·pieces of the parabola, from contact to contact; -1 is the tip before it.
    corner = np.arange(start[-1]) - start[groove] - bare[groove]
    ratio = corner / np.maximum(pieces, 1)[groove] - 1
    angle = reach[groove]
    turn = np.divide(np.tan(angle * ratio), np.tan(angle), out=ratio.copy(), where=angle > 1e-9)
    local = np.where(pieces[groove] > 0, turn * contact[groove], 0.0)
    tips = round_tips(film, number)
    moved = tips - film.tip_position
    # The middle belongs to both halves; all other corners are moved with their tip.
    middle = corner == pieces[groove]
    right = local > 0
    end = ((corner == 0) | (corner == 2 * pieces[groove])) & bare[groove] & (local != 0)
    parabola = (pieces[groove] > 0) & (corner >= 1 - bare[groove])

    def height(depth: NDArray[np.float64], which: NDArray[np.bool_] | slice) -> NDArray[np.float64]:
        drop = film.curvature[groove[which]] / 2 * depth * (2 * half_width - depth)
        return film.thickness + lift[groove[which]] - drop

    depth = half_width - np.abs(local)
    if number is np.float32:
        # Chords of equal turn are narrowest where the parabola is flat.
        flat = np.divide(angle, np.tan(angle), out=np.ones_like(angle), where=angle > 1e-9)
        chord = (contact / np.maximum(pieces, 1))[groove] * flat
        chord *= 1 + (film.curvature[groove] * local) ** 2
        depth = np.where(middle, half_width, np.round(depth / step) * step)
        depth = settle(depth, parabola & ~middle & ~end, chord, step, height)
        local = np.sign(local) * (half_width - depth)
    own = tips[groove + right] + np.where(right, -depth, depth)
    x = np.where(middle, (tips[:-1] / 2 + tips[1:] / 2)[groove], own).astype(number)
    x[start[:-1]] = tips[:-1]
    # A groove made wider by the moves has its middle deeper down, by each half's own slope there.
    apart = np.diff(moved)[groove]
    wall = film.base - film.groove.wall_slope * apart / 2
    z = np.where(parabola, height(depth, slice(None)), wall)
    z += np.where(parabola & middle, film.curvature[groove] * apart**2 / 8, 0.0)
    z[start[:-1]] = film.thickness

    x = np.append(x, tips[-1])
    z = np.append(z, film.thickness).astype(x.dtype)
    chord = np.arctan2(np.diff(z.astype(float)), np.diff(x.astype(float)))
    # Of the middle, each half has its own x.
    ahead = np.append((local + np.where(middle, apart / 2, 0.0))[1:], half_width)
    ahead = np.where(start[groove + 1] - 1 == np.arange(start[-1]), half_width, ahead)
    curved = (corner >= 0) & (corner < 2 * pieces[groove])
    behind = np.where(corner == 0, -np.abs(local), local - np.where(middle, apart / 2, 0.0))
    off = np.maximum(
        np.abs(chord - np.arctan(film.curvature[groove] * behind)),
        np.abs(chord - np.arctan(film.curvature[groove] * ahead)),
    )
    section = CrossSection(x, z, start, start[:-1] + pieces + bare)
    return section, np.where(curved, off, 0.0), groove


def build_mesh(
    film: PrismFilm, angle_tolerance: float, number: type[np.floating] = np.float32
) -> Mesh:
    """Return the film as one closed mesh with facets within `angle_tolerance` [rad] of the surface.

    The underside is cut below each tip. A cap is fanned, in each groove, from the two corners below
    its tips: the surface falls from the tip to the middle, so each corner sees its whole half.
    """
    section = build_cross_section(film, angle_tolerance, number)
    corners, tips = len(section.x), film.groove_count + 1
    below = section.x[section.tip]
    x = np.concatenate([section.x, below])
    z = np.concatenate([section.z, np.zeros_like(below)])
    near = np.stack([x, np.zeros_like(x), z], axis=1)
    far = np.stack([x, np.full_like(x, film.length), z], axis=1)
    cap = _cap(section)
    along = corners + tips
    chain = np.concatenate([np.arange(corners), np.arange(along - 1, corners - 1, -1)])
    strip = _strip(chain, along)
    return Mesh(np.concatenate([near, far]), np.concatenate([strip, cap, cap[:, ::-1] + along]))


def _strip(chain: NDArray[np.int64], along: int) -> NDArray[np.int64]:
    """Return the triangles between the closed chain of corners at y = 0 and the one at y = length.

    The chain runs clockwise as seen from y < 0; corner i at y = length is i + `along`.
    """
    here, ahead = chain, np.roll(chain, -1)
    first = np.stack([here, ahead, ahead + along], axis=1)
    second = np.stack([here, ahead + along, here + along], axis=1)
    return np.stack([first, second], axis=1).reshape(-1, 3)


def _cap(section: CrossSection) -> NDArray[np.int64]:
    """Return the triangles of the cap at y = 0."""
    corners = len(section.x)
    grooves = len(section.centre)
    piece = np.arange(corners - 1)
    groove = np.repeat(np.arange(grooves), np.diff(section.tip))
    below = corners + groove + (piece >= section.centre[groove])
    fan = np.stack([below, piece + 1, piece], axis=1)
    foot = corners + np.arange(grooves)
    return np.concatenate([fan, np.stack([foot, foot + 1, section.centre], axis=1)])
