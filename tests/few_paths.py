"""What tests of many runs share: traces of as few paths as can be."""

from collections.abc import Iterator
from contextlib import contextmanager
from unittest import mock

from mpfcad.measure import flux, rounds
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting


@contextmanager
def few_paths() -> Iterator[None]:
    """Trace two blocks a figure at effort `quick`: files and memory are looked at, not light."""
    with (
        mock.patch.dict(TRACE_SETTINGS, quick=TraceSetting(1.0, 20_000)),
        mock.patch.object(flux, "_ENERGY_BLOCKS", 4),
        mock.patch.object(rounds, "LEAST_PATHS", 1),
    ):
        yield
