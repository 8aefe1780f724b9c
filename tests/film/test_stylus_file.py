"""Trace files as instruments write them: read rightly and said, or refused with what they are."""

import re

import numpy as np
import pytest
from areal_file import write_map

from mpfcad.errors import InputError
from mpfcad.film import (
    Groove,
    ReadingOption,
    fit_stylus_trace,
    parse_columns,
    parse_units,
    read_stylus_trace,
)
from mpfcad.film.stylus.file.column import find_tip
from mpfcad.film.stylus.file.unit import find_unit

BEF = Groove(0.050, 0.025)
X = np.arange(0.0, 0.3, 2.5e-4)
TRUTH = 60.0


def surface(curvature=TRUTH, shift=0.013):
    return BEF.height((X + shift) % BEF.pitch - BEF.half_width, curvature)


def table(scale_x=1e3, scale_z=1e3, digits=5, z=None, x=X):
    z = surface() if z is None else z
    return [
        (f"{a * scale_x:.{digits}f}", f"{b * scale_z:.{digits}f}")
        for a, b in zip(x, z, strict=True)
    ]


def text(rows, delimiter=",", header="", comma=False, tail=""):
    lines = [delimiter.join(row) + tail for row in rows]
    if comma:
        lines = [line.replace(".", ",") for line in lines]
    return header + "\n".join(lines) + "\n"


def read(tmp_path, content, name="trace.csv", **option):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_stylus_trace(path, BEF, option=ReadingOption(**option))


