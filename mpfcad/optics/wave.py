"""What a wave of paths under way consists of: a slot for each, and a queue before each element.

Paths are not followed one after the other but a queue at a time, so that the many rays that stand
before the same film can go through it in lanes. A path's random numbers are its own, so the
order does not change it.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import LANES, WIDE
from mpfcad.optics.base.lanes_array import aligned
from mpfcad.optics.base.sampling import RNG_SIZE
from mpfcad.optics.film.chain_lanes import PLACE_SIZE

#: Paths under way at once: their slots fit the processor's second cache.
SLOTS = 1024


class Wave(NamedTuple):
    """Paths under way, one a slot, s slots; e elements.

    Attributes
    ----------
    place
        (s+1, 8) float64, x, y, z [mm] and direction; two that are free. The last row is that of
        lanes without a ray
    weight, radiance
        (s+1,), (s,) float64
    upward, way
        (s,), (s+1,) int64, whether the ray goes up (0, 1); 1, -1, 0 after an element
    lamp, path
        (s,) int64, the lamp that the path starts on; its number in the block
    rng
        (s+1, 8) uint64, generators
    queue, length
        (e, s) int64, slots that wait before each element; (e,) int64, how many
    batch, freed
        (s,) int64, scratch: the slots of one queue; those whose paths have ended
    waiting
        (48,) int64, scratch: rays that are to come into a film's lanes
    lane_row, lane_flow
        (16,) int64, (16, 8) float64, scratch of the rays in lanes
    net_key
        (n, 8) int64, the keys of the points' nets, and round again
    passed
        (1,) int64, how many rays have been through an element: the work done, which no clock tells
    """

    place: NDArray[np.float64]
    weight: NDArray[np.float64]
    radiance: NDArray[np.float64]
    upward: NDArray[np.int64]
    way: NDArray[np.int64]
    lamp: NDArray[np.int64]
    path: NDArray[np.int64]
    rng: NDArray[np.uint64]
    queue: NDArray[np.int64]
    length: NDArray[np.int64]
    batch: NDArray[np.int64]
    freed: NDArray[np.int64]
    waiting: NDArray[np.int64]
    lane_row: NDArray[np.int64]
    lane_flow: NDArray[np.float64]
    net_key: NDArray[np.int64]
    passed: NDArray[np.int64]

    @classmethod
    def empty(cls, elements: int, points: int = 0) -> "Wave":
        """Return the scratch of a wave of paths from some points through a number of elements."""

        def real(*shape: int) -> NDArray[np.float64]:
            return aligned(shape, np.float64)

        def whole(*shape: int) -> NDArray[np.int64]:
            return aligned(shape, np.int64)

        return cls(
            real(SLOTS + 1, PLACE_SIZE), real(SLOTS + 1), real(SLOTS),
            whole(SLOTS), whole(SLOTS + 1), whole(SLOTS), whole(SLOTS),
            aligned((SLOTS + 1, RNG_SIZE), np.uint64),
            whole(elements, SLOTS), whole(elements), whole(SLOTS), whole(SLOTS),
            whole(2 * (LANES + WIDE)), whole(WIDE), real(WIDE, 8),
            whole(-(-points // LANES) + 1 if points else 0, LANES), whole(1),
        )  # fmt: skip


@kernel
def enqueue(wave, element, slot):
    """Let a slot's ray wait before an element."""
    wave.queue[element, wave.length[element]] = slot
    wave.length[element] += 1


@kernel
def take_longest(wave):
    """Move the queue in which most wait into the batch; return (element, number)."""
    best = 0
    for e in range(1, len(wave.length)):
        if wave.length[e] > wave.length[best]:
            best = e
    waiting = wave.length[best]
    for i in range(waiting):
        wave.batch[i] = wave.queue[best, i]
    wave.length[best] = 0
    wave.passed[0] += waiting
    return best, waiting
