"""Somebody who is told how far a long file is."""

from collections.abc import Callable

#: Takes the share, 0…1, of a long file that is done.
Told = Callable[[float], None]


def untold(share: float) -> None:
    """Tell nobody."""
