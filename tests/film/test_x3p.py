"""ISO 5436-2 archives: the same heights from a list, from binary data and of a profile."""

import zipfile

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.film import Groove, read_stylus_trace
from mpfcad.film.stylus.file.x3p import read_x3p

BEF = Groove(0.05, 0.025)
AXIS = "<C{0}><AxisType>{1}</AxisType><DataType>{2}</DataType><Increment>{3}</Increment></C{0}>"


def archive(path, *, feature="PRF", axes, size, record, bits=None, data=b"", folder=""):
    """Write an archive of main.xml, with bindata/data.bin where there is data."""
    text = "".join(AXIS.format(*axis) for axis in axes)
    dimension = "".join(f"<Size{a}>{n}</Size{a}>" for a, n in zip("XYZ", size, strict=True))
    main = (
        '<?xml version="1.0"?><p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">'
        f"<Record1><FeatureType>{feature}</FeatureType><Axes>{text}</Axes></Record1><Record3>"
        f"<MatrixDimension>{dimension}</MatrixDimension>{record}</Record3></p:ISO5436_2>"
    )
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(f"{folder}main.xml", main)
        if data:
            file.writestr(f"{folder}bindata/data.bin", data)
        if bits:
            file.writestr(f"{folder}bindata/valid.bin", bits)
    return path


LINK = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink>{}</DataLink>"
VALID = "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>"
X = np.arange(1201) * 0.25e-6
Z = BEF.height((X * 1e3 + 0.0071) % 0.05 - 0.025, 60.0) * 1e-3


def test_a_profile_in_binary_or_as_a_list_is_the_same(tmp_path):
    step, count = 1e-9, np.round(Z / 1e-9).astype("<i4")
    binary = archive(
        tmp_path / "a.x3p", axes=[("X", "I", "D", 0.25e-6), ("Z", "A", "L", step)],
        size=(1201, 1, 1), record=LINK.format(""), data=count.tobytes(), folder="scan/",
    )  # fmt: skip
    rows = "".join(
        f"<Datum>{x!r};{z!r}</Datum>" for x, z in zip(X.tolist(), Z.tolist(), strict=True)
    )
    listed = archive(
        tmp_path / "b.x3p", axes=[("X", "A", "D", 1), ("Z", "A", "D", 1)],
        size=(1201, 1, 1), record=f"<DataList>{rows}</DataList>",
    )  # fmt: skip
    for path in (binary, listed):
        trace = read_stylus_trace(path, BEF)
        assert trace.position == pytest.approx(X * 1e3, abs=1e-9)
        assert trace.height == pytest.approx(Z * 1e3, abs=0.6e-6)
        assert "x3p, PRF" in trace.reading


def test_points_that_are_not_valid_are_left_out(tmp_path):
    """Valid bits run from the lowest up: here all but the eighth."""
    path = archive(
        tmp_path / "a.x3p", axes=[("X", "I", "D", 1e-6), ("Z", "A", "F", 1)], size=(16, 1, 1),
        record=LINK.format(VALID), data=np.arange(16, dtype="<f4").tobytes(), bits=b"\x7f\xff",
    )  # fmt: skip
    height = read_x3p(path).height
    assert np.flatnonzero(np.isnan(height)).tolist() == [7]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"feature": "PCL"}, "FeatureType: PCL: expected PRF or SUR"),
        ({"size": (15, 1, 1)}, "64 bytes: expected 60, 15 heights"),
        ({"size": (16, 1, 2)}, "SizeZ: 2: expected 1 height a place"),
        ({"data": b""}, "bindata/data.bin: not in the archive: expected what main.xml names"),
        ({"axes": [("X", "I", "D", 0), ("Z", "A", "F", 1)]}, "CX: Increment: 0: expected"),
    ],
)
def test_what_is_not_as_the_standard_says_is_refused(tmp_path, change, words):
    given = {
        "axes": [("X", "I", "D", 1e-6), ("Z", "A", "F", 1)],
        "size": (16, 1, 1),
        "record": LINK.format(""),
        "data": np.arange(16, dtype="<f4").tobytes(),
    }
    with pytest.raises(InputError, match=words):
        read_x3p(archive(tmp_path / "a.x3p", **given | change))
