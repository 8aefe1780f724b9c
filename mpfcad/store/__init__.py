"""One store of finished work: half-done traces, figures, sweep points, design traces, kernels.

An entry is one file, named by a key that is made of everything that its content depends on. It is
written whole, with a checksum, and what does not verify is said, set aside and computed again. So
the store saves time and never decides a figure: deleting it is always safe.
"""

from mpfcad.store.code import code_hash, kernel_hash, versions, work_hash
from mpfcad.store.digest import array_hash, value_hash, work_key
from mpfcad.store.folder import VARIABLE, cache_folder
from mpfcad.store.keep import Store

__all__ = [
    "VARIABLE",
    "Store",
    "array_hash",
    "cache_folder",
    "code_hash",
    "kernel_hash",
    "value_hash",
    "versions",
    "work_hash",
    "work_key",
]
