"""Standard errors from independent nets are honest: intervals hold as often as they say."""

import numpy as np
import pytest
from harness import CONCAVE, film_mesh

from mpfcad.measure import contrast_of_harmonics, fit_harmonics
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
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


@pytest.mark.slow
def test_intervals_over_a_lamp_pitch_hold_the_truth():
    cavity = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
    elements = [cavity, Slab(1.49, 2.0, 0.6, 0.0036, 0.8), Sheet(0.36, 1.49, 0.98)]
    position = np.linspace(0, 1, 33)
    value, error, _ = runs(elements, Source(EYE, 32.69 * position, 1.0, acceptance=0.017), 4)
    assert 0.93 <= covered(value, error) <= 0.97

    def contrast(luminance, its_error):
        return contrast_of_harmonics(fit_harmonics(position, luminance, its_error), 0)

    truth = contrast(value.mean(axis=0), error.mean(axis=0) / np.sqrt(RUNS)).value
    found = [contrast(v, e) for v, e in zip(value, error, strict=True)]
    share = np.mean([estimate.low <= truth <= estimate.high for estimate in found])
    # 2.5 binomial sigma about 0.93 … 0.975, what the intervals hold with known errors.
    assert 0.93 - 2.5 * np.sqrt(0.93 * 0.07 / RUNS) <= share
    assert share <= 0.975 + 2.5 * np.sqrt(0.975 * 0.025 / RUNS)
