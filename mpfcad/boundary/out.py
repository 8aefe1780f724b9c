"""A file that the user asks for: refused before work where it cannot be, else whole or not at all.

What stands there already is replaced only when it is a file of the same kind.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mpfcad.errors import InputError


def refuse_file_above(path: Path, where: str = "") -> None:
    """Refuse a path that leads through a file.

    Raises
    ------
    InputError
        beginning with `where`, naming the path and the file.
    """
    for above in Path(path).absolute().parents:
        if above.exists():
            if not above.is_dir():
                raise InputError(f"{where}{path}: {above} is a file: expected a folder")
            return


def check_out(where: str, path: Path | None, beginnings: tuple[bytes, ...] = ()) -> None:
    """Refuse a file that cannot be written, or would replace one that is none of its kind.

    Parameters
    ----------
    where
        the option that names it
    path
        the file; None: none is asked for
    beginnings
        how files of its kind begin; without, any file is replaced

    Raises
    ------
    InputError
        naming the option and the file, before anything is written.
    """
    if path is None:
        return
    if path.is_dir():
        raise InputError(f"{where}: {path}: is a folder: expected a file")
    refuse_file_above(path, f"{where}: ")
    if not path.exists():
        return
    if not path.is_file():
        raise InputError(f"{where}: {path}: is a device or pipe: expected a file")
    try:
        with path.open("rb") as file:
            found = file.read(max((len(one) for one in beginnings), default=0))
    except OSError as error:
        raise InputError(f"{where}: {path}: cannot be read: {error.strerror or error}") from None
    if found and not found.startswith(beginnings):
        raise InputError(
            f"{where}: {path}: exists and is no such file: expected a new file, or an older one "
            "of this command"
        )


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


@contextmanager
def asked_file(path: Path) -> Iterator[Path]:
    """Give a name to write to as `whole_file`; its folder is made.

    Raises
    ------
    InputError
        when the system does not take the file.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:
            yield part
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from None