DEKTAK = (
    "Scan Parameters\nScan Type,Standard Scan\nStylus,Radius: 2.5 µm\nLength,300.0 um\n"
    "Resolution,0.25 um/sample\nR. Cursor,Pos: 100.0 um Width: 0.0 um\n\nAnalytical Results\n"
    "Function,R.Cur Pos,Result\nRa,468.0 um,0.00525 um\n\nScan Data\nLateral um,Raw Micrometer,\n"
)
VISION = (
    "Meta Data\nUnits,MICRONS\nStylus Type,Radius 12.5 um\nData\nLateral(µm),Total Profile(Å),,\n"
)
GERMAN = "Gerät;Taster\nTaststrecke;0,3 mm\nTastspitzenradius (µm);2\nWeg [mm];Höhe [µm]\n"
CASES = {
    "dektak": (text(table(), header=DEKTAK, tail=",,").encode("cp1252"), ("µm", "cp1252", "tip 2.5 µm")),
    "vision64": (text(table(1e3, 1e7, 2), header=VISION, tail=",,").encode("utf-8-sig"),
                 ("x µm and z Å", "tip 12.5 µm")),
    "german": (text(table(1, 1e3, 6), ";", GERMAN, comma=True).encode("utf-16"),
               ("utf-16", "';'", "decimal comma", "x mm and z µm", "tip 2 µm")),
    "unmarked utf-16": (text(table(), "\t", "x (µm)\tz (µm)\n").encode("utf-16-le"), ("utf-16-le", "tab")),
    "spaces, hash": (text(table(1e6, 1e6), "  ", "# Distance nm  Height nm\n"), ("nm", "space")),
    "units line": (text(table(1, 1, 7), ";", "X;Y;valid\n[mm];[mm];[1/0]\n", tail=";1"), ("mm", "z column 2")),
    "index": (text([(str(i + 1), *row) for i, row in enumerate(table())], ",", "index,x in µm,y in µm\n"),
              ("x column 2, z column 3",)),
    "levelled twice": (text([(*row, f"{float(row[1]) + 0.1 * float(row[0]) - 3:.5f}") for row in table()],
                            "\t", "Lateral um\tRaw um\tLevelled um\n"), ("z column 2",)),
    "step": (text([(str(i + 1), z) for i, (_, z) in enumerate(table(1e3, 1e7, 1))], "\t",
                  "Points\t1200\nX-Resolution\t0.25 um\n\tRaw A\n"), ("step 0.25",)),
    "from the right": (text(table()[::-1], header="x_um,z_um\n"), ("x from the right, turned",)),
    "no header": (text(table(1.0, 1e3, 6), "\t"), ("x mm and z µm by pitch and depth (not stated)",)),
    "inch": (text(table(1 / 25.4, 1 / 25.4, 9), header="x_inch,z_in\n"), ("in",)),
    "mil": (text(table(1 / 25.4e-3, 1 / 25.4e-6, 6), header="x (mil),z [uin]\n"), ("x mil and z µin",)),
    "a word behind the axis": (text(table(1.0, 1e3, 6), header="x_raw,z_profile\n"), ("not stated",)),
    "commas twice": (text(table(), ",", "x_um,z_um\n", comma=True), ("decimal comma",)),
    "missing": (text(table(), header="x_um,z_um\n").replace("\n5.00000,", "\n5.00000,NaN\n5.00001,"),
                ("1 rows without a number",)),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_read_rightly_and_said(tmp_path, case):
    content, words = CASES[case]
    trace = read(tmp_path, content)
    for word in ("read trace.csv: ", *words):
        assert word in trace.reading
    assert "\n" not in trace.reading
    # What stands in the file, to its digits.
    surely = BEF.height((trace.position + 0.013) % BEF.pitch - BEF.half_width, TRUTH)
    assert np.ptp(trace.height - surely) < 2e-5
    if trace.tip is not None:
        # That did not trace these sharp grooves: the fit is of what is there.
        fit = fit_stylus_trace(trace, BEF)
        assert fit.curvature.value == pytest.approx(TRUTH, abs=0.1)


def test_told_units_overrule_a_strange_one(tmp_path):
    trace = read(tmp_path, text(table(), header="x_furlong,z_um\n"), units=("µm", "µm"))
    assert fit_stylus_trace(trace, BEF).curvature.value == pytest.approx(TRUTH, abs=0.1)


def test_rounded_positions_are_averaged(tmp_path):
    x = np.arange(0.0, 300.0, 0.05)
    z = BEF.height((x / 1e3) % BEF.pitch - BEF.half_width, TRUTH) * 1e3
    lines = "".join(f"{a:.1f},{b:.5f}\n" for a, b in zip(x, z, strict=True))
    trace = read(tmp_path, "x_um,z_um\n" + lines)
    assert "equal position averaged" in trace.reading
    assert np.all(np.diff(trace.position) > 0.9e-4)
    assert fit_stylus_trace(trace, BEF).curvature.value == pytest.approx(TRUTH, abs=0.1)


@pytest.mark.parametrize(
    ("content", "option", "words"),
    [
        (text(table(z=-surface()), header="x_um,z_um\n"), {}, ("upside down", "--correct")),
        (text(table(scale_z=1.0, digits=7), header="x_um,z_um\n"), {}, ("z is in mm", "--unit")),
        (text(table(scale_z=100.0), header="x_um,z_um\n"), {}, ("times 10", "--correct")),
        (text(table(scale_x=1.0, digits=7), header="x_um,z_um\n"), {}, ("x in µm is 0.2998 µm long", "in mm there are grooves", "--unit mm,um")),
        (text(table(scale_x=1e6), header="x_um,z_um\n"), {}, ("in nm there are grooves", "--unit nm,um")),
        (text(table(), header="x_furlong,z_um\n"), {}, ("column 1 (x_furlong)", "'furlong'", "--unit")),
        (text(table(), header="X [um],Z [V]\n"), {}, ("column 2 (Z [V])", "'V'", "--unit")),
        (text(table(), header="Units: furlong\nx,z\n"), {}, ("'furlong'", "--unit")),
        (text(table(1e3, 1e7), header="\n"), {"units": ("µm", "nm")}, ("z is in Å",)),
        (text([(str(int(float(a) * 4)), "5", str(int(float(b) * 10)), "5") for a, b in table()]), {},
         ("4 columns", "2 with decimal commas")),
        (text([(a, b, c) for (a, b), (_, c) in zip(table(), table(z=surface(45.0)), strict=True)],
              header="Lateral um,Trace um,Retrace um\n"), {}, ("2 (Trace um)", "3 (Retrace um)")),
        (text([(b,) for _, b in table()], header="z_um\n"), {}, ("one column", "step")),
        (text(table(), header="x_um,z_um\n"), {"columns": (1, 3)}, ("--columns: 1,3", "1 … 2")),
        (b"\x89PNG\0\0\1\2" * 40, {}, ("not a text file",)),
    ],
)  # fmt: skip
def test_refused_with_what_it_is(tmp_path, content, option, words):
    with pytest.raises(InputError) as error:
        read(tmp_path, content, **option)
    for word in ("trace.csv" if "columns" not in option else "--columns", *words):
        assert word in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "content",
    [
        text(table(z=-surface()), header="x_um,z_um\n"),
        text(table(scale_z=1.0, digits=7), header="x_um,z_um\n"),
        text(table(scale_z=100.0), header="x_um,z_um\n"),
    ],
)
def test_corrected_when_asked(tmp_path, content):
    trace = read(tmp_path, content, correct=True)
    assert "(corrected)" in trace.reading
    assert fit_stylus_trace(trace, BEF).curvature.value == pytest.approx(TRUTH, abs=0.05)


