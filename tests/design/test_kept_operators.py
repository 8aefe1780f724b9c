"""The operators of a backlight's model are estimated once and kept, bit for bit."""

import numpy as np
import pytest
from conftest import build_operators

from mpfcad.backlight import read_stack
from mpfcad.film import Groove
from mpfcad.pipeline.design import operators
from mpfcad.store import Store


@pytest.fixture
def asked(monkeypatch):
    """Return the list of estimates that were asked for; each is one written down by hand."""
    calls = []

    def estimate(*arguments, **settings):
        calls.append((arguments, settings))
        return build_operators(0.02)

    monkeypatch.setattr(operators, "estimate_operators", estimate)
    return calls


def operators_of(store, stack="thesis-32in-mpf", threads=1, seed=1, base=0.2, **change):
    grid = build_operators(0.02).grid
    return operators.model_operators(
        store, read_stack(stack, **change), Groove(0.05, 0.025), base, "filled",
        np.linspace(20.0, 80.0, 6), grid=grid, seed=seed, threads=threads, progress=print,
    )  # fmt: skip


def test_operators_are_estimated_once(tmp_path, asked):
    store = Store(tmp_path, pytest.fail)
    first = operators_of(store)
    second = operators_of(store, threads=7)
    assert len(asked) == 1
    assert len(list((tmp_path / "design").iterdir())) == 1
    for name in ("node", "film", "radiance", "meter"):
        assert np.array_equal(getattr(first, name), getattr(second, name))
    state = np.linspace(0, 1, len(first.radiance))
    assert np.array_equal(first.world @ state, second.world @ state)
    assert (first.passages, first.segments) == (second.passages, second.segments)


@pytest.mark.parametrize(
    "change", [{"seed": 2}, {"base": 0.1}, {"thickness": 20.0}, {"stack": "thesis-32in-mpf-plate"}]
)
def test_another_backlight_film_or_seed_is_estimated_anew(tmp_path, asked, change):
    store = Store(tmp_path, pytest.fail)
    operators_of(store)
    operators_of(store, **change)
    assert len(asked) == 2


def test_damaged_operators_are_said_and_estimated_anew(tmp_path, asked):
    said = []
    store = Store(tmp_path, said.append)
    operators_of(store)
    (path,) = (tmp_path / "design").iterdir()
    path.write_bytes(path.read_bytes()[:-7])
    operators_of(store)
    assert len(asked) == 2 and len(said) == 1 and "does not verify" in said[0]
