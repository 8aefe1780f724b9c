"""The MPF stack: time to a contrast, and what a second thread gains."""

import threading
import time

import numpy as np
from harness import CONCAVE, film_file

from tracer.mitsuba_scene import mitsuba_stack
from tracer.race import entry, equal, spent

GROOVES = 654
STACK = "thesis-32in-mpf"


def stack_rows(folder, quick, present):
    """Time to a contrast half-width of 0.001: CPU a path times variance a path, of both.

    The half-width goes as the standard error of a point, so from a run's CPU and errors follows
    what a given half-width costs: measured for ours at 0.004 or 0.002, and scaled for both.
    """
    from mpfcad.backlight import read_stack
    from mpfcad.backlight.lower import lower_stack
    from mpfcad.measure import contrast_of_curve, fit_curve
    from mpfcad.optics.engine import trace
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.solid.mesh import read_film_mesh
    from mpfcad.optics.source import EYE, Source

    path = film_file(folder / "panel.stl", [CONCAVE] * (GROOVES * 2 + 40), length=68.0)
    stack = read_stack(STACK)
    elements = lower_stack(stack, read_film_mesh(path))
    scene = build_scene(elements)
    position = np.linspace(0, 1, 33)
    source = Source(EYE, position * stack.period.across, 1.0)
    blocks = 60 if quick else 240
    trace(scene, source, 1)
    tally, cpu = spent(lambda: trace(scene, source, blocks, seed=2))
    fit = fit_curve(position, tally.radiance, tally.radiance_error, tally.blocks)
    reached = contrast_of_curve(fit).half_width
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
    from mpfcad.backlight.lower import lower_stack
    from mpfcad.optics import engine
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.solid.mesh import read_film_mesh
    from mpfcad.optics.source import EYE, Source

    path = film_file(folder / "pitch.stl", [CONCAVE] * GROOVES, length=20.0)
    stack = read_stack(STACK)
    scene = build_scene(lower_stack(stack, read_film_mesh(path)))
    source = Source(EYE, np.linspace(0, 1, 33) * stack.period.across, 1.0)
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
