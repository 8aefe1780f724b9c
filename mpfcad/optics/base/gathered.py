"""Compiles a kernel in one piece with the entry that calls it, by what numba is inside.

A kernel is only ever inlined into what calls it, up to an entry (`engine.trace_paths`) that Python
calls. numba by itself would optimise and translate every kernel on the way there, with all that it
calls in it, once a level: more than half of the time that the tracer took to compile. So a kernel's
code is but gathered here, and the entry compiled as a whole. Nor is a kernel compiled anew where a
number in a call is a literal.
"""

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import llvmlite
import numba
from numba import njit
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.core.cpu import CPUContext
from numba.core.dispatcher import Dispatcher
from numba.core.options import DefaultOptions
from numba.types import unliteral

from mpfcad.store import kernel_hash, value_hash
from mpfcad.store.kernel import kernel_store

#: First and last version of numba that this was tried with.
TRIED = ((0, 61), (0, 68))
_PARTS: tuple[tuple[Any, tuple[str, ...]], ...] = (
    (JITCodeLibrary, ("finalize", "_get_module_for_linking", "enable_object_caching")),
    (Compiler, ("compile_extra",)),
    (CompileResult, ("_replace", "_fields")),
    (CPUContext, ("insert_user_function", "codegen")),
    (Dispatcher, ("get_call_template",)),
    (DefaultOptions, ("forceinline", "no_cpython_wrapper", "no_cfunc_wrapper", "_nrt")),
)
_PROBE = """
from numba import njit
from mpfcad.optics.base.gathered import gathered
inner = gathered(lambda x: 2.0 * x)
outer = njit(error_model="numpy", _nrt=False)(lambda x: inner(x) + 1.0)
assert outer(3.0) == 7.0
"""


class _Gathered(JITCodeLibrary):
    """The code of a kernel and of all that it calls, as it came from Python."""

    def finalize(self) -> None:
        """Take in the code of what is called, and leave all else to the entry."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


class _Inlined(Compiler):
    """numba's compiler up to the code, not to a function that could be called by itself."""

    def compile_extra(self, function: Callable) -> CompileResult:
        state = self.state
        state.flags.no_compile = True
        state.library = _Gathered(state.targetctx.codegen(), function.__qualname__)
        state.library.enable_object_caching()
        result = super().compile_extra(function)
        # numba knows an implementation by its built-in function. Each bound method is one of its
        # own, and this one is an error when Python calls it: nothing is in the dictionary.
        result = result._replace(entry_point={}.popitem)
        state.targetctx.insert_user_function(result.entry_point, result.fndesc, [result.library])
        return result


def gathered(function: Callable) -> Any:
    """Compile a function whose code is only inlined into that of an entry."""
    made = njit(
        error_model="numpy", _nrt=False, forceinline=True, no_cpython_wrapper=True,
        no_cfunc_wrapper=True, pipeline_class=_Inlined,
    )(function)  # fmt: skip
    typed = made.get_call_template
    made.get_call_template = lambda args, kws: typed(tuple(map(unliteral, args)), kws)
    return made


def trouble(version: str = numba.__version__) -> str | None:
    """Return why numba's inside is not as this module needs it; None where it is.

    A version that was not tried is tried once, in a process of its own, and that is kept.
    """
    for part, names in _PARTS:
        for name in names:
            if not hasattr(part, name):
                return f"{part.__name__} has no {name}"
    for name in ("_linking_libraries", "_final_module"):
        if name not in JITCodeLibrary.__init__.__code__.co_names:
            return f"JITCodeLibrary has no {name}"
    if TRIED[0] <= _number(version) <= TRIED[1]:
        return None
    key = value_hash(["trial", version, llvmlite.__version__, kernel_hash()])
    store = kernel_store()
    kept = store.read_json("kernel", key)
    if kept is None:
        kept = store.keep_json("kernel", key, {"trouble": _try()})
    return kept["trouble"]


def _number(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split(".")[:2] if part.isdigit())


def _try() -> str | None:
    """Return what goes wrong when a kernel is gathered and called, in a process of its own."""
    command = [sys.executable, "-c", _PROBE]
    tried = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    if tried.returncode == 0:
        return None
    last = tried.stderr.strip().splitlines()[-1:] or [f"exit code {tried.returncode}"]
    return f"a trial ends with {last[0][:100]}"
