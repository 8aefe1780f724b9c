"""Who is told how far the work is: nobody, the terminal or notebook, or the caller's own."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mpfcad.pipeline import Progress


@contextmanager
def watched(progress: "bool | Progress") -> Iterator["Progress"]:
    """Give a progress: lines on stderr (True), none (False), or the one handed in."""
    from mpfcad.pipeline import SILENT

    if progress is True:
        from mpfcad.cli.terminal import Terminal

        with Terminal() as terminal:
            yield terminal
    else:
        yield progress or SILENT
