"""CAD files of the whole panel, beside the obvious constructions of build123d and cadquery.

    python benchmarks/cad.py [--quick] [--json] [--cadquery PYTHON]

Every measurement runs in a process of its own; seconds are CPU seconds of building and writing,
after imports. A peer draws the film as it is usually drawn: one wire, one face, one extrusion. It
is given twice as many grooves each time until it takes longer than the budget; ours is measured in
between at the same number. build123d is there anyway; cadquery brings an OCCT of another version in
the same Python package, so it has to be in an environment of its own, with mpfcad, whose
interpreter `--cadquery` names. An absent peer is named.
"""

import argparse
import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

PANEL = 7846
TOLERANCE_DEG = 0.5
#: Seconds after which a peer is not asked for twice as many grooves, and the end of any run.
BUDGET = {True: 1.5, False: 40.0}
LIMIT = 900.0


def film_of(count, curvature=None):
    from mpfcad.film import Groove, PrismFilm

    if curvature is None:
        curvature = 60 + 19 * np.cos(np.arange(count) / 653.8 * 2 * np.pi)
    else:
        curvature = np.full(count, curvature)
    return PrismFilm(Groove(0.050, 0.025), 0.2, 2.0, "filled", curvature)


def step(count, folder, bodies="separate"):
    from mpfcad.cad import write_step

    film, path = film_of(count), folder / "film.step"
    start = time.process_time()
    write_step(film, path, bodies=bodies)
    return {"seconds": time.process_time() - start, "megabytes": path.stat().st_size / 1e6}


def step_fused(count, folder):
    return step(count, folder, "fused")


def step_check(count, folder):
    from mpfcad.cad import check_step

    step(count, folder)
    import OCP.STEPCAFControl  # noqa: F401  its import is not measured

    start = time.process_time()
    check = check_step(folder / "film.step", film_of(count))
    seconds = time.process_time() - start
    return {"seconds": seconds, "valid": check.valid, "volume_error": check.volume_error}


def stl_patterned(count, folder):
    return stl(count, folder, None)


def stl(count, folder, curvature=60.0):
    from mpfcad.cad import check_stl, write_stl
    from mpfcad.units import deg

    film, path = film_of(count, curvature), folder / "film.stl"
    start = time.process_time()
    write_stl(film, path, TOLERANCE_DEG * deg)
    seconds = time.process_time() - start
    check = check_stl(path, film, TOLERANCE_DEG * deg)
    return {
        "seconds": seconds,
        "watertight": check.watertight,
        "secant_error_deg": check.secant_error_rms / deg,
        "worst_groove_deg": check.secant_error_groove / deg,
    }


def cells(side, folder):
    from mpfcad.cad.file.stl import write_mesh
    from mpfcad.cad.shape.cell_mesh import build_cell_mesh
    from mpfcad.cad.step.cell import write_cell_step
    from mpfcad.film import CellFilm, Groove
    from mpfcad.units import deg

    film = CellFilm(Groove(0.050, 0.025), 0.2, "pyramid", "filled", 60.0, (side, side))
    start = time.process_time()
    write_mesh(build_cell_mesh(film, TOLERANCE_DEG * deg), folder / "film.stl", "film")
    middle = time.process_time()
    write_cell_step(film, folder / "film.step")
    return {"STL": middle - start, "STEP": time.process_time() - middle}


def outline(film):
    """Yield tip, contact, middle and contact of each groove, as a peer's user would have them."""
    contact = film.groove.contact_position(film.curvature)
    for i, centre in enumerate(film.groove_position):
        reach, c = contact[i], film.curvature[i]
        z = film.base + film.groove.wall_slope * reach
        # The middle control point of a quadratic Bézier: where the end tangents meet.
        yield (
            (centre - film.groove.half_width, film.thickness),
            (centre - reach, z),
            (centre, z - c * reach * reach),
            (centre + reach, z),
        )


def build123d(count, folder):
    import build123d as b

    film = film_of(count)
    start = time.process_time()
    edges, last = [], (0.0, 0.0)

    def at(point):
        return (point[0], 0, point[1])

    for tip, left, middle, right in outline(film):
        edges.append(b.Edge.make_line(at(last), at(tip)))
        edges.append(b.Edge.make_line(at(tip), at(left)))
        edges.append(b.Edge.make_bezier(at(left), at(middle), at(right)))
        last = right
    for point in ((film.width, film.thickness), (film.width, 0.0), (0.0, 0.0)):
        edges.append(b.Edge.make_line(at(last), at(point)))
        last = point
    solid = b.Solid.extrude(b.Face(b.Wire(edges)), b.Vector(0, film.length, 0))
    b.export_step(solid, folder / "film.step")
    return {"seconds": time.process_time() - start}


def cadquery(count, folder):
    import cadquery as cq

    film = film_of(count)
    start = time.process_time()
    plane = cq.Workplane("XZ").moveTo(0, 0)
    for tip, left, middle, right in outline(film):
        plane = plane.lineTo(*tip).lineTo(*left).bezier([middle, right], includeCurrent=True)
    plane = plane.lineTo(film.width, film.thickness).lineTo(film.width, 0).close()
    cq.exporters.export(plane.extrude(film.length), str(folder / "film.step"))
    return {"seconds": time.process_time() - start}


WORKERS = {
    f.__name__: f
    for f in (step, step_fused, step_check, stl, stl_patterned, cells, build123d, cadquery)
}


