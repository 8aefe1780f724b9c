"""Ray files written: exact headers, read back, the same bytes however the rays come."""

import struct

import numpy as np
import pytest

from mpfcad.backlight.source.ray_file import read_rays
from mpfcad.backlight.source.ray_write import About, check_ray_suffix, write_ray_file
from mpfcad.errors import InputError

ABOUT = About("BEF in a stack", "mpfcad 1", "mm; seed 1; ü")


def rays(count=5000):
    """Return Lambertian rays (n, 7) float32 of different flux."""
    rng = np.random.default_rng(8)
    k, turn = np.sqrt(rng.random(count)), rng.random(count) * 2 * np.pi
    place = rng.uniform(-300, 300, (count, 3)) * (1, 1, 0)
    direction = np.stack([k * np.cos(turn), k * np.sin(turn), np.sqrt(1 - k * k)], axis=1)
    flux = rng.uniform(0.1, 1, (count, 1))
    return np.concatenate([place, direction, flux], axis=1).astype("<f4")


def written(path, table, step=5000, unit=0.25):
    def collect(keep):
        for i in range(0, len(table), step):
            keep(table[i : i + step])
        return unit

    return write_ray_file(path, path.suffix, ABOUT, collect)


@pytest.mark.parametrize("form", [".tm25ray", ".tm25", ".dat", ".ray"])
def test_rays_read_back_with_their_flux(tmp_path, form):
    table, path = rays(), tmp_path / f"screen{form}"
    flux = written(path, table)
    found = read_rays("x", path)
    assert np.array_equal(found[:, :6], table[:, :6].astype(float))
    assert np.array_equal(found[:, 6], table[:, 6].astype(float) * 0.25)
    assert flux == pytest.approx(found[:, 6].sum(), rel=1e-12)
    again = tmp_path / f"again{form}"
    written(again, table, step=777)
    assert path.read_bytes() == again.read_bytes()


def test_a_tm25_header_stands_at_its_places(tmp_path):
    flux = written(tmp_path / "a.tm25ray", rays(10))
    data = (tmp_path / "a.tm25ray").read_bytes()
    assert len(data) == 36288 + 10 * 28
    assert data[:4] == b"TM25" and struct.unpack_from("<2i", data, 4) == (2013, 0)
    lm, watt, count = struct.unpack_from("<2fQ", data, 12)
    assert (lm, count) == (np.float32(flux), 10) and np.isnan(watt)
    assert data[28:56] == bytes(28)  # no date
    start, spectrum, *wave, spectra, extra, text = struct.unpack_from("<2i3f3i", data, 56)
    assert (start, spectrum, spectra, extra, text) == (0, 0, 0, 0, 0) and np.isnan(wave).all()
    assert data[88:256] == bytes(168)
    assert struct.unpack_from("<8i", data, 256) == (1, 1, 0, 0, 1, 0, 0, 0)
    texts = [data[288 + 4000 * i : 4288 + 4000 * i].decode("utf-32-le") for i in range(9)]
    assert texts[0].rstrip("\0") == ABOUT.source and texts[7].rstrip("\0") == ABOUT.note
    assert texts[3].rstrip("\0") == ABOUT.creator


def test_a_zemax_header_stands_at_its_places(tmp_path):
    flux = np.float32(written(tmp_path / "a.dat", rays(10)))
    data = (tmp_path / "a.dat").read_bytes()
    assert len(data) == 208 + 10 * 28
    assert struct.unpack_from("<iI", data) == (1010, 10)
    assert data[8:108].rstrip(b"\0") == b"mpfcad 1: BEF in a stack"
    assert struct.unpack_from("<3f", data, 108) == (flux, flux, 0.0)
    assert struct.unpack_from("<I9f", data, 136) == (4, 0, 0, 0, 0, 0, 0, 1, 1, 1)
    assert struct.unpack_from("<4i", data, 192) == (0, 1, 0, 0)  # flux alone, in lm


def test_a_light_tools_header_stands_at_its_places(tmp_path):
    flux = np.float32(written(tmp_path / "a.ray", rays(10)))
    data = (tmp_path / "a.ray").read_bytes()
    assert data[:4] == b"LTRF" and data[-7:] == b"LTRFEND" and len(data) == 44 + 10 * 28 + 7
    # Version, photometric, with places, no colour, mm, origin, flux.
    assert struct.unpack_from("<6I4f", data, 4) == (2, 0, 1, 0, 0, 1, 0, 0, 0, flux)


def test_what_light_tools_writes_besides_is_refused(tmp_path):
    for place, value in ((4, 3), (16, 1), (20, 1)):
        written(tmp_path / "a.ray", rays(10))
        data = bytearray((tmp_path / "a.ray").read_bytes())
        data[place] = value
        (tmp_path / "a.ray").write_bytes(data)
        with pytest.raises(InputError, match="expected version 2, places"):
            read_rays("a.ray", tmp_path / "a.ray")


def test_an_unknown_ending_names_those_known(tmp_path):
    assert check_ray_suffix("--out", tmp_path / "a.DAT") == ".dat"
    for name in ("a.ies", "a"):
        with pytest.raises(InputError, match=r"--out: .*expected an ending of \.tm25ray \(IES"):
            check_ray_suffix("--out", tmp_path / name)
