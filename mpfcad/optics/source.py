"""Where paths start: a luminance meter, light from below, or the lamps."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import root, select
from mpfcad.optics.base.sampling import disk, uniform
from mpfcad.optics.cavity.endless import NO_LAMP, ON_REFLECTOR
from mpfcad.optics.cavity.start import cavity_start

EYE, LAMBERTIAN_BELOW, LAMPS, REFLECTOR = range(4)


class _SourceFields(NamedTuple):
    """The fields of a `Source`, as the kernels read them."""

    kind: int
    position: NDArray[np.float64]
    spot: float
    tilt_x: NDArray[np.float64]
    tilt_y: NDArray[np.float64]
    acceptance: float
    along: NDArray[np.float64]
    spot_along: float


class Source(_SourceFields):
    """Where paths start; one number for `tilt_x`, `tilt_y` or `along` stands for all points.

    Attributes
    ----------
    kind
        `EYE`: over the scene, looking down (a luminance meter, traced backward);
        `LAMBERTIAN_BELOW`: under it, Lambertian upward; `LAMPS`: on the lamps' surface,
        Lambertian; `REFLECTOR`: on the reflector under an endless row of tubes, Lambertian, traced
        backward without what the nearest tubes send there directly
    position
        (p,) float64 [mm], x of the measured points; paths are shared out equally
    spot
        width [mm] across over which a point is averaged
    tilt_x, tilt_y
        (p,) float64, direction cosines (kx, ky) of each meter's line of sight, downward; the light
        it measures goes toward (-kx, -ky) (0, 0: normal)
    acceptance
        sine of the half angle of the meter's acceptance cone about its axis
    along
        (p,) float64 [mm], y of the measured points
    spot_along
        length [mm] along y over which a point is averaged; 0 for that over which the stack repeats
    """

    __slots__ = ()

    def __new__(
        cls,
        kind: int,
        position: ArrayLike,
        spot: float,
        tilt_x: ArrayLike = 0.0,
        tilt_y: ArrayLike = 0.0,
        acceptance: float = 0.0,
        along: ArrayLike = 0.0,
        spot_along: float = 0.0,
    ) -> "Source":
        """Return the source with one entry a point in every array."""
        points = np.shape(position)
        position, tilt_x, tilt_y, along = (
            np.broadcast_to(np.asarray(values, np.float64), points).copy()
            for values in (position, tilt_x, tilt_y, along)
        )
        return super().__new__(
            cls, kind, position, float(spot), tilt_x, tilt_y, float(acceptance), along,
            float(spot_along),
        )  # fmt: skip


@kernel
def remaining_cosine(kx, ky):
    """Return the third direction cosine."""
    square = 1.0 - kx * kx - ky * ky
    return root(select(square > 0.0, square, 0.0))


@kernel
def look(tilt_x, tilt_y, acceptance, px, py):
    """Return the direction of a meter's ray: (px, py) of the unit disk within its cone.

    The cone stands upright on the meter's axis d0: d = cos a · d0 + sine of the half angle · p,
    p in the plane across d0. Along the normal this is (kx, ky) = acceptance · (px, py).
    One ray or eight.
    """
    axis = remaining_cosine(tilt_x, tilt_y)
    toward = (px * tilt_x + py * tilt_y) / (1.0 + axis)
    cosine = root(1.0 - acceptance * acceptance * (px * px + py * py))
    dx = cosine * tilt_x + acceptance * (px - toward * tilt_x)
    dy = cosine * tilt_y + acceptance * (py - toward * tilt_y)
    return dx, dy, -remaining_cosine(dx, dy)


@kernel
def start_place(source, length, point, rng):
    """Return where a path starts, (x, y), of a point's spot that is so long."""
    x = source.position[point] + (uniform(rng) - 0.5) * source.spot
    return x, source.along[point] + (uniform(rng) - 0.5) * length


@kernel
def start_ray(scene, source, point, rng):
    """Return the first (element, up, x, y, z, dx, dy, dz, lamp) of a path."""
    length = source.spot_along if source.spot_along > 0.0 else scene.length
    x, y = start_place(source, length, point, rng)
    last = len(scene.kind) - 1
    px, py = disk(rng)
    if source.kind == EYE:
        dx, dy, dz = look(source.tilt_x[point], source.tilt_y[point], source.acceptance, px, py)
        return last, False, x, y, 0.0, dx, dy, dz, NO_LAMP
    dz = remaining_cosine(px, py)
    if source.kind == LAMBERTIAN_BELOW:
        return 0, True, x, y, 0.0, px, py, dz, NO_LAMP
    if source.kind == REFLECTOR:
        return 0, True, x, y, 0.0, px, py, dz, ON_REFLECTOR
    x, y, z, dx, dy, dz, lamp = cavity_start(scene, y, rng)
    return 0, True, x, y, z, dx, dy, dz, lamp
