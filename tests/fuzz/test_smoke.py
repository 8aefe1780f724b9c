"""A short run of mutated files through every reader; `python -m tests.fuzz` is the long one."""

import time
from pathlib import Path

import pytest

from mpfcad.errors import InputError

from .reader import readers
from .run import fuzz

READERS = readers()
#: Files that the long run found, and that are mended: by the name of their reader.
CORPUS = Path(__file__).parent / "corpus"


@pytest.mark.parametrize("reader", READERS, ids=[reader.name for reader in READERS])
def test_mutated_files_are_read_or_refused_in_one_line(reader, tmp_path):
    count = 12 if reader.native or reader.costly else 60
    tally = fuzz(reader, count, seed=18, folder=tmp_path, seconds=8.0)
    assert not tally.faults, tally.faults[0][0]
    refused = tally.refused + tally.crashed
    assert refused > (tally.read + refused) / 8 and tally.outcomes > 0


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


def _rays_with(at, value):
    """Return a TM-25 file with another whole number in its header."""
    from .instrument import _rays

    data = bytearray(_rays(".tm25ray"))
    data[at : at + 4] = value.to_bytes(4, "little", signed=True)
    return bytes(data)


LINE = b"9" * 30_000 + b"x\n"
CR = b'x_mm,y_mm\n0,"a\r' + b"9" * 200_000 + b"\n"
FOUND = {path.name: path.read_bytes() for path in sorted(CORPUS.iterdir())} | {
    "curve-digits.csv": LINE * 3,
    "positions-carriage.csv": CR,
    "positions-field.csv": CR[:-1],
    "coupons-field.csv": CR.replace(b"x_mm,y_mm", b"file,aperture_ratio"),
    "rays.tm25ray-spectra.tm25ray": _rays_with(76, 2**31 - 1),
    "rays.tm25ray-spectrum.tm25ray": _rays_with(76, -1),
    "rays.tm25ray-text.tm25ray": _rays_with(84, -(2**31)),
    "rays.tm25ray-length.tm25ray": _rays_with(76, 1)[:36288] + (-(2**31)).to_bytes(
        4, "little", signed=True) + _rays_with(76, 1)[36288:],
}  # fmt: skip


@pytest.mark.parametrize("name", FOUND)
def test_a_file_that_the_long_run_found_is_refused_at_once(name, tmp_path):
    (reader,) = (one for one in READERS if one.name == name.partition("-")[0])
    path = tmp_path / f"in{reader.suffix}"
    path.write_bytes(FOUND[name])
    start = time.process_time()
    with pytest.raises(InputError, match=path.name):
        reader.read(path)
    assert time.process_time() - start < 5.0
