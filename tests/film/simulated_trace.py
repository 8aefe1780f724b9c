"""Stylus traces of known truth: a profiler's faults one by one, drawn from a seed."""

from dataclasses import dataclass

import numpy as np

from mpfcad.film import Groove, StylusTip, StylusTrace
from mpfcad.film.stylus.tip import dilate

RADII = (0.7e-3, 2e-3, 2.5e-3, 5e-3, 12.5e-3)


@dataclass(frozen=True)
class Simulated:
    """A trace, and the curvature [1/mm] and the mean fill of its coupon.

    A trace crosses some grooves of the coupon: their mean fill is not what an interval is of.
    """

    trace: StylusTrace
    curvature: float
    fill: float


def simulate(seed, *, off=0.03, marks=0.04, waves=0.4e-3, spikes=0.003, noise=4e-5, radius=None):
    """Return a trace with all faults, drawn; the tip acts by dilation of a fine surface."""
    rng = np.random.default_rng(seed)
    groove = Groove(0.05 * (1 + rng.uniform(-off, off)), 0.025 * (1 + rng.uniform(-off, off)))
    tip = StylusTip(
        rng.choice(RADII) if radius is None else radius, np.radians(rng.choice([60, 90]))
    )
    step = 2.5e-5
    x = np.arange(0.0, rng.uniform(0.3, 0.8), step)
    shift = rng.uniform(0, groove.pitch)
    number = np.floor((x + shift) / groove.pitch).astype(int)
    local = (x + shift) - (number + 0.5) * groove.pitch
    # Marks of the screen's threads: the fill follows them from groove to groove.
    threads = rng.uniform(0.055, 0.11)
    mean = rng.uniform(25.0, 76.0)
    each = mean * (1 + marks * np.cos(2 * np.pi * np.arange(number.max() + 1) * groove.pitch / threads
                                      + rng.uniform(0, 6.3)))  # fmt: skip
    each = np.minimum(each, groove.curvature_empty)
    surface = groove.height(local, each[number])
    traced = dilate(surface, step, tip, periodic=False)
    at = np.arange(400, len(x) - 400, int(rng.integers(6, 14)))
    z = traced[at] + rng.uniform(-0.03, 0.03) * x[at]
    z += rng.uniform(0, waves) * np.sin(
        2 * np.pi * x[at] / rng.uniform(0.15, 1.5) + rng.uniform(0, 6.3)
    )
    z += rng.normal(0, noise, len(at)) + _correlated(rng, len(at)) * noise
    hit = rng.random(len(at)) < spikes
    z[hit] += rng.choice([-1, 1], hit.sum()) * rng.uniform(5e-4, 5e-3, hit.sum())
    trace = StylusTrace(x[at] + 2.0, z, "t.csv", tip)
    turn = np.cos(np.linspace(0.0, 2 * np.pi, 720, endpoint=False))
    coupon = np.minimum(mean * (1 + marks * turn), groove.curvature_empty)
    return Simulated(trace, float(mean), float(np.mean(groove.fill_fraction(coupon))))


def _correlated(rng, count):
    noise = np.convolve(rng.normal(0, 1, count + 19), np.ones(20), "valid")
    return noise / np.sqrt(20)
