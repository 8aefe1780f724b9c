"""How long to trace, in three words."""

import os
from dataclasses import asdict, dataclass
from typing import Any

#: A half-width that no trace reaches: it goes on to its path limit.
NO_GOAL = -1.0


@dataclass(frozen=True)
class TraceSetting:
    """When a trace ends: at `half_width_goal` of the contrast (95 %), or at `path_limit` paths."""

    half_width_goal: float
    path_limit: int

    def document(self) -> dict[str, Any]:
        """Return the setting as it stands in verification.json."""
        return asdict(self)


def available_threads() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


TRACE_SETTINGS = {
    "quick": TraceSetting(half_width_goal=0.004, path_limit=4_000_000),
    "standard": TraceSetting(half_width_goal=0.002, path_limit=40_000_000),
    "final": TraceSetting(half_width_goal=0.0007, path_limit=400_000_000),
}
