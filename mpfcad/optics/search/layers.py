"""Extruded films of any cross-section in layers: undercuts, voids, several bodies, no flat side.

The outline is cut into *runs* that go on in x and bend to one side only, as those of a `chain`.
Each is turned so that it bends up: over it a ray is in a convex room, under it beside a convex
body. Upright strips between the ends of all runs cut them into *parts*. Within a strip parts lie
one over another without crossing. Between two of them is a *cell*, of film or of air: a ray in it
can only meet the part below, the part above, or a side. There a vertex tells into which cell of the
next strip it goes, by the same expression that tells on which side of the vertex it passes a part:
it cannot slip between them, and no offset is needed.

Upright walls are no height over x, so all is leaned over: x counts as x + lean · z.

`layers_build` makes them, `layers_walk` has the kernels.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Layers(NamedTuple):
    """The cross-section of an extruded film tile; x is leaned, and z of a part turned.

    Attributes
    ----------
    segment
        (s, 8) float64: x, z [mm] of the left and of the right end; dz/dx; what the unit normal
        (-dz/dx, 1 - lean · dz/dx) is to be multiplied by; dz/dx of the segments left and right
    part
        (p, 8) float64: x, z [mm] of the left and the right end; a, b, c of the parabola
        z = a + b u + c u², u [mm] from the left end; segments a millimetre
    range
        (p, 8) float64: first and last segment; the segment (with fraction) that the even spacing
        gives at the left end; z [mm], turned, of the nearest place of the next part under it, and
        of that over it, or of the end of the section's zone; 1, or -1 where z is turned, twice that
        where the film is over the part, not under it; the part under it, and that over it, and a
        quarter if a body is under or over that, or -1
    aside
        (8 p + q, 8) float64, of part, direction (4: upward), side (2: under it, turned) and way
        (1: right): the part to look at in the next strip if the ray passes below a vertex, z [mm]
        of that, the part if it passes above; width [mm] to take from x; x [mm] where the next strip
        ends; z [mm] from which on nothing in its cell is in the way of the direction, below and
        above the vertex, or infinity; 0. Part -1-i is row i, which asks for another vertex
    cell
        (4 c, 4) float64, of each of c equal cells of the width, from above and from below, and from
        within the band downward and upward: the part that is met first in the first strip in it,
        and that in the next one; x [mm] between these; -1, or the first strip of more than two
    strip
        (n, 4) float64: right end x [mm], infinity for the last; lowest and highest part; highest
        part below the band
    lean
        (3,) float64: lean, lowest and highest z [mm] of the band, a range that is free of all
        segments: a ray in it is put at once where it leaves it. Without one (inf, -inf)
    """

    segment: NDArray[np.float64]
    part: NDArray[np.float64]
    range: NDArray[np.float64]
    aside: NDArray[np.float64]
    cell: NDArray[np.float64]
    strip: NDArray[np.float64]
    lean: NDArray[np.float64]


_COLUMNS = (8, 8, 8, 8, 4, 4)
NO_LAYERS = Layers._make([*(np.zeros((0, n)) for n in _COLUMNS), np.zeros(3)])
