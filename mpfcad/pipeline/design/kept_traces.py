"""The traces that a design has done so far, kept on disk so that none is done twice."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.design import Traced
from mpfcad.export import canonical_json, write_text


def trace_seed(seed: int, number: int) -> int:
    """Return the seed of trace `number`; no two designs or traces share paths."""
    state = np.random.SeedSequence([seed, number]).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


class KeptTraces:
    """The traces done so far, in a file that is whole at any moment."""

    def __init__(self, path: Path, key: str) -> None:
        self._path, self._key = path, key
        self._traces: list[dict[str, Any]] = []
        try:
            kept = json.loads(path.read_bytes())
            self._traces = kept["traces"] if kept["key"] == key else []
        except (OSError, ValueError, KeyError, TypeError):
            pass

    def find(self, number: int, rows: NDArray[np.float64], shift: float) -> Traced | None:
        """Return the kept trace of a number, if it was of the same rows and shift [mm]."""
        wanted = [number, list(map(float, rows)), shift]
        for kept in self._traces:
            if [kept["number"], kept["rows"], kept.get("shift_mm", 0.0)] == wanted:
                coefficient = tuple(kept["traced"]["coefficient"])
                return Traced(**{**kept["traced"], "coefficient": coefficient})
        return None

    def keep(self, number: int, rows: NDArray[np.float64], shift: float, traced: Traced) -> None:
        """Add a trace and have it on the disk."""
        entry = {
            "number": number,
            "rows": list(map(float, rows)),
            "shift_mm": shift,
            "traced": asdict(traced),
        }
        self._traces.append(entry)
        self._path.parent.mkdir(parents=True, exist_ok=True)
        part = self._path.with_name(self._path.name + ".part")
        write_text(part, canonical_json({"key": self._key, "traces": self._traces}))
        part.replace(self._path)
