"""A few kills of each command; `python -m tests.kill` is the long run."""

import pytest

from .attack import COMMANDS, attack, refused_work


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_kills_leave_no_mixed_export_and_no_damaged_work(tmp_path, command):
    sent, hits = attack(tmp_path, command, 6, seed=18)
    assert sent >= hits == 6


def test_the_run_sees_damaged_work(tmp_path):
    from mpfcad.store import Store

    store = Store(tmp_path)
    store.write("trace", "a" * 64, b"content")
    assert not refused_work(tmp_path)
    path = store.path("trace", "a" * 64)
    path.write_bytes(path.read_bytes()[:-1])
    assert refused_work(tmp_path)
