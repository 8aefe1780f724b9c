"""The tracer beside Mitsuba 3 (llvm), raysect and Embree, by turns in one run, in CPU seconds.

`python benchmarks/trace.py [--quick] [--json]`. Ours always traces the whole film; Mitsuba gets it
as users would (*mesh*: all grooves of a lamp's pitch) and, where named, as the best case of a
renderer (*cell*: two pitches between perfect mirrors). Both figures of a pair are printed with what
they measure; a goal counts as met only where they differ by less than 5 standard errors and 1 %.
raysect gets the cell, and Mitsuba its like for the stack. Peers come from the extra `benchmark`;
one that is not installed is named as absent. Mitsuba looks for LLVM's library: DRJIT_LIBLLVM_PATH
names it.
"""

import argparse
import importlib.util
import json
import sys
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
from trace_mesh import pyramids
from trace_peers import (
    PITCH,
    embree_closest,
    mitsuba_film,
    mitsuba_stack,
    raysect_film,
)

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from harness import CONCAVE, film_file

GROOVES, PANEL, CELLS = 654, 7846, 707
STACK = "thesis-32in-mpf"


def ours(path, kind, rho=None):
    """Return trace(n, seed) → (mean, standard error, paths) of a film between black halves."""
    from mpfcad.optics.element import Cavity, Film
    from mpfcad.optics.engine import BLOCK, trace
    from mpfcad.optics.mesh import read_film_mesh
    from mpfcad.optics.recorder import FLOW_ELEMENTS
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source

    mesh = read_film_mesh(path)
    place = np.full(32, mesh.size[0] / 2)
    film = Film(mesh, 1.5)
    if rho is None:
        scene = build_scene([film], below=1.0)
    else:
        # Lamps so thin and far that none is met: what the reflector absorbs of a meter's unit is
        # (1-ρ) times its luminance, if it shone with radiance 1. It is as near to the film as the
        # peer's: in a wider gap light would forget below which groove it was.
        cavity = Cavity(1e-3, 1e6, 5e5, 0.5, 1e-6, 0.0, 0.0, rho, 0.0)
        scene = build_scene([cavity, film])

    def run(n, seed):
        blocks = max(2, n // (BLOCK * len(place)))
        where = LAMBERTIAN_BELOW if kind == "transmittance" else EYE
        tally = trace(scene, Source(where, place, 0.05), blocks, seed=seed)
        share, error = tally.fraction, tally.fraction_error
        if rho is not None:
            value, sigma = (v[FLOW_ELEMENTS] / (1 - rho) for v in (share, error))
            return value, sigma, tally.total_paths
        if kind == "transmittance":
            return share[0], error[0], tally.total_paths
        error = np.sqrt((tally.radiance_error**2).mean() / len(place))
        return tally.radiance.mean(), error, tally.total_paths

    return run


def spent(call, *arguments):
    start = time.process_time()
    result = call(*arguments)
    return result, time.process_time() - start


def entry(name, ours, unit, *, peer=None, ratio=None, goal=None, same=True):
    """Return a row; a goal is met only where both give the same answer."""
    met = None if goal is None or ratio is None else bool(ratio >= goal and same)
    return {"name": name, "ours": ours, "peer": peer, "unit": unit, "ratio": ratio,
            "goal": goal and f"≥ {goal}×", "met": met}  # fmt: skip


def equal(values, errors):
    """Return whether two figures are within 5 standard errors and 1 % of each other."""
    away = abs(values[0] - values[1])
    return away <= 5 * np.hypot(*errors) and away <= 0.01 * abs(values[0])


def race(name, mine, theirs, counts, rounds, goal):
    """Trace by turns; yield paths a CPU second of both, and the two figures."""
    mine(1, 1), theirs(counts[1], 1)
    rates, figures = ([], []), ([], [])
    for seed in range(2, 2 + rounds):
        for k, tracer in enumerate((mine, theirs)):
            result, cpu = spent(tracer, counts[k], seed)
            rates[k].append((result[2] if k == 0 else counts[k]) / cpu)
            figures[k].append(result[:2])
    best = [max(r) / 1e3 for r in rates]
    values = [np.mean([f[0] for f in fig]) for fig in figures]
    errors = [np.sqrt(np.sum([f[1] ** 2 for f in fig])) / len(fig) for fig in figures]
    yield entry(name, best[0], "k/s", peer=best[1], ratio=best[0] / best[1], goal=goal,
                same=equal(values, errors))  # fmt: skip
    away = abs(values[0] - values[1]) / np.hypot(*errors)
    yield entry(f"    figures; {away:.1f} σ apart", values[0], "", peer=values[1])


def film_rows(folder, quick, present):
    path = film_file(folder / "film.stl", [CONCAVE] * GROOVES, length=20.0)
    cell = film_file(folder / "cell.stl", [CONCAVE] * 8, length=0.4)
    scale = 1 if quick else 4
    for kind in ("transmittance", "normal luminance"):
        lambertian = kind == "transmittance"
        for what, file, mirrors, goal in (("mesh", path, 0, 5), ("cell", cell, PITCH, None)):
            name = f"film, {kind}, beside Mitsuba ({what})"
            if not present["mitsuba"]:
                yield entry(f"{name}: absent", None, "k/s")
                continue
            peer = mitsuba_film(file, 1.5, lambertian, mirrors=mirrors)
            counts = (scale * 1_000_000, scale * 500_000)
            yield from race(name, ours(path, kind), peer, counts, 3, goal)
        if not present["raysect"]:
            yield entry(f"film, {kind}, beside raysect: absent", None, "k/s")
            continue
        peer = raysect_film(cell, 1.5, lambertian)
        counts = (scale * 1_000_000, scale * 40_000)
        name = f"film, {kind}, beside raysect (cell)"
        yield from race(name, ours(path, kind), peer, counts, 2, 12)
    name = "film over a 95 % white reflector beside Mitsuba (mesh)"
    if not present["mitsuba"]:
        yield entry(f"{name}: absent", None, "k/s")
        return
    peer = mitsuba_film(path, 1.5, False, reflectance=0.95)
    counts = (scale * 300_000, scale * 200_000)
    yield from race(name, ours(path, "luminance", rho=0.95), peer, counts, 3, 6)


def pyramid_rows(folder, quick, present):
    """Trace a field of pyramids; Mitsuba's as it is, and two cells of one between mirrors.

    Those are endless, as ours is: else guided light leaves at the sides. Mirrors at the sides of
    the whole field would not do: far out Mitsuba's ray offsets are 1.6 µm.
    """
    from mpfcad.optics.grid_build import build_grid
    from mpfcad.optics.mesh import read_film_mesh

    cells = 400 if quick else CELLS
    path = pyramids(folder / "pyramids.stl", cells)
    field = f"pyramids, {4 * cells * cells:,} facets"
    mesh = read_film_mesh(path)
    grid, cpu = spent(build_grid, mesh)
    yield entry(f"{field}, grid built", cpu, "s")
    yield entry("    its size", sum(v.nbytes for v in grid) / 2**20, "MiB")
    if not present["mitsuba"]:
        yield entry(f"{field}, beside Mitsuba: absent", None, "k/s")
        return
    cell = pyramids(folder / "few.stl", 8)
    for what, file, mirrors in (("mesh", path, 0), ("cell", cell, PITCH)):
        for kind in ("transmittance", "normal luminance"):
            lambertian = kind == "transmittance"
            peer = mitsuba_film(file, 1.5, lambertian, mirrors=mirrors, top=190.0)
            name = f"{field}, {kind}, beside Mitsuba ({what})"
            yield from race(name, ours(path, kind), peer, (500_000, 500_000), 3, 1.5)


def closest_rows(folder, quick, present):
    from mpfcad.optics.bvh import build_bvh, closest_facets
    from mpfcad.optics.mesh import read_film_mesh

    path = film_file(folder / "panel.stl", [CONCAVE] * (GROOVES if quick else PANEL), length=20.0)
    name = "closest hit by the tree, beside Embree's robust single rays"
    if not present["embreex"]:
        yield entry(f"{name}: absent", None, "k/s")
        return
    mesh = read_film_mesh(path)
    tree = build_bvh(mesh)
    vertex, facet = mesh.vertex, mesh.top
    peer = embree_closest(vertex - [mesh.size[0] / 2, mesh.size[1] / 2, 0.0], facet)
    random = np.random.default_rng(1).random((200_000, 4))
    origin = random[:, :3] * [mesh.size[0], mesh.size[1], 0.0]
    k, phi = np.sqrt(random[:, 2]), 2 * np.pi * random[:, 3]
    direction = np.stack([k * np.cos(phi), k * np.sin(phi), np.sqrt(1 - k * k)], axis=1)
    local = (origin - [mesh.size[0] / 2, mesh.size[1] / 2, 0.0]).astype(np.float32)
    narrow = direction.astype(np.float32)
    hits = np.empty(len(origin), np.int64)
    closest_facets(tree, origin[:10], direction[:10], hits[:10])
    best = [0.0, 0.0]
    for _ in range(3):
        _, cpu = spent(closest_facets, tree, origin, direction, hits)
        best[0] = max(best[0], len(hits) / cpu / 1e3)
        _, cpu = spent(peer, local, narrow)
        best[1] = max(best[1], len(hits) / cpu / 1e3)
    yield entry(name, best[0], "k/s", peer=best[1], ratio=best[0] / best[1], goal=0.9)


def stack_rows(folder, quick, present):
    """Time to a contrast half-width of 0.001: CPU a path times variance a path, of both.

    The half-width goes as the standard error of a point, so from a run's CPU and errors follows
    what a given half-width costs: measured for ours at 0.004 or 0.002, and scaled for both.
    """
    from mpfcad.backlight import read_stack
    from mpfcad.measure import contrast_of_harmonics, fit_harmonics
    from mpfcad.optics.engine import trace
    from mpfcad.optics.mesh import read_film_mesh
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.source import EYE, Source

    path = film_file(folder / "panel.stl", [CONCAVE] * (GROOVES * 2 + 40), length=68.0)
    stack = read_stack(STACK)
    elements = stack.elements(read_film_mesh(path))
    scene = build_scene(elements)
    position = np.linspace(0, 1, 33)
    source = Source(EYE, position * stack.lamp_pitch, 1.0)
    blocks = 60 if quick else 240
    trace(scene, source, 1)
    tally, cpu = spent(lambda: trace(scene, source, blocks, seed=2))
    fit = fit_harmonics(position, tally.radiance, tally.radiance_error, tally.blocks)
    reached = contrast_of_harmonics(fit).half_width
    mine = cpu * (reached / 0.001) ** 2
    name = "MPF stack, CPU to contrast half-width 0.001, beside Mitsuba"
    if not present["mitsuba"]:
        yield entry(f"{name}: absent", mine, "s")
        return
    points = position[::8]
    tracers = mitsuba_stack(path, elements, points)
    n = 100_000 if quick else 400_000
    tracers[0](n, 1)
    cost, values, errors = 0.0, [], []
    for i, tracer in enumerate(tracers):
        (mean, error), peer_cpu = spent(tracer, n, 2 + i)
        values.append(mean)
        errors.append(error)
        # What one point costs at unit relative variance, beside ours at the same point.
        cost += peer_cpu * (error / mean) ** 2 / len(tracers)
    relative = np.mean((tally.radiance_error / tally.radiance)[::8] ** 2)
    own = cpu / len(position) * relative
    both = tally.radiance[::8].mean(), np.mean(values)
    own_error = np.sqrt(np.mean(tally.radiance_error[::8] ** 2) / len(values))
    same = equal(both, (own_error, np.sqrt(np.mean(np.square(errors)) / len(values))))
    yield entry(name, mine, "s", peer=mine * cost / own, ratio=cost / own, goal=5, same=same)
    yield entry("    mean normal luminance", both[0], "cd/m²", peer=both[1])
    rates = (tally.total_paths / cpu / 1e3, n / peer_cpu / 1e3)
    yield entry("    paths traced", rates[0], "k/s", peer=rates[1])


def thread_rows(folder, quick, present):
    """Measure what two threads gain from CPU seconds and waiting, as others use the machine too.

    Two threads are 2 · (CPU seconds of one thread over those of two) · (1 - share of waiting) times
    as fast on two free cores. A thread waits from the end of one block to the start of its next
    (for the interpreter's lock), and after its last one until the other has ended. What two busy
    cores take from each other (a shared cache, one core's two hyperthreads) is not seen where both
    are busy anyway.
    """
    from mpfcad.backlight import read_stack
    from mpfcad.optics import engine
    from mpfcad.optics.mesh import read_film_mesh
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.source import EYE, Source

    path = film_file(folder / "pitch.stl", [CONCAVE] * GROOVES, length=20.0)
    stack = read_stack(STACK)
    scene = build_scene(stack.elements(read_film_mesh(path)))
    source = Source(EYE, np.linspace(0, 1, 33) * stack.lamp_pitch, 1.0)
    blocks, kernel, calls = 40 if quick else 160, engine.trace_paths, []

    def timed(*arguments):
        start = time.perf_counter()
        kernel(*arguments)
        calls.append((threading.get_ident(), start, time.perf_counter()))

    engine.trace(scene, source, 1)
    spending, shares = {1: [], 2: []}, []
    engine.trace_paths = timed
    try:
        for _ in range(7):
            for threads in (1, 2):
                calls.clear()
                _, cpu = spent(lambda n=threads: engine.trace(scene, source, blocks, threads=n))
                spending[threads].append(cpu)
            busy = sum(end - start for _, start, end in calls)
            first, last = min(c[1] for c in calls), max(c[2] for c in calls)
            shares.append(1 - busy / (2 * (last - first)))
    finally:
        engine.trace_paths = kernel
    share = float(np.median(shares))
    one, two = (float(np.median(spending[threads])) for threads in (1, 2))
    gain = 2 * one / two * (1 - share)
    yield entry("two threads, MPF stack, beside one", gain, "×", ratio=gain, goal=1.9)
    yield entry("    CPU seconds of two threads and of one", two, "s", peer=one)
    yield entry("    share of the time that a thread waits, median of 7", share, "")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer paths, smaller meshes")
    parser.add_argument("--json", action="store_true", help="print a list instead of a table")
    parser.add_argument("--only", help="film, pyramid, closest, stack or thread")
    given = parser.parse_args()
    names = ("mitsuba", "raysect", "embreex")
    present = {name: importlib.util.find_spec(name) is not None for name in names}
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for scene in (film_rows, pyramid_rows, closest_rows, stack_rows, thread_rows):
            if given.only and not scene.__name__.startswith(given.only):
                continue
            for row in scene(Path(name), given.quick, present):
                rows.append(row)
                if not given.json:
                    show(row)
    if given.json:
        print(json.dumps(rows, indent=1, ensure_ascii=False, default=float))


def show(row):
    cells = [f"{row[key]:.5g}" if row[key] is not None else "–" for key in ("ours", "peer")]
    times = f"{row['ratio']:.1f}×" if row["ratio"] else ""
    met = {True: "met", False: "NOT MET", None: ""}[row["met"]]
    print(f"{row['name']:70} {cells[0]:>9} {cells[1]:>9} {row['unit']:5} {times:>7}  "
          f"{row['goal'] or '':8} {met}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
