"""`python -m tests.forgery`: ten thousand forgeries of one export; exit code 1 when one passed."""

import argparse
import sys
import tempfile
from collections import Counter
from pathlib import Path

from .attack import attack, make_export, wrong


def main() -> int:
    """Forge, and print what was found and what passed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=1e9, help="at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, default=Path("forgery-faults"), help="what passed")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        export = make_export(Path(folder))
        original = {path.name: path.read_bytes() for path in export.iterdir()}
        original.pop("manifest.json")
        outcome = attack(export, given.count, given.seed, given.seconds)
    faults = 0
    kinds = Counter((way, *changed) for way, changed, _ in outcome.passed)
    for way, changed, forged in outcome.passed:
        fault = wrong(original, way, changed, forged)
        if fault:
            faults += 1
            print(f"passed: {fault}: {', '.join(changed)}")
            place = given.keep / f"{given.seed}-{faults}"
            place.mkdir(parents=True, exist_ok=True)
            for name in changed:
                (place / name).write_bytes(forged.get(name) or b"")
    print("found:", dict(sorted(outcome.found.items())))
    print("passed, and no figure, page or verdict changed:", dict(kinds))
    print(
        f"{outcome.unsigned} forgeries, {sum(outcome.found.values())} found without a key, "
        f"{faults} passed that must not, {outcome.by_signature} found by the signature; "
        f"examined anew {outcome.examined} times, traced anew {outcome.traced} times"
    )
    return int(faults > 0 or outcome.by_signature < outcome.unsigned)


if __name__ == "__main__":
    sys.exit(main())
