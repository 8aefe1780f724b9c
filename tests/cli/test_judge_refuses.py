"""`mpfcad judge` refuses in one line what would give a plausible wrong contrast."""

import numpy as np
import pytest
import tifffile

from mpfcad.cli import run_app
from mpfcad.errors import InputError
from mpfcad.measure.observed import find_pitch

PITCH, SIDE = 32.69, 160
IMAGE = ["--pixel-mm", "1"]


@pytest.fixture(autouse=True)
def _there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def lattice(turn, across=16.0, along=14.0):
    """Write spots of 3 % across and 3 % along, turned by degrees."""
    rng, angle = np.random.default_rng(2), np.radians(turn)
    x, y = np.meshgrid((np.arange(SIDE) + 0.5) * 0.5, (np.arange(SIDE) + 0.5) * 0.5)
    u, v = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
    light = (1 + 0.03 * np.cos(2 * np.pi * u / across)) * (1 + 0.03 * np.cos(2 * np.pi * v / along))
    light = 20000 * light + rng.normal(0, 100, x.shape)
    tifffile.imwrite("spots.tif", np.round(light).astype(np.uint16))
    return ["spots.tif", "--pixel-mm", "0.5", "--spots"]


def stripes(turn=0.0, level=20000.0, most=65535):
    """Write stripes of 3 %, turned by degrees, clipped at a count."""
    rng, angle = np.random.default_rng(3), np.radians(turn)
    x, y = np.meshgrid(np.arange(SIDE) + 0.5, np.arange(SIDE) + 0.5)
    u = x * np.cos(angle) - y * np.sin(angle)
    light = level * (1 + 0.03 * np.cos(2 * np.pi * u / 16.0)) + rng.normal(0, 20, x.shape)
    tifffile.imwrite("photo.tif", np.minimum(np.round(light), most).astype(np.uint16))
    return ["photo.tif", *IMAGE]


def curve(length=170.0, step=0.5, header="x_mm,luminance_cd_m2", lost=(), factor=1.0):
    x = np.arange(0.0, length, step)
    value = 6000 * (1 + 0.02 * np.cos(2 * np.pi * (x - 9) / PITCH))
    value += np.random.default_rng(5).normal(0, 4, len(x))
    value[list(lost)] = np.nan
    table = np.stack([x * factor, value], 1)
    np.savetxt("l.csv", table, "%.6g", ",", header=header, comments="")
    return ["l.csv"]


