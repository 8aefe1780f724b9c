"""Where files of the user's come in: of a size that can be read, and every fault one line."""

from mpfcad.boundary.file import (
    FILE_LIMIT,
    TEXT_LIMIT,
    check_file,
    guarded,
    named_file,
    read_toml,
    reads,
    reason_of,
)

__all__ = [
    "FILE_LIMIT",
    "TEXT_LIMIT",
    "check_file",
    "guarded",
    "named_file",
    "read_toml",
    "reads",
    "reason_of",
]
