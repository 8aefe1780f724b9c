"""An entry is whole or absent; a change of any byte is said, set aside and computed again."""

import errno
import os
import random

import pytest

from mpfcad.store import Store, keep
from mpfcad.store.entry import list_entries, prune

KEY = "ab" * 32
VALUE = {"mean": 7401.25, "curve": [0.1, 1e-300, 3.5], "words": "µ"}


class Noted(list):
    """A store's listener."""

    __call__ = list.append


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store", Noted())


def damage(content: bytes, rng: random.Random) -> bytes:
    """Return a content with a bit flipped, bytes overwritten, cut off, doubled or put in."""
    data, at = bytearray(content), rng.randrange(len(content))
    how = rng.choice(("flip", "zero", "cut", "empty", "more", "insert", "remove", "swap"))
    if how == "flip":
        data[at] ^= 1 << rng.randrange(8)
    elif how == "zero":
        data[at : at + rng.randrange(1, 64)] = bytes(min(64, len(data) - at))
    elif how == "cut":
        del data[at:]
    elif how == "empty":
        data.clear()
    elif how == "more":
        data += rng.randbytes(rng.randrange(1, 9))
    elif how == "insert":
        data.insert(at, rng.randrange(256))
    elif how == "remove":
        del data[at]
    else:
        other = rng.randrange(len(data))
        data[at], data[other] = data[other], data[at]
    return bytes(data)


def assert_damage_is_found(store, times):
    store.keep_json("point", KEY, VALUE)
    path = store.path("point", KEY)
    whole, rng, tried = path.read_bytes(), random.Random(18), 0
    while tried < times:
        changed = damage(whole, rng)
        if changed == whole:
            continue
        tried += 1
        path.write_bytes(changed)
        store._note.clear()
        assert store.read_json("point", KEY) is None, changed
        (line,) = store._note
        assert str(path) in line and "does not verify" in line and "computed again" in line
        assert not path.exists() and path.with_suffix(".damaged").read_bytes() == changed
    path.write_bytes(whole)
    assert store.read_json("point", KEY) == VALUE


def test_any_damage_is_said_and_set_aside(store):
    assert_damage_is_found(store, 300)


@pytest.mark.slow
def test_ten_thousand_damages_are_all_found(store):
    assert_damage_is_found(store, 10_000)


def test_fresh_and_kept_are_the_same(store):
    assert store.keep_json("point", KEY, VALUE) == store.read_json("point", KEY) == VALUE
    assert [path.name for path in store.path("point", KEY).parent.iterdir()] == [KEY[:40] + ".kept"]


def test_an_entry_of_another_kind_key_or_code_is_not_taken(store, monkeypatch):
    store.keep_json("point", KEY, VALUE)
    other = KEY[:40] + "cd" * 12  # the same file name
    assert store.read_json("point", other) is None and "does not verify" in store._note[0]
    store.keep_json("point", KEY, VALUE)
    (store.folder / "figure").mkdir()
    store.path("point", KEY).replace(store.path("figure", KEY))
    assert store.read_json("figure", KEY) is None
    store.keep_json("point", KEY, VALUE)
    monkeypatch.setattr("mpfcad.store.keep.work_hash", lambda kind: "0" * 64)
    assert store.read_json("point", KEY) is None


def test_what_cannot_be_decoded_is_set_aside(store):
    store.write("point", KEY, b"{")
    assert store.read_json("point", KEY) is None
    assert "JSONDecodeError" in store._note[0]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EDQUOT])
def test_a_full_disk_is_said_once_and_nothing_half_written_stays(store, monkeypatch, number):
    def fail(descriptor):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", fail)
    for key in (KEY, KEY[::-1]):
        assert store.keep_json("point", key, VALUE) == VALUE
        assert store.read_json("point", key) is None
    (line,) = store._note
    assert os.strerror(number) in line and "not kept" in line
    assert list((store.folder / "point").iterdir()) == []


def test_a_folder_that_cannot_be_made_is_said_once(tmp_path):
    (tmp_path / "file").write_text("")
    store = Store(tmp_path / "file" / "below", Noted())
    assert store.read_json("point", KEY) is None
    assert store.keep_json("point", KEY, VALUE) == VALUE
    assert len(store._note) <= 2 and "not kept" in store._note[-1]


def test_without_a_folder_nothing_is_kept():
    store = Store()
    assert store.keep_json("point", KEY, VALUE) == VALUE
    assert store.read_json("point", KEY) is None
    store.drop("point", KEY)


def test_pruning_takes_only_what_no_run_can_use(store, monkeypatch):
    store.keep_json("point", KEY, VALUE)
    (store.folder / "point" / "notes.txt").write_text("mine")
    store.write("figure", KEY, b"{")
    store.read_json("figure", KEY)
    part = store.folder / "trace" / ".x.1.aa.part"
    part.parent.mkdir()
    part.write_bytes(b"half")
    os.utime(part, (0, 0))
    (store.folder / "trace" / ".y.1.aa.part").write_bytes(b"being written")
    states = {entry.state for entry in list_entries(store.folder)}
    assert states == {"kept", "damaged", "part"}
    assert {e.state for e in prune(store.folder)} == {"damaged", "part"}
    assert store.read_json("point", KEY) == VALUE
    os.utime(store.path("point", KEY), (0, 0))
    assert prune(store.folder) == []
    assert len(prune(store.folder, days=30)) == 1
    store.keep_json("point", KEY, VALUE)
    monkeypatch.setattr("mpfcad.store.keep.work_hash", lambda kind: "0" * 64)
    assert [e.state for e in prune(store.folder)] == ["old"]
    assert sorted(p.name for p in store.folder.rglob("*") if p.is_file()) == [
        ".y.1.aa.part", "notes.txt",
    ]  # fmt: skip


def test_what_is_kept_is_known(tmp_path, monkeypatch):
    monkeypatch.setattr(keep, "_touched", set())
    store = Store(tmp_path)
    store.write("kernel", "a" * 64, b"code")
    assert not keep.is_work_kept()
    store.write("trace", "b" * 64, b"tally")
    assert keep.is_work_kept()
    store.drop("trace", "b" * 64)
    assert not keep.is_work_kept()
    store.write("point", "c" * 64, b"1")
    monkeypatch.setattr(keep, "_touched", set())
    assert store.read("point", "d" * 64, bytes) is None and not keep.is_work_kept()
    assert store.read("point", "c" * 64, bytes) == b"1" and keep.is_work_kept()
