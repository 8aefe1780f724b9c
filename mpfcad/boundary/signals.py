"""Signals that end the program wait while something short is done whole."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def signals_wait() -> Iterator[None]:
    """Have Ctrl-C and SIGTERM wait until the block ends; then the first that came does its work.

    Signals come to the main thread alone: in another, nothing is changed.

    Examples
    --------
    >>> with signals_wait():
    ...     pass
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    kinds = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(kind, lambda number, frame: came.append(number)) for kind in kinds]
    try:
        yield
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler or signal.SIG_DFL)
        if came:
            signal.raise_signal(came[0])
