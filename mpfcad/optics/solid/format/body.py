"""What a file of solids holds: bodies of corners and facets, and what was understood."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Body:
    """One body as it stands in a file.

    Attributes
    ----------
    name
        as the file calls it
    corner
        (n, 3, 3) float64 [mm], three corners a facet
    """

    name: str
    corner: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A file's bodies.

    Attributes
    ----------
    kind
        the format in words
    body
        one or more
    single
        whether coordinates are float32 numbers, or were once
    note
        what was left out or converted, a sentence each
    """

    kind: str
    body: tuple[Body, ...]
    single: bool = False
    note: tuple[str, ...] = ()
