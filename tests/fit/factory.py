"""A simulated factory: smooth made-up backlights whose true values are hidden from the fit."""

import numpy as np

from mpfcad.confidence import Factor
from mpfcad.fit import Datum, Figured, build_unknowns
from mpfcad.fit.reading import FLUX, PITCH, contrast, entry_of, harmonics_of, luminance

NAMES = ("top_sheet_sigma", "reflector_reflectance", "lamp_height_mm", "plate_absorption_per_mm")
VIEWS = [("a", PITCH), ("b", PITCH), ("a", FLUX), ("b", FLUX)]
#: A film that is not measured: its contrast is the least that its cosines can have, or clear.
FLAT, CLEAR = ("flat", PITCH), ("clear", PITCH)


def unknowns(free=(), luminance_too=True):
    """Return four values of a backlight, and the lamps' luminance without prior."""
    factors = [
        Factor("top_sheet_sigma", 0.35, 0.028, 0.0, 10.0),
        Factor("reflector_reflectance", 0.94, 0.01, 0.0, 1.0),
        Factor("lamp_height_mm", 3.5, 0.3, 0.0, 100.0),
        Factor("plate_absorption_per_mm", 0.0036, 0.0011, 0.0, 100.0),
    ]
    if luminance_too:
        factors.append(Factor("lamp_luminance_cd_m2", 20000.0, 10000.0))
        free = {*free, "lamp_luminance_cd_m2"}
    return build_unknowns(factors, set(free), {"lamp_luminance_cd_m2"})


class Factory:
    """Readings that bend with the values, with the noise of a trace that is common to all runs."""

    def __init__(self, noise, seed):
        rng = np.random.Generator(np.random.Philox(seed))
        # The same backlight for all: what differs are the traces' random numbers.
        of_case = np.random.Generator(np.random.Philox(77))
        self.slope = {
            v: of_case.normal(size=(4, 4 if v[1] == PITCH else 2)) for v in [*VIEWS, FLAT, CLEAR]
        }
        self.noise = noise
        self.common = {v: rng.normal(size=4 if v[1] == PITCH else 2) for v in [*VIEWS, FLAT, CLEAR]}
        self.rng = rng

    def truth(self, view, steps):
        z = np.asarray(steps)[:4]
        bent = z + 0.06 * z**2
        if view[1] == PITCH:
            size = np.array([0.01, 0.006, 0.002, 0.0005])
            first = {FLAT: 0.0, CLEAR: 0.03}.get(view, 0.011)
            base = np.array([8.9, first, 0.0 if view == FLAT else 0.002, 0.0])
            cross = 0.1 * size * z[0] * z[1]
        else:
            size, base, cross = np.array([0.01, 0.01]), np.array([-0.7, 7.0]), 0.0
        found = base + size * (bent @ self.slope[view]) + cross
        if len(steps) > 4 and view[1] == PITCH:
            found[0] += 0.5 * steps[4]
        return found

    def trace(self, view, steps, *, middle):
        size = self.noise * (0.3 if middle else 1.0)
        scale = np.full(4 if view[1] == PITCH else 2, size)
        truth = self.truth(view, np.r_[steps[:4], np.zeros(0)])
        if len(steps) > 4:
            truth = self.truth(view, steps)
        own = self.rng.normal(size=len(scale)) * scale
        found = truth + 0.5 * scale * self.common[view] + own
        return found, np.diag(1.25 * scale**2)

    def active(self, view):
        return np.array([True] * 4 + [False])

    def known(self, view):
        found = np.zeros((5, 4 if view[1] == PITCH else 2))
        if view[1] == PITCH:
            found[4, 0] = 0.5
        return found


FIGURES = [
    (Figured("luminance of a", ("a", PITCH), luminance), 40.0),
    (Figured("b over a: luminance", ("b", PITCH), luminance, ("a", PITCH)), 0.003),
    (Figured("contrast of a", ("a", PITCH), contrast), 0.0007),
    (Figured("cosines of b", ("b", PITCH), harmonics_of(2)), 0.0007),
    (Figured("b over a: flux", ("b", FLUX), entry_of(0), ("a", FLUX)), 0.004),
]
FLAT_FILM = Figured("contrast of a flat film", FLAT, contrast)
CLEAR_FILM = Figured("contrast of a clear film", CLEAR, contrast)
NEW_FILM = Figured("efficiency of b", ("b", FLUX), entry_of(0))


def exactly(factory, figured, steps):
    """Return a figure of the true backlight, without noise."""

    class Exact:
        start_covariance = None

        def __init__(self, view):
            self.view = view
            m = 4 if view[1] == PITCH else 2
            self.start_covariance = np.zeros((m, m))

        def reading(self, z):
            return factory.truth(self.view, z)

    return figured.predict({v: Exact(v) for v in figured.views}, steps)


def measured(factory, steps, rng):
    """Return the five measurements of a backlight at true steps, each with its error."""
    data = []
    for figured, sigma in FIGURES:
        value = exactly(factory, figured, steps)
        value = value + sigma * rng.normal(size=len(value))
        data.append(Datum(figured, value, np.eye(len(value)) * sigma**2, label=("",) * len(value)))
    return data