def measure(name, count, python=sys.executable):
    """Run a worker in a process of its own; None when it fails or takes longer than `LIMIT`."""
    command = [python, __file__, "--worker", name, str(count)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, check=False)
    except subprocess.TimeoutExpired:
        return None
    return json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else None


def work(name, count):
    with tempfile.TemporaryDirectory() as folder:
        result = WORKERS[name](count, Path(folder))
    result["gigabytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(json.dumps(result))


def row(name, ours, unit, goal, met, peer=None):
    ratio = None if peer is None else peer / ours
    return {
        "name": name,
        "ours": ours,
        "peer": peer,
        "unit": unit,
        "ratio": ratio,
        "goal": goal,
        "met": met,
    }


def why_absent(peer, python):
    """Return why a peer cannot be measured, or nothing when it can be imported."""
    done = subprocess.run(
        [python, "-c", f"import {peer}"], capture_output=True, text=True, check=False
    )
    return done.stderr.strip().rpartition("\n")[2][:60] if done.returncode else None


def compare(peer, quick, python):
    """Return the row of the most grooves that a peer finishes within the budget."""
    missing = why_absent(peer, python)
    if missing:
        return row(f"{peer}: absent: {missing}", None, "s", ">= 8", None)
    best, count = None, 8
    while count <= PANEL:
        theirs, ours = measure(peer, count, python), measure("step_fused", count)
        if theirs is None or ours is None:
            break
        best = (count, ours["seconds"], theirs["seconds"])
        if theirs["seconds"] > BUDGET[quick]:
            break
        count *= 2
    if best is None:
        return row(f"{peer}: finishes not even {count} grooves", None, "s", ">= 8", None)
    count, ours, theirs = best
    name = f"STEP of {count} grooves as one body, against {peer}"
    return row(name, ours, "s", ">= 8", theirs >= 8 * ours, theirs)


def slope_rows(mesh, what):
    """Return time and slopes of a panel's STL."""
    fine = mesh["seconds"] <= 2 and mesh["watertight"]
    rows = [row(f"panel STL at 0.5°, {what}, watertight", mesh["seconds"], "s", "<= 2", fine)]
    errors = (("all", mesh["secant_error_deg"]), ("worst groove", mesh["worst_groove_deg"]))
    for where, error in errors:
        name = f"panel STL, {what}: slopes to secants, rms, {where}"
        rows.append(row(name, error, "deg", "<= 0.001", error <= 0.001))
    return rows


def cell_rows(found):
    """Return the times of 10⁴ pyramids."""
    return [
        row(f"10⁴ pyramids, {kind}", found[kind], "s", "<= 10", found[kind] <= 10)
        for kind in ("STL", "STEP")
    ]


def benchmark(quick, cadquery_python):
    quarter, whole = measure("step", PANEL // 4), measure("step", PANEL)
    slope = math.log(whole["seconds"] / quarter["seconds"]) / math.log(4)
    rows = [
        row("panel STEP, build + write", whole["seconds"], "s", "<= 10", whole["seconds"] <= 10),
        row("panel STEP, size", whole["megabytes"], "MB", "<= 30", whole["megabytes"] <= 30),
        row("panel STEP, memory", whole["gigabytes"], "GB", "<= 3", whole["gigabytes"] <= 3),
        row("panel STEP, exponent of N", slope, "", "<= 1.1", slope <= 1.1),
    ]
    pythons = {"build123d": sys.executable, "cadquery": cadquery_python}
    rows += [compare(peer, quick, python) for peer, python in pythons.items()]
    for worker, what in (("stl", "C = 60"), ("stl_patterned", "C = 41 … 79")):
        rows += slope_rows(measure(worker, PANEL), what)
    rows += cell_rows(measure("cells", 100))
    count = PANEL // 16 if quick else PANEL
    check, limit = measure("step_check", count), 40 * count / PANEL
    name = f"STEP of {count} grooves read again and checked"
    met = check["seconds"] <= limit and check["valid"]
    rows.append(row(name, check["seconds"], "s", f"<= {limit:g}", met))
    volume = check["volume_error"]
    rows.append(row("its largest error of a volume", volume, "", "<= 1e-9", volume <= 1e-9))
    return rows


def table(rows):
    words = {True: "met", False: "NOT MET", None: "-"}
    for r in rows:
        ours, peer, ratio = (
            "-" if r[key] is None else f"{r[key]:.4g}" for key in ("ours", "peer", "ratio")
        )
        name, state = r["name"], words[r["met"]]
        print(f"{name:58} {ours:>10} {peer:>9} {r['unit']:4} {ratio:>7} {r['goal']:>9}  {state}")


def main():
    parser = argparse.ArgumentParser(description="CAD files against their goals and peers.")
    parser.add_argument("--quick", action="store_true", help="under a minute")
    parser.add_argument("--json", action="store_true", help="one list of rows")
    parser.add_argument(
        "--cadquery", metavar="PYTHON", default=sys.executable, help="interpreter with cadquery"
    )
    parser.add_argument("--worker", nargs=2, metavar=("NAME", "N"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        work(options.worker[0], int(options.worker[1]))
        return
    rows = benchmark(options.quick, options.cadquery)
    if options.json:
        print(json.dumps(rows))
    else:
        table(rows)


if __name__ == "__main__":
    main()
