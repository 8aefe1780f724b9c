"""Who is told what a user ought to know although the work goes on."""

import sys
from collections.abc import Callable

#: Called with one line each; without any the line goes to stderr.
listeners: list[Callable[[str], None]] = []


def say(text: str) -> None:
    """Tell all listeners, or stderr."""
    for listener in listeners:
        listener(text)
    if not listeners and sys.stderr is not None:
        print(f"mpfcad: {text}", file=sys.stderr, flush=True)
