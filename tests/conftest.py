"""Keeps compiled kernels between runs, in the way that the package does, but apart from the user's.

The package's own kernels are kept under the text of all kernels. The tests' own are kept with them,
but that key does not hold their text: so the folder is named for the text of both.
"""

import hashlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from hypothesis import settings

from mpfcad.store import kernel_hash

_HERE = Path(__file__).parent


def _kernels() -> str:
    digest = hashlib.sha256(kernel_hash().encode())
    for path in sorted(_HERE.rglob("*.py")):
        if b"njit" in (source := path.read_bytes()):
            digest.update(source)
    return digest.hexdigest()[:16]


_KERNELS = Path(tempfile.gettempdir()) / f"mpfcad-kernels-{_kernels()}"
os.environ["NUMBA_CACHE_DIR"] = str(_KERNELS)

# What is kept of finished work goes into a folder of this test run, never into the user's.
_CACHE = tempfile.TemporaryDirectory(prefix="mpfcad-cache-")
os.environ["MPFCAD_CACHE"] = _CACHE.name

# A first call compiles kernels: no time limit for one example. Fixed examples: same run, same
# result.
settings.register_profile("kernels", deadline=None, derandomize=True)
settings.load_profile("kernels")


def pytest_sessionstart(session):
    """Compile most kernels before the first parallel run, or each worker would for itself."""
    leads = getattr(session.config.option, "dist", "no") != "no"
    if leads and not _KERNELS.exists() and not session.config.option.collectonly:
        command = [sys.executable, str(_HERE / "warm.py")]
        for part in [subprocess.Popen([*command, number]) for number in "01"]:
            part.wait()
