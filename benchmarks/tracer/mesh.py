"""The benchmark's meshes that the tests do not have."""

import numpy as np
from harness import REENTRANT, drawn, row, write_facets


def reentrant_grooves(path, count):
    """Write a film of grooves that are wider below than at their mouth, 150 µm under them."""
    x, z = row([REENTRANT] * count, 0.15)
    ring = np.r_[[(x[-1], z[-1])], np.c_[x, z][-2::-1], [(0.0, 0.0), (x[-1], 0.0)]]
    return write_facets(path, drawn([ring], length=20.0))


def pyramids(path, cells):
    """Write a field of pyramids of 50 µm, four facets each, on a plain base."""
    step = np.arange(cells + 1) * 0.05
    x, y = (v.ravel() for v in np.meshgrid(step[:-1], step[:-1], indexing="ij"))
    corner = [np.stack([x + a, y + b, np.full_like(x, 0.15)], axis=1)
              for a, b in ((0, 0), (0.05, 0), (0.05, 0.05), (0, 0.05))]  # fmt: skip
    tip = np.stack([x + 0.025, y + 0.025, np.full_like(x, 0.175)], axis=1)
    facets = [np.stack([corner[k], corner[(k + 1) % 4], tip], axis=1) for k in range(4)]
    end = step[-1]
    edge = [np.stack([step, 0 * step], 1), np.stack([0 * step + end, step], 1)]
    rim = np.concatenate([edge[0][:-1], edge[1][:-1], (end - edge[0])[:-1], (end - edge[1])[:-1]])
    p, q = (np.c_[r, 0 * r[:, 0]] for r in (rim, np.roll(rim, -1, axis=0)))
    r, s = (v + np.array([0, 0, 0.15]) for v in (p, q))
    centre = np.broadcast_to([end / 2, end / 2, 0.0], p.shape)
    sides = [np.stack(t, axis=1) for t in ((centre, q, p), (p, q, s), (p, s, r))]
    return write_facets(path, np.concatenate(facets + sides))
