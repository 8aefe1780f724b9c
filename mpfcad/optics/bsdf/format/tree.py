"""Tensor trees: Radiance's BSDF of variable resolution, isotropic (3-D) or not (4-D).

Directions lie on the unit square by the concentric map of P. Shirley and K. Chiu ("A low distortion
map between disk and square", 1997), which keeps projected solid angle. A tree of four dimensions
has the square of the way of travel in, then that of the way out; one of three has (1 - sin θ)/2 of
the incidence, then the square of the way out, its azimuth counted from the way in (Radiance,
bsdf_t.c). Each branch halves every dimension, bit d of a child's number belongs to dimension d.
"""

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis, even_basis, ring_basis
from mpfcad.optics.bsdf.format.klems import incident_structure, visible_blocks
from mpfcad.optics.bsdf.missing import Matrices

_BASIS = "lbnl/shirley-chiu"
#: Halvings that are kept apart, by dimensions; finer leaves are averaged.
_MOST = {3: 7, 4: 6}
_DEEPEST = 12
_RINGS, _AZIMUTHS = 18, 36
#: Points a side of the square for the share of each cell in each bin.
_POINTS = 1024


def read_tree(path: Path, root: ElementTree.Element) -> tuple[AngleBasis, bool, Matrices]:
    """Return (basis, isotropic, matrices (i, o) [1/sr] by (way, side)) of a file's XML.

    Raises
    ------
    InputError
        when a tree is not of the basis, or its braces and numbers make no tree.
    """
    dimensions = 3 if incident_structure(root) == "tensortree3" else 4
    isotropic = dimensions == 3
    basis = even_basis(_RINGS)
    if isotropic:
        basis = ring_basis(np.linspace(0, np.pi / 2, _RINGS + 1), _AZIMUTHS)
    found: Matrices = {}
    for key, direction, block in visible_blocks(path, root):
        name = (block.findtext("AngleBasis") or block.findtext("ColumnAngleBasis") or "").strip()
        if name.lower() != _BASIS:
            raise InputError(
                f"{path}: {direction}: AngleBasis {name or 'missing'}: expected LBNL/Shirley-Chiu"
            )
        cells = _dense(f"{path}: {direction}", block.findtext("ScatteringData") or "", dimensions)
        found[key] = _isotropic(cells, basis) if isotropic else _anisotropic(cells, basis)
    return basis, isotropic, found


def _dense(where: str, text: str, dimensions: int) -> NDArray[np.float64]:
    """Return a tree as a grid (2^l, …) of its values."""
    tree = _parsed(where, text, dimensions)
    deep = min(_depth(tree, dimensions), _MOST[dimensions])
    grid = np.empty((1 << deep,) * dimensions)
    _fill(tree, grid)
    return grid


def _parsed(where: str, text: str, dimensions: int) -> list | NDArray[np.float64]:
    """Return nested lists of 2^dimensions branches, and leaves as grids (n, …)."""
    stack: list[list] = [[]]
    last = 0
    for brace in re.finditer("[{}]", text):
        between = text[last : brace.start()].replace(",", " ").split()
        last = brace.end()
        if brace.group() == "{":
            if between or len(stack) > _DEEPEST:
                raise InputError(f"{where}: tensor tree: expected braces up to {_DEEPEST} deep")
            stack.append([])
            continue
        done = stack.pop() if len(stack) > 1 else None
        if done is None or bool(between) == bool(done):
            raise InputError(f"{where}: tensor tree: braces: expected values or branches in each")
        stack[-1].append(_leaf(where, between, dimensions) if between else done)
        if done and len(done) != 1 << dimensions:
            raise InputError(
                f"{where}: tensor tree: {len(done)} branches: expected {1 << dimensions}"
            )
    if len(stack) != 1 or len(stack[0]) != 1 or text[last:].strip():
        raise InputError(f"{where}: tensor tree: expected one tree in closed braces")
    return stack[0][0]


