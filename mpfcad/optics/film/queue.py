"""The rays of a film's queue that its sixteen lanes are filled with.

Rays that come from below have to pass a flat underside first: eight at once, and those that do are
*ready*, as are rays from above. `waiting` holds them, after sixteen times the row of lanes without
a ray, which is the last one of `place`.
"""

from numba import uint64

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import LANES, WIDE, count_of
from mpfcad.optics.base.lanes_array import expand

_DZ = 5


@kernel
def next_eight(rays, following, place, ready, lane_row, waiting):
    """Take rays of the queue until there are eight that come from below, or enough ready ones.

    (how many come from below, following, ready); those rows are in lane_row.
    """
    count, none = 0, len(place) - 1
    while count < LANES and ready < WIDE and following < len(rays):
        ray = uint64(rays[uint64(following)])
        following += 1
        falls = 1 if place[ray, _DZ] < 0.0 else 0
        waiting[uint64(WIDE + ready)] = ray
        lane_row[uint64(count)] = ray
        ready += falls
        count += 1 - falls
    for i in range(count, LANES):
        lane_row[i] = none
    return count, following, ready


@kernel
def get_ready(left, count, ready, way, lane_row, waiting):
    """Make rays ready that have passed the underside; the others, bits of `left`, went down."""
    for i in range(count):
        ray = uint64(lane_row[uint64(i)])
        waiting[uint64(WIDE + ready)] = ray
        ready += 1 - ((left >> i) & 1)
        way[ray] = -1
    return ready


@kernel
def fill_lanes(vacant, row, ready, waiting):
    """Return the rows of all lanes after the vacant ones were filled, and how many are ready."""
    count = count_of(vacant)
    first = ready - count
    row = expand(waiting, WIDE + first, vacant, row)
    return row, max(first, 0)
