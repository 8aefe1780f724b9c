"""The operators of a backlight's two-scale model, kept in the store: estimated once."""

import io
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.design import Grid, Operators, estimate_operators
from mpfcad.film import Groove, Profile
from mpfcad.store import Store, work_key

_KIND = "design"
#: What the two parts of the sparse T are called in a file.
_SPARSE = ("world_data", "world_indices", "world_indptr")


def model_operators(
    store: Store,
    stack: Stack,
    groove: Groove,
    base: float,
    profile: Profile,
    node: NDArray[np.float64],
    *,
    grid: Grid,
    seed: int,
    threads: int,
    progress: Callable[[str], None],
) -> Operators:
    """Return the operators of `estimate_operators`, from the store if they are there.

    The key holds all of its arguments by value but `threads`, on which they do not depend.
    """
    inputs = [stack, stack.files(), groove, base, profile, node, grid, seed]
    key = work_key(_KIND, ["operators", *inputs])
    kept = store.read(_KIND, key, lambda content: _decoded(content, grid))
    if kept is not None:
        return kept
    found = estimate_operators(
        stack, groove, base, profile, node,
        grid=grid, seed=seed, threads=threads, progress=progress,
    )  # fmt: skip
    store.write(_KIND, key, _encoded(found))
    return found


def _encoded(operators: Operators) -> bytes:
    world = operators.world
    content = io.BytesIO()
    np.savez(
        content,
        node=operators.node,
        film=operators.film,
        radiance=operators.radiance,
        meter=operators.meter,
        count=np.array([operators.passages, operators.segments]),
        **dict(zip(_SPARSE, (world.data, world.indices, world.indptr), strict=True)),
    )
    return content.getvalue()


def _decoded(content: bytes, grid: Grid) -> Operators:
    from scipy.sparse import csr_array

    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        value = dict(stored)
    size = len(value["radiance"])
    world = csr_array(tuple(value[name] for name in _SPARSE), shape=(size, size))
    passages, segments = (int(number) for number in value["count"])
    return Operators(
        grid, value["node"], value["film"], world, value["radiance"], value["meter"],
        passages, segments,
    )  # fmt: skip
