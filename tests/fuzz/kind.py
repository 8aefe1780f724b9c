"""A reader under test."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Reader:
    """A reader: the suffix of its files, what it does with one, and files to begin from.

    `native` says that a library in C++ reads, which a file may make crash: such a reader runs in a
    process of its own; `apart` that the program reads it so as well, so that a crash, or no end, is
    a refusal. `costly` readers take longer than some milliseconds a file. `named` is the name that
    a refusal has to say, where it is not the file's.
    """

    name: str
    suffix: str
    read: Callable[[Path], object]
    files: tuple[bytes, ...] | Callable[[], tuple[bytes, ...]]
    native: bool = False
    apart: bool = False
    costly: bool = False
    named: str = ""

    @property
    def seeds(self) -> tuple[bytes, ...]:
        """The files to begin from; some are only made when they are asked for."""
        return self.files() if callable(self.files) else self.files
