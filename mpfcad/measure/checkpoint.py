"""Half-done traces in the store: what an interrupted trace has tallied, so that it can go on.

A checkpoint is written after each round under the key of everything that the tally depends on: the
mesh's bytes, the scene's numbers, the meter, the seed, the goal, and the code. Floats are kept bit
for bit and rounds are always the same, so a trace that goes on ends with the same bits as one that
was never interrupted.
"""

import io
from typing import Any, Protocol, TypeVar

import numpy as np

from mpfcad.store import Store

_KIND = "trace"
Rows = list[tuple[float, ...]]


class Sums(Protocol):
    """A tally: a named tuple of arrays and whole numbers."""

    @property
    def total_paths(self) -> int:
        """Paths that were traced."""

    @property
    def blocks(self) -> int:
        """Blocks of equal size that they make."""

    def _asdict(self) -> dict[str, Any]: ...


AnyTally = TypeVar("AnyTally", bound=Sums)


class Checkpoints:
    """The checkpoints of one piece of work, in a store; without one nothing is kept.

    As a context manager it removes them when the work ends well, and leaves them otherwise: it is
    opened around all that is made of the traces, until that is on the disk.
    """

    def __init__(self, store: Store | None = None) -> None:
        self._store = store or Store()
        self._used: set[str] = set()

    def __enter__(self) -> "Checkpoints":
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            for case in self._used:
                self._store.drop(_KIND, case)

    def read(self, case: str, tally: type[AnyTally]) -> tuple[AnyTally, Rows] | None:
        """Return tally and earlier rounds of a case by its key; None where none verifies.

        `tally` is the kind of tally. Of each round its paths, and a figure with its interval
        (`rounds.Trail`).
        """
        found = self._store.read(_KIND, case, lambda content: _decoded(content, tally))
        if found is not None:
            self._used.add(case)
        return found

    def write(self, case: str, tally: Sums, rounds: Rows) -> None:
        """Keep the tally of a case's blocks so far, and what its earlier rounds gave."""
        self._used.add(case)
        content = io.BytesIO()
        np.savez(content, **tally._asdict(), rounds=np.array(rounds, float).reshape(-1, 4))
        self._store.write(_KIND, case, content.getvalue())


def _decoded(content: bytes, tally: type[AnyTally]) -> tuple[AnyTally, Rows]:
    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        values = dict(stored)
    rounds = [tuple(row) for row in values.pop("rounds").tolist()]
    counts = {name: value.item() for name, value in values.items() if value.ndim == 0}
    return tally(**{**values, **counts}), rounds