def test_two_units_that_fit_are_both_named(tmp_path):
    """A relief of 12,300 is 12.3 µm in nm and 1.23 µm in Å: without a bare wall both could be."""
    z = surface(39.0)
    rows = table(1e3, 1e6, 1, z=z)
    with pytest.raises(InputError, match=r"x µm and z nm or x µm and z Å"):
        read(tmp_path, text(rows, header="x µm\tz\n", delimiter="\t"))
    trace = read(tmp_path, text(rows, "\t"), units=("µm", "nm"))
    assert fit_stylus_trace(trace, BEF).curvature.value == pytest.approx(39.0, abs=0.1)


@pytest.mark.parametrize("ending", ["x3p", "gwy", "sdf"])
def test_maps_are_cut_across_their_grooves(tmp_path, ending):
    """A map of grooves turned by 20°: the profile across them has the pitch and the curvature."""
    pytest.importorskip("SurfaceTopography")
    step, turn = 5e-4, np.radians(20.0)
    x, y = np.meshgrid(np.arange(260) * step, np.arange(100) * step, indexing="ij")
    across = x * np.cos(turn) + y * np.sin(turn)
    height = BEF.height(across % BEF.pitch - BEF.half_width, TRUTH)
    path = tmp_path / f"map.{ending}"
    write_map(path, height, step)
    trace = read_stylus_trace(path, BEF)
    found = re.search(r"cut across its grooves at ([\d.]+)° from x", trace.reading)
    assert found
    assert float(found[1]) == pytest.approx(20.0, abs=0.3)
    fit = fit_stylus_trace(trace, BEF)
    assert fit.curvature.value == pytest.approx(TRUTH, abs=0.6)


def test_rows_of_three_are_a_map(tmp_path):
    rows = [
        f"{a * 1e3:.3f} {b:.1f} {z * 1e3:.5f}"
        for b in (0.0, 5.0, 10.0, 15.0)
        for a, z in zip(X, surface(), strict=True)
    ]
    trace = read(tmp_path, "# x/µm y/µm z/µm\n" + "\n".join(rows), "map.xyz")
    assert "map of 1200 × 4" in trace.reading
    assert fit_stylus_trace(trace, BEF).curvature.value == pytest.approx(TRUTH, abs=0.1)


@pytest.mark.parametrize(
    ("text", "unit"),
    [("Lateral um", "µm"), ("Total Profile(Å)", "Å"), ("[mm]", "mm"), ("z/nm", "nm"), ("(A)", "Å"),
     ("Raw Micrometer", "µm"), ("Points", None), ("X_(microns)", "µm"), ("amplitude", None),
     ("x in m", "m"), ("x in", "in"), ("Height [in]", "in"), ("mils", "mil"), ("Z (µin)", "µin"),
     ("cut in halves", None), ("z/cm", "cm")],
)  # fmt: skip
def test_units_in_words(text, unit):
    assert find_unit(text.replace("_", " ")) == unit


@pytest.mark.parametrize(
    ("line", "radius", "angle"),
    [("Stylus,Radius: 2.5 µm", 2.5, 60), ("Stylus Type;Radius 12,5 um", 12.5, 60),
     ("Tip radius (nm): 700", 0.7, 60), ("Stylus 5 µm, 90°", 5.0, 90), ("Stylus Type\tRadius: 2 µm 90 deg", 2, 90)],
)  # fmt: skip
def test_tip_of_a_header(line, radius, angle):
    tip = find_tip(["Scan Length,300 um", line])
    assert tip is not None
    assert tip.radius == pytest.approx(radius * 1e-3)
    assert np.degrees(tip.angle) == pytest.approx(angle)


@pytest.mark.parametrize(
    ("parse", "word", "named"),
    [(parse_units, "furlong", "--unit"), (parse_units, "um,um,um", "--unit"),
     (parse_columns, "1", "--columns"), (parse_columns, "a,b", "--columns")],
)  # fmt: skip
def test_words_of_options(parse, word, named):
    with pytest.raises(InputError, match=named):
        parse(word)
    assert parse_units("mm,um") == ("mm", "µm")
    assert parse_units("in,uin") == ("in", "µin")
    assert parse_columns("2,4") == (2, 4)
