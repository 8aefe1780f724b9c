"""Photometric files as makers write them: EULUMDAT of every symmetry, IES of every year."""

import numpy as np
import pytest

from mpfcad.backlight.source.emission import read_emission
from mpfcad.backlight.source.eulumdat import read_eulumdat
from mpfcad.errors import InputError

POLAR = np.arange(0.0, 91.0, 15.0)
ROUND = np.arange(0.0, 360.0, 30.0)
#: What lies beside the axis, by symmetry: nothing is alike, all, C and -C, C and 180° - C, both.
BESIDE = {
    0: lambda c: 1 + c / 720,
    1: lambda c: np.ones_like(c),
    2: lambda c: 2 + np.cos(np.radians(c)),
    3: lambda c: 2 + np.sin(np.radians(c)),
    4: lambda c: 2 + np.cos(np.radians(2 * c)),
}
STORED = {
    0: ROUND,
    1: ROUND[:1],
    2: ROUND[:7],
    3: np.concatenate([ROUND[9:], ROUND[:4]]),
    4: ROUND[:4],
}


def light(azimuth, symmetry):
    return np.outer(BESIDE[symmetry](azimuth), np.cos(np.radians(POLAR))) * 100


def eulumdat(symmetry, mark=".", lamps=1):
    """Return a file: all planes are named, those are stored that symmetry does not give."""
    head = ["maker", 1, symmetry, len(ROUND), 30, len(POLAR), 15, *["x"] * 5, *[0] * 13, lamps]
    rows = [*head, *[1, "LED", 1000, 3000, 80, 10] * lamps, *[0] * 10, *ROUND, *POLAR]
    rows += list(light(STORED[symmetry], symmetry).ravel())
    return "\r\n".join(str(row).replace(".", mark) for row in rows)


@pytest.mark.parametrize("symmetry", range(5))
@pytest.mark.parametrize(("mark", "lamps"), [(".", 1), (",", 2)])
def test_planes_that_are_not_stored_are_those_of_the_symmetry(symmetry, mark, lamps):
    """Photompy took them for stored ones: angles of planes became polar angles."""
    polar, azimuth, value = read_eulumdat("t", eulumdat(symmetry, mark, lamps))
    assert polar.tolist() == POLAR.tolist()
    assert azimuth.tolist() == ([0.0] if symmetry == 1 else ROUND.tolist())
    np.testing.assert_allclose(value, light(azimuth, symmetry), rtol=1e-12)


@pytest.mark.parametrize(
    ("line", "text", "words"),
    [(3, "7", "line 3: 7: expected 0 … 4"), (4, "0", "line 4: 0: expected 1"),
     (6, "nine", "line 6: 'nine': expected a number"), (26, "0", "line 26: 0"),
     (60, "inf", "line 60: 'inf': expected a number")],
)  # fmt: skip
def test_lines_that_are_wrong_are_named(line, text, words):
    lines = eulumdat(2).splitlines()
    lines[line - 1] = text
    with pytest.raises(InputError, match=words):
        read_eulumdat("t", "\n".join(lines))
    with pytest.raises(InputError, match="100 lines: expected a number in line 101"):
        read_eulumdat("t", "\n".join(eulumdat(2).splitlines()[:100]))


@pytest.mark.parametrize(
    "head",
    ["IESNA:LM-63-2002\n[TEST] a\n[MANUFAC] b\n[LUMCAT] c", "IESNA91\n[TEST] a", "Luminaire 7",
     "IESNA95\nwhat the maker says, 20 µm\n[OTHER] x"],
)  # fmt: skip
def test_ies_files_of_every_year_are_one_table(tmp_path, head):
    """Those of 1986 and 1991 were refused: `list index out of range`."""
    numbers = "1 1000 1 7 1 1 2 0 0 0\n1 1 10\n0 15 30 45 60 75 90\n0\n100 93 75 50 25 7 0\n"
    (tmp_path / "led.ies").write_text(f"{head}\nTilt = none\n{numbers}", "cp1252")
    found = read_emission("x", tmp_path, "led.ies")
    assert found[0, 0] == pytest.approx(100)
    assert found.max() == pytest.approx(100)


def test_a_symmetry_without_its_planes_names_the_line():
    lines = eulumdat(3).splitlines()
    lines[3] = "1"
    with pytest.raises(InputError, match=r"t: line \d+: planes .*: expected those of symmetry 3"):
        read_eulumdat("t", "\n".join([*lines[:42], "120", *lines[43:]]))


def test_counts_are_whole_numbers():
    lines = eulumdat(2).splitlines()
    lines[2] = "1.7"
    with pytest.raises(InputError, match=r"t: line 3: 1\.7: expected a whole number"):
        read_eulumdat("t", "\n".join(lines))
