"""Where half-done traces and finished cases are kept, so that interrupted work goes on."""

import os
from pathlib import Path

from mpfcad.measure import Checkpoints
from mpfcad.pipeline.progress import Progress

_VARIABLE = "MPFCAD_CACHE"


def cache_folder() -> Path:
    """Return the folder that outlives a run: `MPFCAD_CACHE`, or the user's cache folder.

    It is not beside an export: an interrupted run leaves nothing there, and exports that are only
    verified may be write-protected.
    """
    given = os.environ.get(_VARIABLE)
    if given:
        return Path(given)
    from platformdirs import user_cache_path

    return user_cache_path("mpfcad", appauthor=False)


def open_checkpoints(progress: Progress) -> Checkpoints:
    """Return the checkpoints of a piece of work; says so when none can be kept."""
    folder = cache_folder() / "trace"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError("read-only")
    except OSError as error:
        reason = error.strerror or error
        progress.note(f"{folder}: {reason}: an interrupted trace will start again ({_VARIABLE})")
        return Checkpoints()
    return Checkpoints(folder)