def _leaf(where: str, values: list[str], dimensions: int) -> NDArray[np.float64]:
    try:
        value = np.array(values, float)
    except ValueError as error:
        raise InputError(f"{where}: tensor tree: {error}") from None
    side = round(len(value) ** (1 / dimensions))
    if side**dimensions != len(value) or side & (side - 1):
        raise InputError(
            f"{where}: tensor tree: a leaf of {len(value)} values: expected a power of "
            f"{1 << dimensions}"
        )
    if not np.isfinite(value).all():
        raise InputError(f"{where}: tensor tree: expected finite numbers")
    # Rounding of trees that were made by interpolation leaves values just below 0.
    return np.maximum(value, 0.0).reshape((side,) * dimensions)


def _depth(tree: list | NDArray[np.float64], dimensions: int) -> int:
    if isinstance(tree, list):
        return 1 + max(_depth(branch, dimensions) for branch in tree)
    return int(tree.shape[0]).bit_length() - 1


def _fill(tree: list | NDArray[np.float64], grid: NDArray[np.float64]) -> None:
    """Write a tree into a grid, finer leaves averaged."""
    size, dimensions = grid.shape[0], grid.ndim
    if isinstance(tree, list):
        if size == 1:
            parts = np.empty((2,) * dimensions)
            _fill(tree, parts)
            grid[...] = parts.mean()
            return
        half = (slice(0, size // 2), slice(size // 2, size))
        for n, branch in enumerate(tree):
            _fill(branch, grid[tuple(half[n >> d & 1] for d in range(dimensions))])
        return
    side = tree.shape[0]
    if side > size:
        step = side // size
        shape = [m for _ in range(dimensions) for m in (size, step)]
        grid[...] = tree.reshape(shape).mean(axis=tuple(range(1, 2 * dimensions, 2)))
        return
    for axis in range(dimensions):
        tree = np.repeat(tree, size // side, axis=axis)
    grid[...] = tree


def _disk(u: NDArray[np.float64], v: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
    """Return (kx, ky) at places of the unit square."""
    a, b = 2 * u - 1, 2 * v - 1
    wide = np.abs(a) > np.abs(b)
    long, short = np.where(wide, a, b), np.where(wide, b, a)
    turn = np.pi / 4 * short / np.where(long == 0, 1.0, long)
    angle = np.where(wide, turn, np.pi / 2 - turn)
    return long * np.cos(angle), long * np.sin(angle)


def _shares(basis: AngleBasis, size: int) -> Any:
    """Return the solid angle of each of size² cells in each bin, sparse (bins, cells) [sr]."""
    from scipy.sparse import coo_array

    at = (np.arange(_POINTS) + 0.5) / _POINTS
    u, v = (g.ravel() for g in np.meshgrid(at, at, indexing="ij"))
    cell = (u * size).astype(np.int64) * size + (v * size).astype(np.int64)
    place = (basis.bin_of(*_disk(u, v)), cell)
    each = np.full(len(u), np.pi / len(u))
    return coo_array((each, place), shape=(basis.count, size * size)).tocsr()


def _anisotropic(cells: NDArray[np.float64], basis: AngleBasis) -> NDArray[np.float64]:
    size = cells.shape[0]
    share = _shares(basis, size)
    solid = np.asarray(share.sum(axis=1))
    pairs = cells.reshape(size * size, size * size)
    return _spread(share @ pairs / solid[:, None], share, solid, basis)


def _spread(rows: NDArray, share: Any, solid: NDArray, basis: AngleBasis) -> NDArray[np.float64]:
    """Return the mean in outgoing bins of rows (i, cells), each row's energy as it is."""
    value = (share @ rows.T).T / solid
    energy, kept = np.pi * rows.mean(axis=1), value @ basis.projected
    return value * np.where(kept > 0, energy / np.maximum(kept, 1e-300), 0.0)[:, None]


def _isotropic(cells: NDArray[np.float64], basis: AngleBasis) -> NDArray[np.float64]:
    size = cells.shape[0]
    share = _shares(basis, size)
    leaving = _spread(cells.reshape(size, -1), share, np.asarray(share.sum(axis=1)), basis)
    low, high = basis.sin2_edge[:-1, None], basis.sin2_edge[1:, None]
    sine = np.sqrt(low + (high - low) * (np.arange(64) + 0.5) / 64)
    row = np.minimum(((0.5 - 0.5 * sine) * size).astype(np.int64), max(size // 2 - 1, 0))
    return leaving[row].mean(axis=1)
