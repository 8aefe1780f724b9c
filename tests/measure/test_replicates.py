"""Standard errors from independent nets are honest: intervals hold as often as they say."""

import numpy as np
from harness import CONCAVE, film_mesh

from mpfcad.optics.element import Film
from mpfcad.optics.engine import trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source

RUNS = 400


def runs(elements, source, blocks, below=0.0):
    """Return (luminances, standard errors, paths' own errors) of many small traces, (runs, p)."""
    scene = build_scene(elements, below=below)
    tallies = [trace(scene, source, blocks, seed=1000 + seed) for seed in range(RUNS)]
    alone = [np.sqrt((t.score2 / t.paths - t.radiance**2) / t.paths) for t in tallies]
    return tuple(
        map(np.array, ([t.radiance for t in tallies], [t.radiance_error for t in tallies], alone))
    )


def covered(value, error):
    """Return how often 95 % intervals hold the mean of all runs, its error a 20th of theirs."""
    return np.mean(np.abs(value - value.mean(axis=0)) <= 1.96 * error)


def test_intervals_of_a_film_hold_the_truth(tmp_path):
    # Three points, 16 nets each. Seeds 1000 … 1399.
    film = Film(film_mesh(tmp_path, [CONCAVE] * 4), 1.5)
    value, error, alone = runs([film], Source(EYE, np.full(3, 0.1), 0.05), 16, below=1.0)
    assert 0.93 <= covered(value, error) <= 0.97
    # Paths taken as independent would say an error more than 1.8 times as large as it is.
    assert alone.mean() > 1.8 * error.mean()
    assert covered(value, alone) > 0.998
