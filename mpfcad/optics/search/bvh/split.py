"""The binary tree of boxes that `build` makes eight wide.

Split where the surface-area heuristic in 16 bins is least (Wald, "On fast construction of SAH-based
bounding volume hierarchies", 2007), laid out depth first: a node's first child follows it.
"""

import math

import numpy as np
from numba import njit

from mpfcad.store.kernel import kept

_BINS = 16
LEAF = 8


@kept
@njit
def binary_tree(low, high, centre):
    """Return (order (t,), box (n, 6), leaf (n, 2), skip (n,)) of the tree over boxes low…high."""
    count = len(centre)
    order = np.arange(count)
    box = np.empty((2 * count, 6))
    leaf = np.zeros((2 * count, 2), np.int64)
    parent = np.empty(2 * count, np.int64)
    stack = [(-1, 0, count)]
    used = 0
    while len(stack) > 0:
        above, first, last = stack.pop()
        node = used
        parent[node] = above
        used += 1
        for axis in range(3):
            box[node, axis] = np.inf
            box[node, 3 + axis] = -np.inf
            for i in range(first, last):
                box[node, axis] = min(box[node, axis], low[order[i], axis])
                box[node, 3 + axis] = max(box[node, 3 + axis], high[order[i], axis])
        middle = first
        if last - first > LEAF:
            middle = _partition(order, low, high, centre, first, last)
        if middle in (first, last):
            leaf[node, 0] = first
            leaf[node, 1] = last - first
            continue
        stack.append((node, middle, last))
        stack.append((node, first, middle))
    size = np.ones(used, np.int64)
    for node in range(used - 1, 0, -1):
        size[parent[node]] += size[node]
    return order, box[:used].copy(), leaf[:used].copy(), np.arange(used) + size


@njit
def _partition(order, low, high, centre, first, last):
    """Reorder order[first:last] about the best split and return where it lies."""
    best, best_axis, best_bin = np.inf, -1, 0
    for axis in range(3):
        start, extent = _spread(order, centre, axis, first, last)
        if extent <= 0.0:
            continue
        cost, at = _best_bin(order, low, high, centre, axis, start, extent, first, last)
        if cost < best:
            best, best_axis, best_bin = cost, axis, at
    if best_axis < 0:
        return (first + last) // 2 if last - first > 4 * LEAF else first
    start, extent = _spread(order, centre, best_axis, first, last)
    i, j = first, last - 1
    while i <= j:
        if _bin(centre[order[i], best_axis], start, extent) <= best_bin:
            i += 1
        else:
            order[i], order[j] = order[j], order[i]
            j -= 1
    return i


@njit
def _spread(order, centre, axis, first, last):
    """Return lowest value and range of the centres along an axis."""
    start, end = np.inf, -np.inf
    for i in range(first, last):
        start = min(start, centre[order[i], axis])
        end = max(end, centre[order[i], axis])
    return start, end - start


@njit
def _bin(value, start, extent):
    return min(_BINS - 1, int((value - start) / extent * _BINS))


@njit
def _best_bin(order, low, high, centre, axis, start, extent, first, last):
    """Return (cost, bin) of the cheapest split along an axis."""
    number = np.zeros(_BINS)
    bounds = np.empty((_BINS, 6))
    bounds[:, :3] = np.inf
    bounds[:, 3:] = -np.inf
    for i in range(first, last):
        t = order[i]
        b = _bin(centre[t, axis], start, extent)
        number[b] += 1
        for d in range(3):
            bounds[b, d] = min(bounds[b, d], low[t, d])
            bounds[b, 3 + d] = max(bounds[b, 3 + d], high[t, d])
    best, at = np.inf, 0
    for split in range(_BINS - 1):
        cost = 0.0
        filled = True
        for begin, end in ((0, split + 1), (split + 1, _BINS)):
            total = number[begin:end].sum()
            if total == 0:
                filled = False
                break
            a = bounds[begin:end, 3].max() - bounds[begin:end, 0].min()
            b = bounds[begin:end, 4].max() - bounds[begin:end, 1].min()
            c = bounds[begin:end, 5].max() - bounds[begin:end, 2].min()
            cost += math.ceil(total / LEAF) * (a * b + b * c + c * a)
        if filled and cost < best:
            best, at = cost, split
    return best, at
