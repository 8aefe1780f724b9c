"""Standard streams that a reader may close, that are closed from the start, or know few signs."""

import errno
import os
import sys
from contextlib import suppress
from typing import Any

from mpfcad.cli.character import register_handler

#: Longest line about an error, with its `mpfcad: `.
LINE_LIMIT = 300


def one_line(text: str, limit: int = LINE_LIMIT - len("mpfcad: ")) -> str:
    """Return text on one line without control characters, its middle cut where it is too long."""
    line = "".join(c if c.isprintable() else _escaped(c) for c in " ".join(text.split()))
    if len(line) <= limit:
        return line
    tail = limit // 3
    return f"{line[: limit - tail - 5]} […] {line[-tail:]}"


def _escaped(sign: str) -> str:
    if ord(sign) < 128:
        return repr(sign)[1:-1]
    return sign.encode("ascii", "backslashreplace").decode()


class Stream:
    """A text stream whose reader may go away: what is written after that is dropped.

    `failed` is the error when it could not be written for another reason (a full disk).
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self._gone = False
        self.failed: OSError | None = None

    def write(self, text: str) -> int:
        """Write text, or drop it when nobody reads."""
        self._try(self._stream.write, text)
        return len(text)

    def flush(self) -> None:
        """Write out what waits."""
        self._try(self._stream.flush)

    def _try(self, act: Any, *arguments: Any) -> None:
        if self._gone or self.failed:
            return
        try:
            act(*arguments)
        except BrokenPipeError:
            self._gone = True
        except ValueError:  # closed meanwhile
            self._gone = True
        except OSError as error:
            # Windows says EINVAL where a pipe's reader has gone.
            self._gone = error.errno in (errno.EPIPE, errno.EINVAL, errno.EBADF)
            self.failed = None if self._gone else error

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def prepare_streams() -> Stream:
    """Make standard output and error safe to write; return the output.

    A descriptor that is closed is opened on the null device: else the next file that is opened,
    one of an export, would take its number, and what a library prints would go into it.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    handler = register_handler()
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            stream = open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123, SIM115
        with suppress(AttributeError, ValueError):
            # A sign that the stream's encoding lacks gets a plain stand-in.
            stream.reconfigure(errors=handler)
        if not isinstance(stream, Stream):
            setattr(sys, name, Stream(stream))
    return sys.stdout  # type: ignore[return-value]


def end_streams(output: Stream) -> OSError | None:
    """Write out what waits; return what kept the output from being written."""
    for stream in (output, sys.stderr):
        with suppress(Exception):
            stream.flush()
    if output._gone or output.failed:
        # The interpreter writes out what waits once more when it ends, and would fail at it.
        with suppress(OSError, AttributeError, ValueError):
            null = os.open(os.devnull, os.O_WRONLY)
            os.dup2(null, output._stream.fileno())
            os.close(null)
    return output.failed
