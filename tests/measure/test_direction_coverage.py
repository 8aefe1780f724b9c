"""Each direction's interval holds the truth as often as it says."""

import numpy as np
import pytest
from harness import BARE, film_mesh, groove
from oracle.ray import reflectance

from mpfcad.measure import reach
from mpfcad.optics.element import Film, Sheet, Slab
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source

ANGLES = np.radians(np.arange(0, 81, 10))
BLOCKS = 8


def held(scene, runs, truth=None):
    """Return the share of runs whose interval held the truth, a direction, (9,).

    Truth: given, or that of all runs together, known √runs times better.
    """
    source = Source(
        EYE, np.full(9, 0.1), 0.1, tilt_x=-np.sin(ANGLES), acceptance=np.sin(np.radians(1.0))
    )
    found = [trace(scene, source, BLOCKS, seed=2000 + i) for i in range(runs)]
    value = np.array([t.radiance for t in found])
    error = np.array([t.own_error for t in found])
    truth = value.mean(axis=0) if truth is None else truth
    share = np.mean(np.abs(value - truth) <= reach(BLOCKS - 1) * error, axis=0)
    print(np.round(share, 3))
    return share


def slack(runs):
    """Return 2.8 sigma of a count: one of nine directions goes beyond by chance in 20 tests."""
    return 2.8 * np.sqrt(0.05 * 0.95 / runs)


def bare_plate():
    return build_scene([Slab(1.49, 2.0)], below=1.0)


def plate_transmittance():
    """Return (1-R)/(1+R) of a plate without loss, averaged over the cone of 1°."""
    cosine = np.cos(ANGLES)
    spread = np.linspace(-1, 1, 401) * np.radians(1.0)
    weight = np.sqrt(np.maximum(0, 1 - (spread / spread[-1]) ** 2))
    found = []
    for c in cosine:
        r = np.array([reflectance(abs(np.cos(np.arccos(c) + s)), 1.0, 1.49) for s in spread])
        found.append(np.sum(weight * (1 - r) / (1 + r)) / weight.sum())
    return np.array(found)


def test_each_direction_of_a_bare_plate_holds_its_closed_form():
    share = held(bare_plate(), 150, plate_transmittance())
    assert (share >= 0.93 - slack(150)).all()
    assert (share <= 0.97 + slack(150)).all()


@pytest.mark.slow
@pytest.mark.parametrize("what", ["plate", "BEF", "film and sheets"])
def test_each_direction_holds_over_many_runs(tmp_path, what):
    if what == "plate":
        share = held(bare_plate(), 1000, plate_transmittance())
    else:
        film = Film(film_mesh(tmp_path, [BARE if what == "BEF" else groove(60.0)] * 2), 1.55)
        sheets = [] if what == "BEF" else [Sheet(0.36, 1.49, 0.98)]
        share = held(build_scene([*sheets, film, *sheets], below=1.0), 1000)
    assert (share >= 0.93 - slack(1000)).all()
    assert (share <= 0.97 + slack(1000)).all()
