"""How fast this machine traces: a plain prism film in the reference stack, for a moment."""

import time

from mpfcad.measure import LEAST_PATHS, TraceRun, luminance_over_pitch
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.run.examine import light_baseline


def trace_speed() -> tuple[float, float]:
    """Return seconds until the tracer was ready, and millions of paths a second on all cores."""
    lit = light_baseline(0.5)
    start = time.monotonic()
    luminance_over_pitch(lit, TraceRun(path_limit=1000), half_width_goal=0.0)
    ready = time.monotonic()
    run = TraceRun(seed=2, threads=available_threads(), path_limit=LEAST_PATHS)
    result = luminance_over_pitch(lit, run, half_width_goal=0.0)
    return ready - start, result.paths / (time.monotonic() - ready) / 1e6
