"""Keeps compiled kernels between runs, but never those of other sources.

numba's cache looks only at the file of the compiled function, not at what it calls: after a change
in `film.py` the cached `engine.trace_block` would still hold the old film. So the cache's folder is
named for the text of all kernels.
"""

import hashlib
import os
import tempfile
from pathlib import Path

from hypothesis import settings

_HERE = Path(__file__).parent


def _kernels() -> str:
    package = _HERE.parent / "mpfcad"
    sources = [*(package / "optics").glob("*.py"), package / "design" / "passage.py"]
    sources.append(_HERE / "harness.py")
    text = b"".join(path.read_bytes() for path in sorted(sources))
    return hashlib.sha256(text).hexdigest()[:16]


os.environ["NUMBA_CACHE_DIR"] = str(Path(tempfile.gettempdir()) / f"mpfcad-kernels-{_kernels()}")

# What interrupted traces leave goes into a folder of this test run, never into the user's.
_CACHE = tempfile.TemporaryDirectory(prefix="mpfcad-cache-")
os.environ["MPFCAD_CACHE"] = _CACHE.name

# A first call compiles kernels: no time limit for one example. Fixed examples: same run, same
# result.
settings.register_profile("kernels", deadline=None, derandomize=True)
settings.load_profile("kernels")
