"""Keeps compiled kernels in the store, under the text of all kernels.

numba's own cache looks at the file of the compiled function only, not at what that calls: after an
edit below it the old code would still run. Here the key holds the text of every kernel file, the
processor, and the versions of numba and LLVM.
"""

import os
import pickle
from importlib.metadata import version
from pathlib import Path
from typing import Any

from mpfcad.store.code import kernel_hash
from mpfcad.store.digest import value_hash
from mpfcad.store.folder import cache_folder
from mpfcad.store.keep import Store

#: Kernels may lie elsewhere than the rest of the store.
KERNEL_VARIABLE = "NUMBA_CACHE_DIR"
_STORES: dict[Path, Store] = {}


def kernel_folder() -> Path:
    """Return where kernels are kept: `NUMBA_CACHE_DIR`, or the user's store."""
    given = os.environ.get(KERNEL_VARIABLE)
    return Path(given) if given else cache_folder()


def kernel_store() -> Store:
    """Return the store of the kernels."""
    folder = kernel_folder()
    return _STORES.setdefault(folder, Store(folder))


class KernelCache:
    """Has one function's compiled versions in the store; numba's dispatcher asks it for them."""

    def __init__(self, function: Any, flavour: str = "") -> None:
        self._name = f"{function.__module__}.{function.__qualname__} {flavour}"

    @property
    def cache_path(self) -> str:
        """Folder of the kernels."""
        return str(kernel_store().folder)

    def _key(self, signature: Any, codegen: Any) -> str:
        made = [version("numba"), version("llvmlite"), repr(codegen.magic_tuple())]
        return value_hash(["kernel", self._name, repr(signature), kernel_hash(), made])

    def load_overload(self, signature: Any, target_context: Any) -> Any:
        """Return the compiled version for a signature, or None."""
        from numba.core.compiler import CompileResult

        target_context.refresh()
        key = self._key(signature, target_context.codegen())

        def decode(content: bytes) -> Any:
            return CompileResult._rebuild(target_context, *pickle.loads(content))

        return kernel_store().read("kernel", key, decode)

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep a compiled version."""
        from numba.core.serialize import dumps

        if result.lifted or result.library.has_dynamic_globals:
            return
        key = self._key(signature, result.codegen)
        kernel_store().write("kernel", key, dumps(result._reduce()))

    def enable(self) -> None:
        """Do nothing: it is always on."""

    def disable(self) -> None:
        """Do nothing: it is always on."""

    def flush(self) -> None:
        """Do nothing: `mpfcad cache --prune` removes what is old."""


def is_numba_as_expected() -> bool:
    """Tell whether numba has inside what `KernelCache` uses."""
    try:
        from numba.core.codegen import CPUCodegen
        from numba.core.compiler import CompileResult
        from numba.core.dispatcher import Dispatcher
        from numba.core.serialize import dumps
    except ImportError:
        return False
    return (
        hasattr(CompileResult, "_reduce")
        and hasattr(CompileResult, "_rebuild")
        and hasattr(CPUCodegen, "magic_tuple")
        and hasattr(Dispatcher, "enable_caching")
        and callable(dumps)
    )


def kept(compiled: Any, flavour: str = "") -> Any:
    """Keep what numba compiles of a function; where its insides are unknown, in its own cache.

    Above `njit`, without `cache=True`. `flavour` is how the kernels that it calls are compiled.
    """
    if is_numba_as_expected():
        compiled._cache = KernelCache(compiled.py_func, flavour)
        return compiled
    from numba import config

    before = config.CACHE_DIR
    config.CACHE_DIR = str(kernel_folder() / "numba" / f"{kernel_hash()[:16]}{flavour}")
    try:
        compiled.enable_caching()
    finally:
        config.CACHE_DIR = before
    return compiled
