"""Who is told that kernels are being compiled; to know it, nobody has to import what compiles.

`optics.kernel` tells. A kernel is compiled once on a machine and then loaded from numba's cache on
disk, of which nothing is told.
"""

from collections.abc import Callable

#: Called with the name of a function that is going to be compiled, and with None when it is done.
watchers: list[Callable[[str | None], None]] = []


def tell(name: str | None) -> None:
    """Tell all watchers what is being compiled."""
    for watcher in watchers:
        watcher(name)
