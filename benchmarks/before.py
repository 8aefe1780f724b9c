"""Commands of this version beside those of another source tree, by turns, in CPU seconds.

`python benchmarks/before.py TREE [--repeat N] [--only NAME] [--json]`. TREE holds another version's
sources (`git worktree add --detach TREE COMMIT`), which this interpreter can run: both versions get
the same libraries. Each command runs once unmeasured, for its compiled kernels; then the two take
turns. A pair has a seed and a fresh folder of its own, so neither finds its own finished work.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
START = "from mpfcad.cli import main; main()"
#: A film alone over the lamps: no sheet, so nothing but lamps, reflector, plate and film.
ALONE = 'extends = "thesis-32in-mpf"\ntitle = "alone"\nlayers = ["clear_plate", "film"]\n'
UNIFORM = str(ROOT / "masks" / "uniform-c60.toml")

#: What is run by name; `{seed}` is the pair's number, `{tree}` the version's own sources;
#: `film.stl` and `panel.toml` are prepared.
COMMANDS = {
    "import mpfcad": None,
    "mpfcad --help": ["--help"],
    "trace, plate and film alone": [
        "trace", "film.stl", "--stack", "alone.toml", "--effort", "quick", "--seed", "{seed}",
        "--threads", "1",
    ],
    "trace, full stack": [
        "trace", "film.stl", "--stack", "thesis-32in-mpf", "--effort", "quick", "--seed", "{seed}",
        "--threads", "1",
    ],
    "trace, full stack, standard": [
        "trace", "film.stl", "--stack", "thesis-32in-mpf", "--effort", "standard", "--seed",
        "{seed}", "--threads", "1",
    ],
    "trace, MPF-Plate, standard": [
        "trace", "film.stl", "--stack", "thesis-32in-mpf-plate", "--effort", "standard", "--seed",
        "{seed}", "--threads", "1",
    ],
    "panel's mask, OASIS, written and checked": ["mask", "panel.toml", "--format", "oas"],
    "panel's STL, written and checked": ["cad", "panel.toml", "--format", "stl"],
    "README's first command, quick": [
        "run", "{tree}/masks/patterned-16mm.toml", "--effort", "quick", "--threads", "1",
    ],
}  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tree", type=Path, metavar="TREE", help="sources of the other version")
    parser.add_argument("--repeat", type=int, default=5, help="measured pairs a command [5]")
    parser.add_argument("--only", choices=COMMANDS, help="this command")
    parser.add_argument("--json", action="store_true", help="print a list instead of a table")
    given = parser.parse_args()
    trees = [given.tree.resolve(), ROOT]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder))
        for name, arguments in COMMANDS.items():
            if given.only not in (None, name):
                continue
            row = compare(name, arguments, trees, Path(folder), given.repeat)
            rows.append(row)
            if not given.json:
                print(f"{name:45} {row['before']:8.2f} {row['now']:8.2f} s  {row['ratio']:.3f} "
                      f"({row['low']:.3f} … {row['high']:.3f})", flush=True)  # fmt: skip
    if given.json:
        print(json.dumps(rows, indent=1))


def prepare(folder):
    """Write the job of a panel, the stack of a film alone, and the film's mesh."""
    (folder / "alone.toml").write_text(ALONE)
    (folder / "panel.toml").write_text(
        'name = "panel"\n[map]\ncurvature_per_mm = 60.0\n[cad]\nextent = "panel"\n'
    )
    work = ["cad", UNIFORM, "--format", "stl", "--out", str(folder / "film")]
    spend(ROOT, work, folder, folder / "cache")
    (folder / "film" / "film.stl").rename(folder / "film.stl")


def compare(name, arguments, trees, folder, repeat):
    """Return medians of both versions' CPU seconds, and the ratio of each pair's."""
    spent = ([], [])
    for seed in range(repeat + 1):
        for side in (0, 1) if seed % 2 else (1, 0):
            own = None
            if arguments is not None:
                own = [part.format(seed=seed + 1, tree=trees[side]) for part in arguments]
                if own[0] in ("mask", "cad", "run"):
                    own += ["--out", str(folder / f"out-{side}-{seed}")]
            time = spend(trees[side], own, folder, folder / f"cache-{side}")
            if seed:
                spent[side].append(time)
    ratios = [now / before for before, now in zip(*spent, strict=True)]
    return {
        "name": name, "before": statistics.median(spent[0]), "now": statistics.median(spent[1]),
        "ratio": statistics.median(ratios), "low": min(ratios), "high": max(ratios),
    }  # fmt: skip


def spend(tree, arguments, folder, cache):
    """Return the CPU seconds of a command of the version in `tree`, its kernels kept in `cache`."""
    command = [sys.executable, "-c", "import mpfcad" if arguments is None else START]
    environment = {
        **os.environ, "PYTHONPATH": str(tree), "MPFCAD_CACHE": str(cache),
        "NUMBA_CACHE_DIR": str(cache / "numba"),
    }  # fmt: skip
    process = subprocess.Popen(
        command + (arguments or []), cwd=folder, env=environment,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip
    error = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        raise SystemExit(f"{tree}: {' '.join(arguments or command)}: {error.decode()[-300:]}")
    return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    main()
