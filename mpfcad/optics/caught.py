"""Rays caught as they come up to a place in the stack."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.cavity.finite import FAR, LEFT, NEAR, RIGHT

#: The columns of a ray: its place [mm], its direction, its weight (start: 1 a path).
X, Y, DX, DY, DZ, WEIGHT = range(6)
_COLUMNS = 6
_NOWHERE = -1


class Net(NamedTuple):
    """What rays are caught in.

    Attributes
    ----------
    gate
        the element that they come up to; the number of elements for those that leave the scene
    ray
        (n, 6) float64, the first n of them, as they come
    path
        (n,) int64, the number in the block of each one's path
    """

    gate: int
    ray: NDArray[np.float64]
    path: NDArray[np.int64]

    @classmethod
    def at(cls, gate: int, room: int) -> "Net":
        """Return a net that holds so many rays."""
        return cls(gate, np.empty((room, _COLUMNS)), np.empty(room, np.int64))


#: Catches nothing.
NO_NET = Net.at(_NOWHERE, 0)


@kernel
def catch(net, wall, wave, slot, found):
    """Put a ray that has left the element under the gate into the net; return how many came."""
    place = wave.place[slot]
    is_over = wall[LEFT] <= place[0] <= wall[RIGHT] and wall[NEAR] <= place[1] <= wall[FAR]
    if wave.way[slot] <= 0 or wave.weight[slot] <= 0.0 or not is_over:
        return found
    if found < len(net.path):
        ray = net.ray[found]
        ray[X], ray[Y], ray[WEIGHT] = place[0], place[1], wave.weight[slot]
        ray[DX], ray[DY], ray[DZ] = place[3], place[4], place[5]
        net.path[found] = wave.path[slot]
    return found + 1
