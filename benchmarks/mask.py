"""Masks of a whole panel: ours beside gdstk, klayout and gdsfactory, in one run.

`python benchmarks/mask.py [--quick] [--json]`. Each case runs in a process of its own and reports
user CPU past its imports, file size and peak memory; ours and the peers take turns. The peers come
from the extra `benchmark`; one that is not installed is named as absent.
"""

import argparse
import importlib.util
import json
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

PITCH, WIDTH, LENGTH, LAMP = 0.050, 392.26, 697.68, 32.69
PEERS = ("gdstk", "klayout", "gdsfactory")


def film_1d():
    from mpfcad.film import Groove, PrismFilm

    x = (np.arange(round(WIDTH / PITCH + 0.49)) + 0.5) * PITCH
    wave = 60 + 3.5 * np.cos(2 * np.pi * x / LAMP)
    return PrismFilm(Groove(PITCH, PITCH / 2), 0.2, LENGTH, "filled", wave)


def film_2d(width=WIDTH, length=LENGTH, pitch=PITCH):
    from mpfcad.film import CurvatureField, FieldFilm, Groove

    x, y = np.arange(0, width + 1.1), np.arange(0, length + 1.1)
    wave = np.cos(2 * np.pi * x / LAMP) * np.cos(2 * np.pi * y[:, None] / LAMP)
    groove = Groove(pitch, pitch / 2)
    curvature = (60 + 3.5 * wave) * PITCH / pitch
    field = CurvatureField(x, y, curvature)
    return FieldFilm(groove, length, round(width / pitch + 0.49), field)


def mask_of(film, pattern, period):
    from mpfcad.film import read_process
    from mpfcad.mask import MaskRules, build_mask

    rules = MaskRules(pattern, period, period * 0.18, period * 0.2)
    return build_mask(film, read_process(None, film.groove), rules, "benchmark")


def ours_1d(path):
    from mpfcad.mask import write_mask

    write_mask(mask_of(film_1d(), "dot", 0.05), path)


def check_1d(path):
    from mpfcad.mask import check_mask

    check_mask(path, mask_of(film_1d(), "dot", 0.05))


def gdstk_1d(path):
    """One repeated rectangle a groove, as gdstk's manual shows."""
    import gdstk

    mask = mask_of(film_1d(), "dot", 0.05)
    library = gdstk.Library(unit=1e-6, precision=1e-9)
    top = library.new_cell("MASK")
    for array in mask.arrays:
        (x, y), (w, h), step = array.place.origin, array.size, array.place.row_step[1]
        box = gdstk.rectangle((x / 1e3, y / 1e3), ((x + w) / 1e3, (y + h) / 1e3), layer=1)
        box.repetition = gdstk.Repetition(1, array.place.rows, spacing=(w / 1e3, step / 1e3))
        top.add(box)
    library.write_oas(path)


def klayout_1d(path):
    """One cell a size and one instance array a groove."""
    import klayout.db as kdb

    mask = mask_of(film_1d(), "dot", 0.05)
    layout = kdb.Layout()
    layer, top, cells = layout.layer(1, 0), layout.create_cell("MASK"), {}
    for array in mask.arrays:
        if array.size not in cells:
            cells[array.size] = layout.create_cell(f"A{array.size[0]}")
            cells[array.size].shapes(layer).insert(kdb.Box(0, 0, *array.size))
        trans, step = kdb.Trans(*array.place.origin), kdb.Vector(0, array.place.row_step[1])
        index = cells[array.size].cell_index()
        top.insert(kdb.CellInstArray(index, trans, kdb.Vector(1, 0), step, 1, array.place.rows))
    options = kdb.SaveLayoutOptions()
    options.format, options.oasis_compression_level = "OASIS", 10
    layout.write(str(path), options)


def gdsfactory_1d(path):
    """One component a size and one array reference a groove, written as it writes by default."""
    import gdsfactory as gf

    gf.gpdk.PDK.activate() if hasattr(gf, "gpdk") else None
    mask = mask_of(film_1d(), "dot", 0.05)
    top, cells = gf.Component("MASK"), {}
    for array in mask.arrays:
        if array.size not in cells:
            cell = gf.Component(f"A{array.size[0]}")
            w, h = array.size[0] / 1e3, array.size[1] / 1e3
            cell.add_polygon([(0, 0), (w, 0), (w, h), (0, h)], layer=(1, 0))
            cells[array.size] = cell
        step = array.place.row_step[1] / 1e3
        reference = top.add_ref(
            cells[array.size], columns=1, rows=array.place.rows, row_pitch=step, column_pitch=1.0
        )
        reference.move((array.place.origin[0] / 1e3, array.place.origin[1] / 1e3))
    top.write_gds(path)


def ours_2d(pattern, share=1.0):
    def write(path):
        from mpfcad.mask import write_mask

        write_mask(mask_of(film_2d(WIDTH * share), pattern, 0.05), path)

    return write


