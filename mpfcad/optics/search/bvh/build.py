"""Builds the tree of `bvh` over a film's top: a binary tree made eight wide."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mpfcad.optics.base.lanes import LANES
from mpfcad.optics.base.lanes_array import aligned
from mpfcad.optics.search.bvh.split import LEAF, binary_tree
from mpfcad.optics.search.bvh.tree import Bvh
from mpfcad.optics.search.seam import facet_normals, with_seam
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.store.kernel import kept


def build_bvh(mesh: FilmMesh) -> Bvh:
    """Return the tree over the top facets of a film mesh."""
    corner, number = with_seam(mesh.vertex[mesh.top], *mesh.size[:2])
    low, high = corner.min(axis=1), corner.max(axis=1)
    order, box, leaf, skip = binary_tree(low, high, (low + high) / 2)
    normal = facet_normals(mesh.vertex[mesh.top])
    # Widen the boxes by more than the rounding of what is tested, so that no facet is lost.
    margin = 64 * np.finfo(float).eps * max(mesh.size)
    box[:, :3] -= margin
    box[:, 3:] += margin
    wide, child, used = _widen(box, leaf, skip)
    blocks = leaf[used]
    place = np.minimum(np.arange(LEAF), blocks[:, 1:] - 1) + blocks[:, :1]
    facet = order[place]
    points = corner[facet].reshape(len(blocks), LEAF, 9).transpose(0, 2, 1)
    facet = np.where(np.arange(LEAF) < blocks[:, 1:], number[facet], -1)
    # A triangle of one point is met by no ray.
    points = np.where(facet[:, None] < 0, np.tile(points[:, :3, :1], (1, 3, LEAF)), points)
    box, points = _outward(wide).reshape(-1, LANES), points.reshape(-1, LEAF)
    child, facet = child.astype(np.int32), facet.astype(np.int32)
    return Bvh(_on_lines(box), _on_lines(child), _on_lines(points), _on_lines(facet), normal)


def _on_lines(array: NDArray) -> NDArray:
    """Return an array that begins with a cache line."""
    out = aligned(array.shape, array.dtype)
    out[:] = array
    return out


def _outward(box: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return boxes (n, 6, 8) in single precision, none smaller."""
    single = box.astype(np.float32)
    low = np.nextafter(single[:, :3], np.float32(-np.inf))
    high = np.nextafter(single[:, 3:], np.float32(np.inf))
    return np.concatenate([low, high], axis=1)


@kept
@njit
def _widen(box, leaf, skip):
    """Return (boxes (n, 6, 8), children (n, 8), the leaves taken) of the tree made eight wide.

    The child with the largest surface is replaced by its two children until there are eight.
    """
    wide = np.empty((len(box) + 1, 6, LANES))
    child = np.zeros((len(box) + 1, LANES), np.int64)
    leaves = np.empty(len(box), np.int64)
    used, taken = 1, 0
    todo = [(0, 0)]
    members = np.empty(LANES, np.int64)
    while len(todo) > 0:
        node, number = todo.pop()
        members[0] = node
        count = 1
        while count < LANES:
            best, widest = -1, -1.0
            for i in range(count):
                b = box[members[i]]
                x, y, z = b[3] - b[0], b[4] - b[1], b[5] - b[2]
                if leaf[members[i], 1] == 0 and x * y + y * z + z * x > widest:
                    best, widest = i, x * y + y * z + z * x
            if best < 0:
                break
            first = members[best] + 1
            members[best] = first
            members[count] = skip[first]
            count += 1
        for i in range(LANES):
            for row in range(6):
                empty = np.inf if row < 3 else -np.inf
                wide[number, row, i] = box[members[i], row] if i < count else empty
            if i >= count:
                continue
            if leaf[members[i], 1] > 0:
                child[number, i] = -1 - taken
                leaves[taken] = members[i]
                taken += 1
            else:
                child[number, i] = used
                todo.append((members[i], used))
                used += 1
    return wide[:used].copy(), child[:used].copy(), leaves[:taken].copy()
