"""What the pipeline tells while it works; the command line shows it, tests ignore it."""

from typing import Protocol

from mpfcad.measure import TraceState


class Progress(Protocol):
    """Someone who wants to know how far the work is."""

    def stage(self, text: str) -> None:
        """Say that a new stage of the work begins."""

    def trace(self, state: TraceState) -> None:
        """Say how far a trace is."""

    def note(self, text: str) -> None:
        """Say something that the user ought to know although the work goes on."""


class Silent:
    """Progress that nobody watches."""

    def stage(self, text: str) -> None:
        """Say nothing."""

    def trace(self, state: TraceState) -> None:
        """Say nothing."""

    def note(self, text: str) -> None:
        """Say nothing."""


SILENT = Silent()
