"""`python -m tests.fuzz`: a long run over every reader; faults are written into a folder."""

import argparse
import hashlib
import sys
import tempfile
from pathlib import Path

from .reader import readers
from .run import TIME_LIMIT, fuzz, limit_memory


def main() -> int:
    """Run and print a line a reader; exit code 1 when a reader failed at a file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=80_000, help="files a reader")
    parser.add_argument("--seconds", type=float, default=3600.0, help="at most, a reader")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="names of readers, separated by commas")
    parser.add_argument("--keep", type=Path, default=Path("fuzz-faults"), help="folder of faults")
    given = parser.parse_args()
    limit_memory()
    total, failed = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for reader in readers():
            if given.only and reader.name not in given.only.split(","):
                continue
            tally = fuzz(reader, given.count, given.seed, Path(folder), given.seconds)
            total += tally.read + tally.refused + tally.crashed + len(tally.faults)
            failed += len(tally.faults)
            print(
                f"{reader.name:<15}{tally.read:>8} read {tally.refused:>8} refused "
                f"{tally.crashed:>4} crashed {tally.outcomes:>5} outcomes "
                f"{len(tally.faults):>5} faults, "
                f"slowest {tally.slowest:.2f} s",
                flush=True,
            )
            slow = [("slow", tally.slowest_file)] if tally.slowest > TIME_LIMIT / 3 else []
            for text, data in tally.faults + slow:
                given.keep.mkdir(exist_ok=True)
                name = f"{reader.name}-{hashlib.sha256(data).hexdigest()[:8]}"
                (given.keep / f"{name}{reader.suffix}").write_bytes(data)
                (given.keep / f"{name}.txt").write_text(text, "utf-8", "backslashreplace")
    print(f"{total} files, {failed} faults")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
