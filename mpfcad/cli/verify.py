"""`mpfcad verify`: hash every file of an export, then find its figures again from its files."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import Threads


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="An export of mpfcad run.")],
    threads: Threads = None,
) -> int:
    """Check every hash of an export, then trace its film again and compare bit for bit."""
    from mpfcad.cli.stream import one_line
    from mpfcad.cli.terminal import Terminal, print_verdict
    from mpfcad.errors import ExportError
    from mpfcad.pipeline import verify_export
    from mpfcad.record import exit_code

    try:
        with Terminal() as terminal:
            verification = verify_export(folder, threads=threads, progress=terminal)
    except ExportError as error:
        print(f"mpfcad: {one_line(str(error))}", file=sys.stderr)
        return 1
    print("verified: every hash holds, and the figures come out the same bit for bit")
    print_verdict(verification, folder)
    return exit_code(verification["verdict"])
