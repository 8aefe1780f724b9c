"""The tracer beside Mitsuba 3 (llvm), raysect and Embree, by turns in one run, in CPU seconds.

`python benchmarks/trace.py [--quick] [--json] [--repeat N]`. Ours always traces the
whole film; Mitsuba gets it as users would (*mesh*: all grooves of a lamp's pitch) and, where named,
as the best case of a renderer (*cell*: two pitches between perfect mirrors). Both figures of a pair
are printed with what they measure; a goal counts as met only where they differ by less than 5
standard errors and 1 %. With --repeat all is done N times, and each ratio is shown as the least,
median and largest of them.

raysect gets the cell, and Mitsuba its like for the stack. Peers come from the extra `benchmark`;
one that is not installed is named as absent. Mitsuba looks for LLVM's library: DRJIT_LIBLLVM_PATH
names it.
"""

import argparse
import importlib.util
import json
import statistics
import tempfile
from pathlib import Path

from tracer.closest import closest_rows
from tracer.films import film_rows, pyramid_rows, section_rows
from tracer.stack import stack_rows, thread_rows

SCENES = {
    "film": film_rows, "section": section_rows, "pyramid": pyramid_rows, "closest": closest_rows,
    "stack": stack_rows, "thread": thread_rows,
}  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer paths, smaller meshes")
    parser.add_argument("--json", action="store_true", help="print a list instead of a table")
    parser.add_argument("--only", choices=SCENES, help="this kind of scene")
    parser.add_argument("--repeat", type=int, default=1, metavar="N", help="times to do all")
    given = parser.parse_args()
    names = ("mitsuba", "raysect", "embreex")
    present = {name: importlib.util.find_spec(name) is not None for name in names}
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(given.repeat):
            for name, scene in SCENES.items():
                if given.only not in (None, name):
                    continue
                for row in scene(Path(folder), given.quick, present):
                    rows.append(row)
                    if not given.json:
                        show(row)
    if given.json:
        print(json.dumps(rows, indent=1, ensure_ascii=False, default=float))
    elif given.repeat > 1:
        show_spread(rows)


def show_spread(rows):
    """Print the least, median and largest ratio of each name, and whether the least is enough."""
    by_name = {}
    for row in rows:
        if row["ratio"]:
            by_name.setdefault(row["name"], []).append(row)
    print(f"\n{'ratios of all runs':70}     least    median   largest")
    for name, same in by_name.items():
        ratio = [row["ratio"] for row in same]
        cells = "".join(f"{f(ratio):9.2f}×" for f in (min, statistics.median, max))
        goal = same[0]["goal"]
        met = "" if goal is None else "met" if all(row["met"] for row in same) else "NOT MET"
        print(f"{name:70}{cells}  {goal or '':8} {met}")


def show(row):
    cells = [f"{row[key]:.5g}" if row[key] is not None else "–" for key in ("ours", "peer")]
    times = f"{row['ratio']:.1f}×" if row["ratio"] else ""
    met = {True: "met", False: "NOT MET", None: ""}[row["met"]]
    print(f"{row['name']:70} {cells[0]:>9} {cells[1]:>9} {row['unit']:5} {times:>7}  "
          f"{row['goal'] or '':8} {met}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
