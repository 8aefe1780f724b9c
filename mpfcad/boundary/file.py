"""A file of the user's: of a size that can be read, and every fault in it one line.

A reader says what is wrong as far as it foresees it. `reads` holds it to that: what it did not
foresee (a library's own error, an impossible shape, a nesting too deep) is an `InputError` that
names the file as well.
"""

import functools
import os
import stat
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from mpfcad.errors import InputError, MpfcadError

Read = TypeVar("Read", bound=Callable[..., Any])

#: Largest table or text [bytes]; meshes and fields of curvature may be larger.
TEXT_LIMIT = 100_000_000
FILE_LIMIT = 8_000_000_000
_TOML_LIMIT = 10_000_000


def check_file(path: Path, limit: int = FILE_LIMIT, expected: str = "a file") -> None:
    """Refuse what is no regular file of at most `limit` bytes: a device or a pipe has no end.

    Raises
    ------
    InputError
        naming the file and what it is.
    """
    try:
        status = os.stat(path)  # noqa: PTH116 (also of what is no path on this system)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file: expected {expected}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read: {reason}: expected {expected}") from None
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "a device or pipe"
        raise InputError(f"{path}: is {kind}: expected {expected}")
    if status.st_size > limit:
        size, most = status.st_size / 1e6, limit / 1e6
        raise InputError(f"{path}: {size:.0f} MB: expected at most {most:.0f} MB")


@contextmanager
def guarded(where: object, expected: str, kind: type[MpfcadError] = InputError) -> Iterator[None]:
    """Have everything that goes wrong in a block be an error of a kind that begins with `where`.

    Raises
    ------
    InputError
        or `kind`, for any error but those of mpfcad's own, naming `where` and what was expected.
    """
    try:
        yield
    except (MpfcadError, ImportError):
        # An import that fails is none of the file's: not installed, or interrupted.
        raise
    except OSError as error:
        reason = error.strerror or error
        raise kind(f"{where}: cannot be read: {reason}: expected {expected}") from error
    except MemoryError as error:
        raise kind(f"{where}: does not fit the memory: expected {expected}") from error
    except RecursionError as error:
        raise kind(f"{where}: nested too deep: expected {expected}") from error
    except Exception as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
        raise kind(f"{where}: not readable ({reason}): expected {expected}") from error


def reason_of(error: Exception) -> str:
    """Return in one line what went wrong, without the path, which stands before it anyway."""
    if isinstance(error, OSError):
        return error.strerror or type(error).__name__
    if isinstance(error, UnicodeDecodeError):
        return f"no text in {error.encoding}"
    if isinstance(error, KeyError) and error.args:
        return f"no {error.args[0]} in it"
    return " ".join(str(error).split())[:120] or type(error).__name__


def named_file(where: str, folder: Path, name: str, expected: str, limit: int = FILE_LIMIT) -> Path:
    """Return the path of a file that a field names, beside the file that names it.

    Raises
    ------
    InputError
        when it is no file; the text begins with `where`: the naming file and the field.
    """
    path = folder / name
    try:
        check_file(path, limit, expected)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    return path


def reads(expected: str, limit: int = FILE_LIMIT) -> Callable[[Read], Read]:
    """Decorate a reader whose first argument is a file, or None for what is built in.

    `expected` says in words what should be in the file.
    """

    def decorate(reader: Read) -> Read:
        @functools.wraps(reader)
        def checked(path: Any, *arguments: Any, **options: Any) -> Any:
            if path is None:
                return reader(path, *arguments, **options)
            check_file(path, limit, expected)
            with guarded(path, expected):
                return reader(path, *arguments, **options)

        return checked  # type: ignore[return-value]

    return decorate


def read_toml(path: Path) -> dict[str, Any]:
    """Return what is in a TOML file, with or without a byte order mark.

    Raises
    ------
    InputError
        when it cannot be read, is no TOML (naming the line), or holds a number without end.
    """
    check_file(path, _TOML_LIMIT, "a TOML file")
    with guarded(path, "a TOML file"):
        try:
            table = tomllib.loads(Path(path).read_bytes().decode("utf-8-sig"))
        except UnicodeDecodeError as error:
            raise InputError(f"{path}: byte {error.start}: not UTF-8 text") from None
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"{path}: not TOML: {error}") from None
        _check_numbers(path, table, "")
        return table


def _check_numbers(path: Path, value: Any, field: str) -> None:
    """Refuse whole numbers that no float holds: all of them are lengths, counts or seeds."""
    if isinstance(value, dict):
        for key, entry in value.items():
            _check_numbers(path, entry, f"{field}.{key}" if field else key)
    elif isinstance(value, list):
        for number, entry in enumerate(value, 1):
            _check_numbers(path, entry, f"{field}[{number}]")
    elif type(value) is int and abs(value) >= 2**64:
        raise InputError(f"{path}: {field}: about 1e{_digits(value) - 1}: expected below 2^64")


def _digits(value: int) -> int:
    return round(value.bit_length() * 0.30103)
