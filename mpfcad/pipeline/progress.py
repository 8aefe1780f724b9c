"""What the pipeline tells while it works; the command line shows it, tests ignore it."""

from typing import Protocol


class Progress(Protocol):
    """Someone who wants to know how far the work is."""

    def stage(self, text: str) -> None:
        """Say that a new stage of the work begins."""

    def trace(self, paths: int, half_width: float) -> None:
        """Say how many paths are traced and the contrast's 95 % half-width so far."""


class Silent:
    """Progress that nobody watches."""

    def stage(self, text: str) -> None:
        """Say nothing."""

    def trace(self, paths: int, half_width: float) -> None:
        """Say nothing."""


SILENT = Silent()
