"""A short run of mutated files through every reader; `python -m tests.fuzz` is the long one."""

import pytest

from mpfcad.errors import InputError

from .reader import readers
from .run import fuzz

READERS = readers()


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_mutated_files_are_read_or_refused_in_one_line(reader, tmp_path):
    count = 12 if reader.native or reader.costly else 120
    tally = fuzz(reader, count, seed=18, folder=tmp_path, seconds=8.0)
    assert not tally.faults, tally.faults[0][0]
    assert tally.refused + tally.crashed > count / 8 and tally.outcomes > 0


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_a_file_to_begin_from_is_read(reader, tmp_path):
    """Else only the first lines of a reader would be reached."""
    if reader.name in ("manifest", "signature"):
        return
    read = 0
    for seed in reader.seeds:
        path = tmp_path / f"in{reader.suffix}"
        path.write_bytes(seed)
        try:
            reader.read(path)
            read += 1
        except InputError:
            pass
    assert read


def test_the_run_finds_a_reader_that_fails(tmp_path):
    from dataclasses import replace

    def careless(path):
        return path.read_bytes().decode()[3]

    tally = fuzz(replace(READERS[0], read=careless), 100, 1, tmp_path, 5.0)
    assert any("IndexError" in text or "UnicodeDecodeError" in text for text, _ in tally.faults)
