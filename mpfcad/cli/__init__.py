"""The command line: one file a subcommand, and the exit codes.

0 PASS or MARGINAL, 1 FAIL or INCONCLUSIVE (of a verdict, or of a file that was made), 2 bad input,
3 what nobody foresaw, 4 `verify` found an export changed, 130 interrupted. Every error is one line
on stderr; `--debug` or MPFCAD_DEBUG=1 adds the traceback. Nothing heavy is imported before a
subcommand needs it, so that `--help` is instant.
"""

import errno
import os
import signal
import sys

from mpfcad.cli.app import app, debug_wanted
from mpfcad.cli.stream import end_streams, one_line, prepare_streams

__all__ = ["app", "main"]

_TERMINATED = 128 + signal.SIGTERM
#: What the system says of a path that it cannot follow.
_OF_PATHS = (errno.ENAMETOOLONG, errno.ELOOP, errno.EACCES)


def main() -> None:
    """Run the command line and exit with its code."""
    signal.signal(signal.SIGTERM, _stop)
    signal.signal(signal.SIGINT, _stop)
    output = prepare_streams()
    _silence_libraries()
    code = run_app(sys.argv[1:])
    failed = end_streams(output)
    if failed is not None:
        code = _fail(f"standard output: {failed.strerror}: what was to be printed is lost", 3)
    sys.exit(code)


def _silence_libraries() -> None:
    """Keep what libraries say of a damaged file off standard error: there is one line about it."""
    import logging
    import warnings

    logging.lastResort = logging.NullHandler()
    if not sys.warnoptions and not debug_wanted():
        warnings.simplefilter("ignore")


def run_app(arguments: list[str]) -> int:
    """Return the exit code of `mpfcad ARGUMENTS`."""
    try:
        code = app(arguments, prog_name="mpfcad", standalone_mode=False) or 0
        # Typer turns Ctrl-C into this code; older ones raise their own Abort.
        return _stopped("interrupted", 130) if code == 130 else code
    except BaseException as error:
        if debug_wanted() and not isinstance(error, SystemExit):
            import traceback

            traceback.print_exc()
        return _exit_code(error)


_signals: list[int] = []


def _stop(number: int, frame: object) -> None:
    """End the work, so that what is half-written is removed; a second signal does not end that."""
    for one in (signal.SIGINT, signal.SIGTERM):
        signal.signal(one, signal.SIG_IGN)
    _signals.append(number)
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(128 + number)


def _exit_code(error: BaseException) -> int:
    """Print one line for `error` and return the exit code it stands for."""
    from mpfcad.errors import ExportError, InputError

    if signal.SIGINT in _signals and not isinstance(error, SystemExit):
        # A library's import that is interrupted raises an error of its own.
        return _stopped("interrupted", 130)
    if isinstance(error, SystemExit) and error.code == _TERMINATED:
        return _stopped("terminated", _TERMINATED)
    if isinstance(error, SystemExit):
        return error.code if isinstance(error.code, int) else int(error.code is not None)
    if isinstance(error, KeyboardInterrupt) or type(error).__name__ == "Abort":
        return _stopped("interrupted", 130)
    if isinstance(error, InputError):
        return _fail(str(error), 2)
    if isinstance(error, ExportError):
        return _fail(str(error), 1)
    if hasattr(error, "format_message"):  # what typer raises on wrong usage
        message = error.format_message().replace(": Value error, ", ": ")
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "mpfcad"
        return _fail(f"{message} (see {command} --help)", 2)
    if isinstance(error, OSError) and error.errno in _OF_PATHS and error.filename is not None:
        # Of a name that was typed, wherever it is asked for first.
        name = os.fsdecode(error.filename)
        return _fail(f"{name}: {error.strerror}: expected a path that can be reached", 2)
    if isinstance(error, MemoryError):
        return _fail("out of memory", 3)
    return _fail(f"{type(error).__name__}: {error}", 3)


def _stopped(how: str, code: int) -> int:
    store = sys.modules.get("mpfcad.store.keep")
    kept = store is not None and store.is_work_kept()
    going = ": a trace goes on where it was when the same command is given again" if kept else ""
    return _fail(f"{how}{going}", code)


def _fail(line: str, code: int) -> int:
    print(f"mpfcad: {one_line(line)}", file=sys.stderr)
    return code
