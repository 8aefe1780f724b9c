"""An interrupted trace from LEDs goes on where it was, with the bits of one never interrupted."""

from dataclasses import asdict, replace

import pytest

from mpfcad.backlight import read_stack
from mpfcad.measure import (
    Checkpoints,
    Estimator,
    TraceRun,
    camera_image,
    led_spread,
    light_film,
    luminance_over_cell,
)
from mpfcad.store import Store, value_hash

GOAL, LIMIT = 1e-9, 500_000
_BOARD = """extends = "led-automotive-6mm"
layers = ["top_sheet"]
[value]
reflector_reflectance = 0.5
"""


def contrast(lit, run):
    return luminance_over_cell(lit, run, half_width_goal=GOAL)


def camera(lit, run):
    return camera_image(lit, run, GOAL)


def spread(lit, run):
    return led_spread(lit, run, GOAL)


def backward(lit, run):
    run = replace(run, estimator=Estimator.backward)
    return luminance_over_cell(lit, run, half_width_goal=GOAL)


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    file = tmp_path_factory.mktemp("board") / "board.toml"
    file.write_text(_BOARD)
    return light_film(read_stack(file), None)


def entries(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def traced(measure, lit, folder, progress=None, threads=1):
    with Checkpoints(Store(folder)) as checkpoints:
        return measure(lit, TraceRun(5, threads, LIMIT, checkpoints, progress))


@pytest.mark.parametrize("measure", [contrast, camera, spread, backward])
def test_a_resumed_trace_has_the_bits_of_an_uninterrupted_one(tmp_path, lit, measure):
    whole = traced(measure, lit, None)
    done = []

    def interrupt(state):
        done.append(state.paths)
        if state.paths > LIMIT - 20_000:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        traced(measure, lit, tmp_path, interrupt)
    (left,) = entries(tmp_path)
    assert left == Store(tmp_path).path("trace", left.stem)
    seen = []
    resumed = traced(measure, lit, tmp_path, seen.append, threads=2)
    assert min(done) < seen[0].start < seen[0].paths <= max(done)
    assert value_hash(asdict(resumed)) == value_hash(asdict(whole))
    assert entries(tmp_path) == []


def test_figures_of_the_same_paths_are_kept_apart(tmp_path, lit):
    # Both bin the cell alike; which of them ends first must not show in the other.
    keys = []
    for measure in (contrast, camera):
        with pytest.raises(ZeroDivisionError), Checkpoints(Store(tmp_path)) as checkpoints:
            measure(lit, TraceRun(5, 1, 1, checkpoints))
            raise ZeroDivisionError
        keys.append(set(entries(tmp_path)))
    assert len(keys[0]) == 1 and len(keys[1]) == 2
