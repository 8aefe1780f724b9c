"""The traces that a design has done so far, each in the store so that none is done twice."""

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.design import Traced
from mpfcad.store import Store, work_key

_KIND = "design"


def trace_seed(seed: int, number: int) -> int:
    """Return the seed of trace `number`; no two designs or traces share paths."""
    state = np.random.SeedSequence([seed, number]).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


class KeptTraces:
    """The traces of designs whose films, stacks and settings are `inputs`, by value."""

    def __init__(self, store: Store, inputs: Any) -> None:
        self._store, self._inputs = store, inputs

    def _key(self, number: int, rows: NDArray[np.float64], shift: float) -> str:
        return work_key(_KIND, [self._inputs, number, np.asarray(rows, float), float(shift)])

    def find(self, number: int, rows: NDArray[np.float64], shift: float) -> Traced | None:
        """Return the kept trace of a number, if it was of the same rows and shift [mm]."""
        kept = self._store.read_json(_KIND, self._key(number, rows, shift))
        if kept is None:
            return None
        return Traced(**{**kept, "coefficient": tuple(kept["coefficient"])})

    def keep(self, number: int, rows: NDArray[np.float64], shift: float, traced: Traced) -> None:
        """Add a trace and have it on the disk."""
        self._store.keep_json(_KIND, self._key(number, rows, shift), asdict(traced))
