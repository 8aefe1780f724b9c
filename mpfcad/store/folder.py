"""Where the store lies."""

import os
from pathlib import Path

VARIABLE = "MPFCAD_CACHE"


def cache_folder() -> Path:
    """Return the folder that outlives a run: `MPFCAD_CACHE`, or the user's cache folder.

    It is not beside an export: an interrupted run leaves nothing there, and exports that are only
    verified may be write-protected.
    """
    given = os.environ.get(VARIABLE)
    if given:
        return Path(given)
    from platformdirs import user_cache_path

    return user_cache_path("mpfcad", appauthor=False)
