"""What float32 does to a film's corners: which x they are rounded to."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import PrismFilm

#: A corner may move by so many steps to each side, each 3 % of a chord or one float32 step,
TRIALS = 4
STRIDE = 0.03
#: but by no more than this share of a chord.
REACH = 0.25

#: z [mm] at distances [mm] from the tips, for the corners in a mask.
Height = Callable[[NDArray[np.float64], NDArray[np.bool_]], NDArray[np.float64]]


def coarsest_step(film: PrismFilm, number: type[np.floating]) -> float:
    """Return the coordinates' step [mm] at the film's far side."""
    return float(np.spacing(number(film.width)))


def settle(
    depth: NDArray[np.float64],
    movable: NDArray[np.bool_],
    chord: NDArray[np.float64],
    step: float,
    height: Height,
) -> NDArray[np.float64]:
    """Return the corners' distances [mm] from their tips, (m,), each with z rounding best nearby.

    Each is a whole number of steps, so that float32 holds it anywhere on the film. One float32 step
    of z is 0.015 nm at 0.2 mm; over a facet of 0.3 µm the error of two roundings is 0.0013° rms.

    Parameters
    ----------
    depth
        (m,) [mm], whole numbers of steps
    movable
        (m,) which corners may move: none at a kink
    chord
        (m,) [mm], width of the facets there
    step
        [mm]
    height
        z of the surface
    """
    width = chord[movable]
    stride = np.maximum(np.round(STRIDE * width / step), 1) * step
    start = best = depth[movable]
    error = _error(height(best, movable))
    for trial in [*range(-TRIALS, 0), *range(1, TRIALS + 1)]:
        moved = start + trial * stride
        off = _error(height(moved, movable))
        better = (off < error) & (abs(trial) * stride <= REACH * width)
        best = np.where(better, moved, best)
        error = np.where(better, off, error)
    depth = depth.copy()
    depth[movable] = best
    return depth


def _error(z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far z [mm] moves when rounded to float32."""
    return np.abs(z - z.astype(np.float32))


def round_contact(
    film: PrismFilm, contact: NDArray[np.float64], step: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return each contact point's |x| [mm], (n,), rounded, and the lift [mm] of the parabolas.

    The point stays on the wall, so that a bare wall has its slope exactly, and the parabola is
    moved up or down to pass through it: by less than a step, and no slope changes. Rounding errors
    are carried on from groove to groove: over several, walls are as wide as they should be.
    """
    half_width = film.groove.half_width
    bare = (contact > 0) & (contact < half_width)
    wall = np.where(bare, half_width - contact, 0.0)
    rounded = np.diff(np.round(np.cumsum(wall) / step), prepend=0.0) * step
    reach = np.where(bare, half_width - rounded, contact)
    lift = rounded * (film.curvature / 2 * (half_width + reach) - film.groove.wall_slope)
    return reach, np.where(bare, lift, 0.0)


def round_tips(film: PrismFilm, number: type[np.floating]) -> NDArray[np.floating]:
    """Return x of each tip, (n+1,) [mm], in the coordinates' type.

    In float32 every second number is taken, so that the middle between two tips is one as well:
    both walls of an empty groove then have their slope exactly. The last tip is the film's width.
    """
    tips = film.tip_position.astype(number)
    if number is np.float32:
        step = 2 * np.spacing(np.float32(film.tip_position + film.groove.pitch)).astype(float)
        tips[:-1] = (np.round(film.tip_position / step) * step)[:-1]
    return tips
