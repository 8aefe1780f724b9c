"""The key of a piece of work: a hash of everything that it depends on, by value."""

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.store.code import all_versions, work_hash


def work_key(kind: str, inputs: Any) -> str:
    """Return the SHA-256 of a kind of work, its inputs by value, its code and the libraries."""
    return value_hash([kind, inputs, work_hash(kind), all_versions()])


def array_hash(values: Any) -> str:
    """Return the SHA-256 of arrays and numbers in nested tuples: all that kernels read."""
    return value_hash(values)


def value_hash(value: Any) -> str:
    """Return the SHA-256 of a value and all that is in it.

    Known are numbers, text, arrays, containers, dataclasses, pydantic models, files (a `Path`
    counts by its content) and plain objects by their attributes. The type counts too.

    Raises
    ------
    TypeError
        for a function or a module: what they do is not in their value.
    """
    digest = hashlib.sha256()
    _add(digest, value)
    return digest.hexdigest()


def _add(digest: Any, value: Any) -> None:
    name = type(value).__qualname__
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        _put(digest, name, repr(value).encode())
    elif isinstance(value, np.ndarray | np.generic):
        array = np.asarray(value)
        if array.dtype.hasobject:
            _add_parts(digest, name, array.tolist())
        else:
            _put(digest, f"{array.dtype.str}{array.shape}", array.tobytes())
    elif isinstance(value, Path):
        is_file = value.is_file()
        _put(digest, "file" if is_file else "path", _content(value) if is_file else bytes(value))
    elif isinstance(value, Enum):
        _put(digest, name, value.name.encode())
    elif isinstance(value, Mapping):
        pairs = sorted((value_hash(key), value_hash(entry)) for key, entry in value.items())
        _add_parts(digest, "mapping", [text for pair in pairs for text in pair])
    elif isinstance(value, set | frozenset):
        _add_parts(digest, "set", sorted(map(value_hash, value)))
    elif isinstance(value, list | tuple):
        _add_parts(digest, name, value)
    else:
        _add_object(digest, f"{type(value).__module__}.{name}", value)


def _add_object(digest: Any, name: str, value: Any) -> None:
    if is_dataclass(value) and not isinstance(value, type):
        _put(digest, name, b"")
        _add(digest, {f.name: getattr(value, f.name) for f in fields(value)})
    elif hasattr(value, "model_dump"):
        _put(digest, name, b"")
        _add(digest, value.model_dump())
    elif callable(value) or not hasattr(value, "__dict__"):
        raise TypeError(f"{name}: cannot be part of a key: what it does is not in its value")
    else:
        _put(digest, name, b"")
        _add(digest, vars(value))


def _add_parts(digest: Any, name: str, parts: Any) -> None:
    _put(digest, name, b"%d" % len(parts))
    for part in parts:
        _add(digest, part)


def _put(digest: Any, name: str, content: bytes) -> None:
    digest.update(f"{name} {len(content)}\n".encode() + content)


def _content(path: Path) -> bytes:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").digest()