def check_2d(share=1.0):
    def check(path):
        from mpfcad.mask import check_mask

        check_mask(path, mask_of(film_2d(WIDTH * share), "error-diffused", 0.05))

    return check


def build_2d(share=1.0):
    def build(path):
        mask_of(film_2d(WIDTH * share), "error-diffused", 0.05)

    return build


def large_2d(path):
    """65 inch at half the pitch: 16 times the cells."""
    from mpfcad.mask import write_mask

    write_mask(mask_of(film_2d(2 * WIDTH, 2 * LENGTH, PITCH / 2), "error-diffused", 0.025), path)


JOB = Path(__file__).parents[1] / "masks" / "patterned-16mm.toml"


def propose(path):
    """Try every mesh of the catalogue for the job that ships."""
    from mpfcad.job import read_job
    from mpfcad.pipeline import read_proposals

    read_proposals(read_job(JOB), JOB)


def order(path):
    """Write the order sheet of the job that ships."""
    from mpfcad.job import read_job
    from mpfcad.mask.screen.order_sheet import write_order
    from mpfcad.pipeline import read_mask_plan
    from mpfcad.pipeline.plan.printed.order import job_order

    plan = read_mask_plan(read_job(JOB), JOB)
    write_order(path, job_order(plan.job, plan.mask, plan.process), "PASS", {})


def tiff(path):
    """Write and check the panel of the job that ships as TIFF."""
    from mpfcad.job import read_job
    from mpfcad.mask import Phototool, check_mask, write_mask
    from mpfcad.pipeline import read_mask_plan

    mask = read_mask_plan(read_job(JOB), JOB).mask
    write_mask(mask, path, Phototool())
    check_mask(path, mask, Phototool())


CASES = {
    "propose": propose,
    "order": order,
    "tiff": tiff,
    "ours-1d": ours_1d,
    "check-1d": check_1d,
    "gdstk": gdstk_1d,
    "klayout": klayout_1d,
    "gdsfactory": gdsfactory_1d,
    "build-2d": build_2d(),
    "build-2d-quarter": build_2d(0.25),
    "check-2d": check_2d(),
    "check-2d-quarter": check_2d(0.25),
    "65-inch": large_2d,
}
for _pattern in ("error-diffused", "blue-noise", "dot"):
    CASES[f"{_pattern}"] = ours_2d(_pattern)
    CASES[f"{_pattern}-quarter"] = ours_2d(_pattern, 0.25)


def user_time():
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def run_case(name, path):
    """Do a case in this process; compile and import first, on a scrap of film."""
    warm = film_2d(2.0, 50.0)
    if name in PEERS and name != "gdsfactory":
        importlib.import_module("klayout.db" if name == "klayout" else name)
    elif name == "gdsfactory":
        importlib.import_module("gdsfactory")
    from mpfcad.mask import check_mask, write_mask

    for pattern in ("error-diffused", "blue-noise", "dot"):
        mask = mask_of(warm, pattern, 0.05)
        with tempfile.TemporaryDirectory() as folder:
            write_mask(mask, Path(folder) / "warm.oas")
            if name.startswith("check"):
                check_mask(Path(folder) / "warm.oas", mask)
    start = user_time()
    CASES[name](path)
    spent = user_time() - start
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    size = path.stat().st_size if path.exists() else 0
    print(json.dumps({"user": spent, "size": size, "memory": memory}))


def measure(name, path, repeats):
    """Return the least of several runs, each a process of its own."""
    runs = []
    for _ in range(repeats):
        command = [sys.executable, __file__, "--case", name, "--path", str(path)]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        if result.returncode:
            raise SystemExit(f"{name}: {result.stderr.strip().splitlines()[-1]}")
        runs.append(json.loads(result.stdout.splitlines()[-1]))
    return {key: min(run[key] for run in runs) for key in runs[0]}


def entry(name, ours, unit, *, peer=None, goal=None, met=None):
    ratio = None if peer is None or not ours else peer / ours
    return {"name": name, "ours": ours, "peer": peer, "unit": unit, "ratio": ratio,
            "goal": goal, "met": met}  # fmt: skip


def at_most(name, ours, unit, limit):
    return entry(name, ours, unit, goal=f"≤ {limit:g} {unit}", met=ours <= limit)


