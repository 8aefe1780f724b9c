"""`python -m tests.kill`: four hundred kills of five commands; it ends at the first fault."""

import argparse
import os
import sys
import tempfile
from pathlib import Path

from mpfcad.store import kernel_hash

from .attack import COMMANDS, attack


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


def main() -> int:
    """Kill, and print a line a command."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=80, help="kills before its end, a command")
    parser.add_argument("--seconds", type=float, default=1e9, help="at most, a command")
    parser.add_argument("--seed", type=int, default=4)
    parser.add_argument("--only", default="", help="names of commands, separated by commas")
    given = parser.parse_args()
    # Compiled once for all commands, whose kept work begins from nothing.
    kernels = Path(tempfile.gettempdir()) / f"mpfcad-kernels-{kernel_hash()[:16]}"
    os.environ.setdefault("NUMBA_CACHE_DIR", str(kernels))
    for command in COMMANDS:
        if given.only and command not in given.only.split(","):
            continue
        with tempfile.TemporaryDirectory() as folder:
            sent, hits = attack(
                Path(folder), command, given.count, given.seed, given.seconds, _tell
            )
        print(f"{command:<8} {sent:>4} kills, {hits:>4} before its end, none mixed", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
