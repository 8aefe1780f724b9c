"""A file that appears whole or not at all."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

#: Somebody who is told the share, 0…1, of a long file that is done.
Told = Callable[[float], None]


def untold(share: float) -> None:
    """Tell nobody."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a name to write to; the file becomes `path` when the block ends well, else it is gone.

    Its bytes are on the disk before it takes its name, so neither a full disk nor a kill leaves a
    part of a file there.
    """
    part = path.with_name(f".{path.name}.part-{os.getpid()}")
    try:
        yield part
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