def compare_1d(folder, repeats):
    """Ours and the peers by turns, on the same apertures."""
    found = {}
    names = ("ours-1d", *(p for p in PEERS if importlib.util.find_spec(p)))
    for _ in range(repeats):
        for name in names:
            suffix = ".gds" if name == "gdsfactory" else ".oas"
            run = measure(name, folder / f"{name}{suffix}", 1)
            before = found.get(name, run)
            found[name] = {key: min(run[key], before[key]) for key in run}
    ours = found["ours-1d"]
    yield at_most("1-D panel: OASIS size", ours["size"] / 1e3, "kB", 62)
    yield at_most("1-D panel: drawn and written, user CPU", ours["user"], "s", 0.1)
    for peer in PEERS:
        if peer not in found:
            yield entry(f"1-D panel beside {peer}: absent", None, "s")
            continue
        times, size = (3, 10) if peer == "gdsfactory" else (None, None)
        for what, key, unit, scale, least in (
            ("user CPU", "user", "s", 1, times), ("size", "size", "kB", 1e3, size),
        ):  # fmt: skip
            ratio = found[peer][key] / max(ours[key], 1e-9)
            yield entry(
                f"1-D panel beside {peer}: {what}", ours[key] / scale, unit,
                peer=found[peer][key] / scale, goal=least and f"≥ {least}×",
                met=least and ratio >= least,
            )  # fmt: skip
    check = measure("check-1d", folder / "ours-1d.oas", repeats)
    yield at_most("1-D panel: checked from the file, user CPU", check["user"], "s", 1)


def measure_2d(folder, quick):
    """Limits are those of the whole panel, by area for a quarter of it."""
    part, share = ("-quarter", 0.25) if quick else ("", 1.0)
    name = "2-D quarter panel" if quick else "2-D panel"
    path = folder / "dither.oas"
    whole = measure("error-diffused" + part, path, 1)
    yield at_most(f"{name}, dithered: size", whole["size"] / 1e6, "MB", 15 * share)
    yield at_most(f"{name}, dithered: drawn and written, user CPU", whole["user"], "s", 15 * share)
    yield at_most(f"{name}, dithered: peak memory", whole["memory"] / 2**30, "GiB", 1.5)
    check, build = measure("check-2d" + part, path, 1), measure("build-2d" + part, path, 1)
    spent = check["user"] - build["user"]
    yield at_most(f"{name}, dithered: ratio map from the file, user CPU", spent, "s", 10 * share)
    for pattern in ("blue-noise", "dot"):
        run = measure(pattern + part, folder / "level.oas", 1)
        title = f"{name}, 255 levels, {pattern}"
        yield at_most(f"{title}: size", run["size"] / 1e6, "MB", 20 * share)
        yield entry(f"{title}: drawn and written, user CPU", run["user"], "s")
        yield entry(f"{title}: peak memory", run["memory"] / 2**30, "GiB")
    if quick:
        return
    quarter = measure("error-diffused-quarter", path, 1)
    ratio = whole["user"] / quarter["user"] / 4
    yield entry("2-D cost of four times the area, over four times the cost", ratio, "",
                goal="≤ 1.3", met=ratio <= 1.3)  # fmt: skip
    large = measure("65-inch", folder / "large.oas", 1)
    yield at_most("65 inch at half pitch, dithered: peak memory", large["memory"] / 2**30, "GiB", 2)
    yield entry("65 inch at half pitch, dithered: size", large["size"] / 1e6, "MB")
    per_cell = large["user"] / whole["user"] / 16
    yield entry("65 inch at half pitch: cost a cell over the panel's", per_cell, "",
                goal="≤ 1.3", met=per_cell <= 1.3)  # fmt: skip


def measure_screen(folder):
    """Yield a proposal, an order and a TIFF of the panel that ships."""
    for name, title, limit in (
        ("propose", "panel: screens proposed over the catalogue, user CPU", 5),
        ("order", "panel: order sheet, with the plan, user CPU", 2),
        ("tiff", "panel: TIFF of 2540 dpi written and checked, user CPU", 20),
    ):
        run = measure(name, folder / f"{name}.{'tif' if name == 'tiff' else 'pdf'}", 1)
        yield at_most(title, run["user"], "s", limit)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a quarter panel in 2-D, one run each")
    parser.add_argument("--json", action="store_true", help="print a list instead of a table")
    parser.add_argument("--case", help=argparse.SUPPRESS)
    parser.add_argument("--path", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.case:
        run_case(given.case, given.path)
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = [*compare_1d(folder, 1 if given.quick else 3), *measure_2d(folder, given.quick),
                *measure_screen(folder)]  # fmt: skip
    if given.json:
        print(json.dumps(rows, indent=1, ensure_ascii=False))
        return
    for row in rows:
        cells = [f"{row[key]:.3g}" if row[key] is not None else "–" for key in ("ours", "peer")]
        times = f"{row['ratio']:.1f}×" if row["ratio"] else ""
        met = {True: "met", False: "NOT MET", None: ""}[row["met"]]
        print(f"{row['name']:66} {cells[0]:>8} {cells[1]:>8} {row['unit']:4} {times:>7}  "
              f"{row['goal'] or '':10} {met}")  # fmt: skip


if __name__ == "__main__":
    os.environ.setdefault("PYTHONHASHSEED", "0")
    main()