def refused(capsys, arguments):
    """Return the one line that says why."""
    assert run_app(["judge", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and len(printed.err.splitlines()) == 1 and len(printed.err) < 320
    return printed.err


def contrast(capsys, arguments):
    assert run_app(["judge", *arguments, "--limit", "0.9"]) == 0
    out = capsys.readouterr().out
    return float(out.split("contrast ")[1].split()[0]), out


@pytest.mark.parametrize("turn", [3.0, -8.0])
def test_spots_askew_are_refused_with_their_angle(capsys, turn):
    """Upright they have (1.03² - 0.97²)/(1.03² + 0.97²)."""
    cell = ["--cell-mm", "16,14"]
    words = refused(capsys, [*lattice(turn), *cell])
    assert float(words.split("--rotation-deg ")[1]) == pytest.approx(turn, abs=0.4)
    found, _ = contrast(
        capsys, ["spots.tif", "--pixel-mm", "0.5", *cell, "--rotation-deg", str(turn)]
    )
    assert found == pytest.approx(0.0599, abs=2e-3)


@pytest.mark.parametrize("turn", [20.0, 30.0])
def test_spots_far_askew_are_refused(capsys, turn):
    assert "expected" in refused(capsys, [*lattice(turn), "--cell-mm", "16,14"])


@pytest.mark.parametrize("cell", ["14,16", "10,10"])
def test_a_cell_that_the_image_contradicts_is_refused(capsys, cell):
    words = refused(capsys, [*lattice(0.0), "--cell-mm", cell])
    assert f"--cell-mm {cell.split(',')[0]}" in words
    assert float(words.split(", ")[-1].split(" mm")[0]) == pytest.approx(16.0, rel=0.02)


def test_clipping_below_full_scale_is_refused(capsys):
    """A camera of 12 bits: a tenth of the pixels are at 4095."""
    assert "highest count, 4095" in refused(capsys, stripes(level=4000.0, most=4095))
    assert "highest count, 4095" in refused(capsys, stripes(level=9000.0, most=4095))
    assert contrast(capsys, [*stripes(level=3900.0), "--pitch-mm", "16"])[0] > 0.028


def test_a_mean_outside_the_points_is_refused(capsys):
    np.savetxt("l.csv", np.stack([np.arange(100.0), np.full(100, 500.0)], 1), "%g", ",",
               header="x_mm,L", comments="")  # fmt: skip
    assert "expected" in refused(capsys, ["l.csv", "--pitch-mm", "20"])


@pytest.mark.parametrize("length", [36.0, 42.0, 50.0, 64.0, 80.0])
def test_a_short_curve_needs_its_pitch(capsys, length):
    assert "give --pitch-mm" in refused(capsys, curve(length))


def test_half_a_pitch_of_a_short_curve_is_not_found():
    """Two harmonics over 1.5 pitches: half a pitch, held 3.1 times, explains much of them."""
    x, phase = np.arange(0.0, 50.0), 2 * np.pi * (np.arange(0.0, 50.0) - 12) / PITCH
    wave = 6000 * (1 + 0.01 * np.cos(phase) + 0.006 * np.cos(2 * phase + 1))
    with pytest.raises(InputError, match="too short to find the lamp pitch"):
        find_pitch("l", x, wave + np.random.default_rng(50).normal(0, 6, 50) + 2 * x)


def test_a_stated_pitch_that_the_curve_contradicts_is_refused(capsys):
    words = refused(capsys, [*curve(), "--pitch-mm", "16.345"])
    assert "--pitch-mm 16.345" in words
    assert float(words.split(", ")[-1].split(" mm")[0]) == pytest.approx(PITCH, rel=5e-3)
    assert contrast(capsys, ["l.csv", "--pitch-mm", "32.69"])[0] == pytest.approx(0.02, abs=1e-3)


@pytest.mark.parametrize("turn", [90.0, -90.0, 45.0, -60.0, 180.0, 20.0])
def test_a_large_rotation_works_or_is_refused(capsys, turn):
    """Of the right sign the stripes are found; of the wrong one they are refused."""
    options = [*stripes(turn), "--crop", "0,50,160,90", "--pitch-mm", "16", "--rotation-deg"]
    if abs(turn) == 60.0:
        options[options.index("--crop") + 1] = "60,0,100,160"
    assert contrast(capsys, [*options, str(turn)])[0] == pytest.approx(0.03, abs=2e-3)
    if abs(turn) < 90:
        assert "askew after" in refused(capsys, [*options, str(-turn)])


def test_a_rotation_of_a_square_image_that_leaves_nothing_is_one_line(capsys):
    for turn in ("45", "-45", "60", "30", "1e9", "181"):
        assert "expected" in refused(capsys, [*stripes(), "--rotation-deg", turn])
    assert "expected" in refused(capsys, [*stripes(), "--spots", "--rotation-deg", "45"])


@pytest.mark.parametrize(
    "name", ["log_luminance", "luminance_fL", "L (ft-L)", "L [counts]", "rel. luminance", "kcd/m2"]
)
def test_another_unit_of_luminance_is_refused(capsys, name):
    assert "expected cd/m²" in refused(capsys, curve(header=f"x_mm,{name}"))


@pytest.mark.parametrize(
    ("header", "factor"),
    [("x_um,L", 1e3), ("x [m],Leuchtdichte [cd/m²]", 1e-3), ("x (µm),Lv (cd·m-2)", 1e3),
     ("position_mm,luminance nits", 1.0)],
)  # fmt: skip
def test_a_unit_of_position_is_read(capsys, header, factor):
    _, out = contrast(capsys, curve(header=header, factor=factor))
    assert float(out.split("lamp pitch ")[1].split()[0]) == pytest.approx(PITCH, rel=5e-3)
    if factor != 1.0:
        assert "as --unit says" in refused(capsys, ["l.csv", "--unit", "mm"])


def test_lost_rows_are_counted_and_sparse_ones_refused(capsys):
    assert "3 rows without a number left out" in contrast(capsys, curve(lost=(4, 50, 51)))[1]
    assert "expected 12 or more" in refused(capsys, [*curve(step=3.0), "--pitch-mm", "32.69"])
    few = [*curve(lost=range(120, 160)), "--pitch-mm", "32.69"]
    assert "no point over 20.5 mm" in refused(capsys, few)


@pytest.mark.parametrize("turn", [20.0, -31.0, 40.0])
@pytest.mark.parametrize("cell", [["--cell-mm", "16,14"], []])
def test_spots_far_askew_are_refused_with_their_angle(capsys, turn, cell):
    words = refused(capsys, [*lattice(turn), *cell])
    assert "the rows of spots run" in words
    told = float(words.split("--rotation-deg ")[1])
    assert told == pytest.approx(turn, abs=1.2)


def bands(stripe, band):
    """Write stripes of lamps along y, and bands of a camera along x, of these contrasts."""
    rng = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(SIDE) + 0.5, np.arange(SIDE) + 0.5)
    light = (1 + stripe * np.cos(2 * np.pi * x / 16)) * (1 + band * np.cos(2 * np.pi * y / 9.5))
    tifffile.imwrite("photo.tif", np.round(20000 * light + rng.normal(0, 50, x.shape)).astype("u2"))
    return ["photo.tif", *IMAGE]


def test_bands_along_the_other_axis_are_averaged_over_and_said(capsys):
    found, out = contrast(capsys, bands(0.01, 0.06))
    assert found == pytest.approx(0.01, abs=1e-3)
    assert "bands of 9.4" in out or "bands of 9.5" in out
    assert "averaged over" in out and "askew" not in out
    _, quiet = contrast(capsys, bands(0.03, 0.0))
    assert "bands" not in quiet


def test_bands_alone_are_refused_as_what_they_are(capsys):
    words = refused(capsys, bands(0.0, 0.03))
    assert "no stripes are seen beside them" in words and "askew" not in words
    assert abs(float(words.split("--rotation-deg ")[1].split()[0])) == 90.0


def test_a_stated_pitch_a_little_off_is_named_and_far_off_refused(capsys):
    _, out = contrast(capsys, [*curve(), "--pitch-mm", "33.5"])
    assert "period, 32." in out and "off --pitch-mm 33.5" in out
    assert "32." in refused(capsys, ["l.csv", "--pitch-mm", "35.5"])
    _, quiet = contrast(capsys, ["l.csv", "--pitch-mm", "32.69"])
    assert "off --pitch-mm" not in quiet
