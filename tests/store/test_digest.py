"""A key counts everything that is in a value."""

from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

from mpfcad.store import value_hash, work_key


@dataclass(frozen=True)
class Lamp:
    pitch: float
    place: tuple[float, ...] = ()
    file: Path | None = None


class Tube(Lamp):
    """Another kind with the same fields."""


class Job(BaseModel):
    name: str = "a"


class Colour(Enum):
    RED = 1
    BLUE = 2


VALUES = [
    None, True, 1, 1.0, -0.0, 0.0, "1", b"1", [1], (1,), [1, [2]], [[1], 2], {1: 2}, {2: 1}, {1, 2},
    float("nan"), float("inf"), np.float32(1), np.float64(1), np.zeros(2), np.zeros((2, 1)),
    np.zeros(2, np.int64), np.array([0.0, -0.0]), Lamp(1.0), Lamp(1.0, (2.0,)), Tube(1.0),
    Job(), Job(name="b"), Colour.RED, Colour.BLUE, Path("nowhere"), "nowhere", [], {}, (), "",
    ["a", "b"], ["ab", ""],
]  # fmt: skip


def test_no_two_values_are_one():
    assert len({value_hash(value) for value in VALUES}) == len(VALUES)


def test_equal_values_are_one():
    assert value_hash({"a": 1, "b": 2}) == value_hash({"b": 2, "a": 1})
    assert value_hash(np.arange(6)[::2]) == value_hash(np.array([0, 2, 4]))
    assert value_hash(Lamp(1.0)) == value_hash(replace(Lamp(2.0), pitch=1.0))


def test_a_file_counts_by_its_content(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_text("C"), two.write_text("C")
    assert value_hash(Lamp(1.0, file=one)) == value_hash(Lamp(1.0, file=two))
    two.write_text("D")
    assert value_hash(Lamp(1.0, file=one)) != value_hash(Lamp(1.0, file=two))


def test_what_a_function_does_is_in_no_key():
    for value in (len, [lambda: 1], Lamp):
        with pytest.raises(TypeError, match="cannot be part of a key"):
            value_hash(value)


def test_a_key_counts_kind_code_and_libraries(monkeypatch):
    key = work_key("trace", [1])
    assert key != work_key("point", [1])
    with monkeypatch.context() as patch:
        patch.setattr("mpfcad.store.digest.work_hash", lambda kind: "0" * 64)
        assert work_key("trace", [1]) != key
    with monkeypatch.context() as patch:
        patch.setattr("mpfcad.store.digest.all_versions", lambda: {"numpy": "0"})
        assert work_key("trace", [1]) != key
    assert work_key("trace", [1]) == key
