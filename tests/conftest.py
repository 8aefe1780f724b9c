"""Keeps compiled kernels between runs, but never those of other sources.

numba's cache looks only at the file of the compiled function, not at what it calls: after a change
in `film.py` the cached `engine.trace_paths` would still hold the old film. So the cache's folder is
named for the text of all kernels: the files of `optics`, and all others that compile something.
"""

import hashlib
import os
import tempfile
from pathlib import Path

from hypothesis import settings

_HERE = Path(__file__).parent


def _kernels() -> str:
    package = _HERE.parent / "mpfcad"
    text = {p: p.read_bytes() for folder in (package, _HERE) for p in sorted(folder.rglob("*.py"))}
    digest = hashlib.sha256()
    for path, source in text.items():
        optics = path.is_relative_to(package / "optics")
        if optics or b"njit" in source or b"optics.base.kernel" in source:
            digest.update(source)
    return digest.hexdigest()[:16]


_KERNELS = Path(tempfile.gettempdir()) / f"mpfcad-kernels-{_kernels()}"
os.environ["NUMBA_CACHE_DIR"] = str(_KERNELS)

# What interrupted traces leave goes into a folder of this test run, never into the user's.
_CACHE = tempfile.TemporaryDirectory(prefix="mpfcad-cache-")
os.environ["MPFCAD_CACHE"] = _CACHE.name

# A first call compiles kernels: no time limit for one example. Fixed examples: same run, same
# result.
settings.register_profile("kernels", deadline=None, derandomize=True)
settings.load_profile("kernels")


def pytest_sessionstart(session):
    """Compile the tracer before the first parallel run, or each worker would for itself."""
    leads = getattr(session.config.option, "dist", "no") != "no"
    if leads and not _KERNELS.exists() and not session.config.option.collectonly:
        from mpfcad.optics.engine import compile_tracer

        compile_tracer()
