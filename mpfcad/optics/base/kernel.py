"""How the kernels are compiled: one decorator for all of them.

Division follows IEEE (a vanishing direction component gives an infinite distance, not an error),
and the arrays' reference counts are left alone: counting them at every call took over half of the
time. Kernels therefore allocate nothing; what they need as scratch is handed in.

A kernel is only ever inlined into what calls it, up to an entry (`engine.trace_paths`) that Python
calls. numba by itself would optimise and translate every kernel on the way there, with all that it
calls in it, once a level: more than half of the time that the tracer took to compile. So a kernel's
code is but gathered here, and the entry compiled as a whole. Nor is a kernel compiled anew where a
number in a call is a literal.
"""

from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core import event
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult
from numba.types import unliteral

from mpfcad.compiling import tell


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


_inlined = njit(
    error_model="numpy", _nrt=False, forceinline=True, no_cpython_wrapper=True,
    no_cfunc_wrapper=True, pipeline_class=_Inlined,
)  # fmt: skip


def kernel(function: Callable) -> Any:
    """Compile a function that is only called from compiled ones."""
    made = _inlined(function)
    typed = made.get_call_template
    made.get_call_template = lambda args, kws: typed(tuple(map(unliteral, args)), kws)
    return made
