"""The tracer as a whole: the same bits on any number of threads, and both accelerators alike."""

import numpy as np
import pytest
from harness import CONCAVE, film_mesh, groove, single_paths

from mpfcad.optics.base.recorder import FLOWS, Tally
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.engine import BLOCK, trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, LAMPS, Source

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
LAYERS = [Slab(1.49, 2.0), Sheet(0.36, 1.49, 0.98)]
TOP = Sheet(0.35, 1.49, 0.98)
PATTERN = [groove(c) for c in (57.0, 40.0001, 70.0)]
METER = Source(EYE, np.linspace(0, 32.69, 3), 1.0, acceptance=0.017)


def mpf(folder, grooves=PATTERN, accelerator=None):
    film = Film(film_mesh(folder, grooves), 1.55, offset=0.02, accelerator=accelerator)
    return [CAVITY, *LAYERS, film, TOP]


def same(a: Tally, b: Tally) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


@pytest.mark.parametrize("accelerator", ["chain", "bvh"])
@pytest.mark.parametrize("source", [METER, Source(LAMPS, np.zeros(1), 0.0)], ids=["eye", "lamps"])
def test_same_bits_at_any_number_of_threads(tmp_path, source, accelerator):
    scene = build_scene(mpf(tmp_path, accelerator=accelerator))
    one = trace(scene, source, 9, seed=3, threads=1)
    assert one.score.all() or source.kind != EYE
    for threads in (2, 3, 8):
        assert same(one, trace(scene, source, 9, seed=3, threads=threads))


def test_blocks_may_be_traced_in_parts(tmp_path):
    scene = build_scene(mpf(tmp_path))
    whole = trace(scene, METER, 6, seed=3)
    parts = Tally.empty(3, len(whole.flow))
    for first in range(6):
        parts = parts + trace(scene, METER, 1, seed=3, first=first)
    assert same(whole, parts)
    assert whole.total_paths == 6 * 3 * BLOCK


def test_another_seed_gives_other_numbers_that_agree(tmp_path):
    scene = build_scene(mpf(tmp_path))
    tallies = [trace(scene, METER, 8, seed=s) for s in (1, 2, 2**40 + 1)]
    for a in range(3):
        for b in range(a):
            assert not same(tallies[a], tallies[b])
            error = np.hypot(tallies[a].radiance_error, tallies[b].radiance_error)
            away = (tallies[a].radiance - tallies[b].radiance) / error
            assert np.abs(away).max() < 4


@pytest.mark.parametrize(
    "grooves", [[CONCAVE], PATTERN, [groove(40.0001)] * 2], ids=["concave", "pattern", "sliver"]
)
def test_both_accelerators_give_the_same_paths(tmp_path, grooves):
    paths = []
    for accelerator in ("chain", "bvh"):
        elements = mpf(tmp_path, grooves, accelerator)
        paths.append(np.empty(5000))
        flow = np.zeros(len(FLOWS) + len(elements))
        single_paths(build_scene(elements), METER, 5, 0, paths[-1], flow)
    differs = np.abs(paths[0] - paths[1]) / paths[0].max()
    # A lamp is a convex mirror of 1.7 mm radius: a last-bit difference in place grows 10…100 times
    # at each, so that one path in some 10,000 (with many lamps in it) ends on another facet. Not
    # so in the film alone (below), where every path is the same. What lamps give directly to the
    # reflector shows smaller differences of the place, in some more paths.
    assert np.mean(differs > 1e-6) <= 1e-3
    assert np.mean(differs > 1e-9) <= 5e-3


def test_both_accelerators_give_the_same_film_values(tmp_path):
    # Analog paths of a film alone: counts, so equal exactly.
    results = []
    for accelerator in ("chain", "bvh"):
        film = Film(film_mesh(tmp_path, PATTERN), 1.5, accelerator=accelerator)
        results.append(trace(build_scene([film]), Source(LAMBERTIAN_BELOW, np.zeros(1), 0.05), 60))
    assert same(*results)


def test_a_tally_knows_its_errors():
    # Blocks of 10 paths that share a part: their means scatter more than 10 alone would.
    rng = np.random.default_rng(1)
    values = rng.exponential(size=(400, 10, 2)) + rng.exponential(size=(400, 1, 2))
    sums, flow = values.sum(axis=1), values.sum(axis=(1, 2))
    tally = Tally(
        sums.sum(0), (values**2).sum((0, 1)), (sums**2).sum(0), np.full(3, flow.sum()),
        np.full(3, (flow**2).sum()), 4000, 400,
    )  # fmt: skip
    assert tally.radiance == pytest.approx(values.mean((0, 1)))
    error = sums.std(0, ddof=1) / 10 / np.sqrt(400)
    # A fourteenth of the variance's ratio is that of both points.
    assert tally.radiance_error == pytest.approx(error, rel=0.01)
    assert tally.fraction_error == pytest.approx(flow.std(ddof=1) / 20 / np.sqrt(400), rel=1e-9)
    assert tally.total_paths == 8000


def test_flows_are_shares_of_the_paths(tmp_path):
    scene = build_scene(mpf(tmp_path))
    tally = trace(scene, METER, 20, seed=4)
    share = dict(zip((*FLOWS, "cavity", "plate", "bottom", "film", "top"), tally.fraction))  # noqa: B905
    assert share["lost"] == 0 and share["film"] == 0 and share["plate"] == 0
    assert share["lamps"] > 0 and share["cavity"] > 0 and share["bottom"] > 0
    # Backward paths conserve weight too: one in, all of it out, absorbed or in the roulette.
    assert sum(share.values()) == pytest.approx(1, abs=1e-12)


def test_an_exception_in_a_callback_stops_the_trace(tmp_path):
    scene = build_scene(mpf(tmp_path))

    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        trace(scene, METER, 50, threads=2, after_block=stop)
