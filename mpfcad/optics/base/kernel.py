"""How the kernels are compiled: one decorator for all of them, and one for the entries.

Division follows IEEE (a vanishing direction component gives an infinite distance, not an error),
and the arrays' reference counts are left alone: counting them at every call took over half of the
time. Kernels therefore allocate nothing; what they need as scratch is handed in.

A kernel is only called from compiled code. `gathered` compiles it in one piece with the entry that
calls it, by a compiler of numba's with two steps replaced. Where numba is not inside as that needs,
a kernel is a plain `njit` function: the same operations, hence the same bits, but it takes numba
twice as long to compile (39 s instead of 19 s of CPU).
"""

import os
from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core import event

from mpfcad.compiling import tell
from mpfcad.store.kernel import kept
from mpfcad.store.notice import say

#: `plain` compiles kernels plainly whatever numba is like inside.
VARIABLE = "MPFCAD_KERNELS"
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False}


def _choose() -> Callable[[Any], Any] | None:
    """Return what compiles a kernel within its entry; None where numba does not allow it."""
    wanted = os.environ.get(VARIABLE, "") != "plain"
    try:
        from numba import __version__ as version

        from mpfcad.optics.base.gathered import gathered, trouble

        reason = trouble() if wanted else f"{VARIABLE}=plain"
    except Exception as error:  # an import from numba's inside, or what it does when defined
        reason = f"{type(error).__name__}: {error}"
    if not reason:
        return gathered
    say(
        f"numba {version} is not used from inside ({reason}): kernels are compiled plainly, which "
        "takes twice as long, once; the figures are the same"
    )
    return None


_gathered = _choose()
#: How kernels are compiled; part of the key under which they are kept.
FLAVOUR = "plain" if _gathered is None else "gathered"


def kernel(function: Callable) -> Any:
    """Compile a function that is only called from compiled ones."""
    if _gathered is None:
        return njit(**_OPTIONS)(function)
    return _gathered(function)


def entry(function: Callable) -> Any:
    """Compile a function that Python calls, with all kernels in it, and keep what comes of it."""
    return kept(njit(nogil=True, **_OPTIONS)(function), FLAVOUR)


def allocating_entry(function: Callable) -> Any:
    """Compile an entry that makes arrays of its own."""
    return kept(njit(nogil=True, error_model="numpy")(function), FLAVOUR)


class _Announcer(event.Listener):
    """Tells what numba compiles: not each kernel, but the entry that they are compiled for."""

    def __init__(self) -> None:
        self._depth = 0

    def on_start(self, compiling: event.Event) -> None:
        if self._depth == 0:
            tell(compiling.data["dispatcher"].py_func.__name__)
        self._depth += 1

    def on_end(self, compiling: event.Event) -> None:
        self._depth -= 1
        if self._depth == 0:
            tell(None)


event.register("numba:compile", _Announcer())
