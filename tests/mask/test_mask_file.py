"""Every format: read back as wanted, the same bytes, nothing half-written."""

import signal
import subprocess
import sys
import time
from typing import get_args

import gdstk
import klayout.db as kdb
import numpy as np
import pytest
from shapely import box, union_all
from small_mask import CURVATURE, DOT, PROCESS, SLOT, build, written

from mpfcad.errors import ExportError, InputError
from mpfcad.film import CurvatureMap
from mpfcad.gate import demand
from mpfcad.job.screen import MaskFormat
from mpfcad.mask import MaskRules, Phototool, check_mask, refuse_large, write_mask
from mpfcad.mask.check.check import READERS
from mpfcad.mask.format.write import FORMATS
from mpfcad.pipeline import MASK_FORMATS
from mpfcad.pipeline.plan.printed.order import CLOSED_ANY, CLOSED_LATTICE

CLOSED = Phototool(polarity="closed", mirror=True, emulsion_side="squeegee")


def flat(path):
    """Return all apertures of a layout as a klayout region."""
    layout = kdb.Layout()
    layout.read(str(path))
    region = kdb.Region(layout.top_cell().begin_shapes_rec(layout.find_layer(1, 0)))
    return region.flatten()  # a region that is not flat dies with its layout


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_a_file_reads_back_as_what_was_wanted(tmp_path, rules, suffix):
    mask = build(rules=rules)
    check = check_mask(written(tmp_path / f"mask.{suffix}", mask), mask)
    assert check.aperture_ratio_error_max < 1e-5
    assert np.abs(check.aperture_ratio - mask.aperture_ratio).max() < 1e-12
    assert check.ratio_map_error_max < 1e-9
    assert check.aperture_count == mask.aperture_count
    assert (check.width, check.length) == (pytest.approx(39 * 0.05), pytest.approx(20.13))
    assert (check.unit, check.fiducial_count) == (pytest.approx(0.001), 4)
    assert f"test-job sha256:{mask.content_hash}" in check.text
    assert "drawn = open; seen from the squeegee side; emulsion on the film side" in check.text
    assert check.windows.violations == ()
    assert len(check.windows.windows) >= 3
    assert check.snap_error == (5e-7 if suffix == "gbr" else 0)


@pytest.mark.parametrize("rules", [SLOT, DOT])
@pytest.mark.parametrize("suffix", ["oas", "gds", "gbr", "svg"])
def test_a_closed_and_mirrored_file_gives_the_same_ratios(tmp_path, rules, suffix):
    mask = build(rules=rules)
    path = written(tmp_path / f"mask.{suffix}", mask, CLOSED)
    check = check_mask(path, mask, CLOSED)
    assert np.abs(check.aperture_ratio - mask.aperture_ratio).max() < 1e-12
    assert check.ratio_map_error_max < 1e-9
    assert "drawn = closed; mirrored: seen from the film side; emulsion on the squeegee side" in (
        check.text
    )
    for other in (Phototool(polarity="closed"), Phototool(mirror=True), Phototool()):
        with pytest.raises(ExportError):
            demand(check_mask(path, mask, other).gates)


def test_a_file_without_a_note_of_its_order_is_refused(tmp_path):
    mask = build()
    noted = Phototool(notes=("revision B", "mesh 120-34"))
    path = written(tmp_path / "m.oas", mask, Phototool(notes=("revision B",)))
    with pytest.raises(ExportError, match="text: expected 'mesh 120-34'"):
        check_mask(path, mask, noted)
    assert check_mask(written(path, mask, noted), mask, noted).fiducial_count == 4


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_closed_is_what_open_leaves(tmp_path, rules):
    mask = build(rules=rules)
    for suffix in (".oas", ".gds"):
        opened = flat(written(tmp_path / f"o{suffix}", mask))
        tool = Phototool(polarity="closed")
        closed = flat(written(tmp_path / f"c{suffix}", mask, tool))
        panel = kdb.Region(kdb.Box(0, 0, 39 * 50_000, 20_130_000))
        assert closed.area() > 0
        assert ((panel - opened) ^ closed).is_empty()
        assert closed.area() == closed.merged().area()  # no overlap


def test_a_mirrored_file_is_the_mirror_image(tmp_path):
    mask = build()
    plain = flat(written(tmp_path / "p.oas", mask))
    turned = flat(written(tmp_path / "m.oas", mask, Phototool(mirror=True)))
    assert not (plain ^ turned).is_empty()
    assert (plain.transformed(kdb.Trans(kdb.Trans.M90, 39 * 50_000, 0)) ^ turned).is_empty()


def test_windows_of_a_mirrored_file_are_the_mirrored_windows(tmp_path):
    """Those about the grooves of least and largest ratio too: off the sampled shares here."""
    curvature = np.full(200, 60.0)
    curvature[30], curvature[70] = 55.0, 65.0
    mask = build(curvature, SLOT)
    width = round(mask.width * 1e6)
    windows = []
    for mirror in (False, True):
        tool = Phototool(mirror=mirror)
        windows.append(
            check_mask(written(tmp_path / "m.oas", mask, tool), mask, tool).windows.windows
        )
    turned = {(width - box[2], box[1], width - box[0], box[3]) for box in windows[1]}
    assert len(turned) == len(windows[0]) > 9
    assert turned == set(windows[0])


def test_smallest_aperture_and_web(tmp_path):
    slot = check_mask(written(tmp_path / "s.oas", mask := build()), mask)
    assert slot.smallest_aperture == pytest.approx(mask.along[mask.is_open].min() * 1e-6)
    assert slot.smallest_web == pytest.approx(0.05)  # the one closed groove between open ones
    wide = check_mask(written(tmp_path / "w.oas", mask := build([60.0] * 5)), mask)
    assert wide.smallest_web == pytest.approx(mask.period - mask.along[0] * 1e-6)
    dot = check_mask(written(tmp_path / "d.oas", mask := build([60.0, 55.0], DOT)), mask)
    assert dot.smallest_aperture == pytest.approx(mask.across[0] * 1e-6)
    assert dot.smallest_web == pytest.approx(0.05 - mask.across.mean() * 1e-6, abs=1e-6)


def test_a_mask_without_resin_is_an_empty_mask(tmp_path, suffix):
    mask = build([80.0] * 10)
    check = check_mask(written(tmp_path / f"m.{suffix}", mask), mask)
    assert (check.aperture_count, check.smallest_aperture, check.smallest_web) == (0, None, None)


@pytest.mark.parametrize("pattern", ["staggered", "angled", "error-diffused", "blue-noise"])
@pytest.mark.parametrize("suffix", ["oas", "gds", "gbr", "svg"])
def test_every_pattern_reads_back(tmp_path, pattern, suffix):
    mask = build(CURVATURE[:20], MaskRules(pattern, 0.100, 0.010, 0.010), length=150.0)
    check = check_mask(written(tmp_path / f"m.{suffix}", mask), mask)
    assert check.aperture_count == mask.aperture_count
    assert np.abs(check.aperture_ratio - mask.aperture_ratio).max() < 1e-9
    assert check.ratio_map_error_max < 1e-6


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_layouts_hold_the_same(tmp_path, rules):
    mask = build(rules=rules)
    one, two = (flat(written(tmp_path / f"m{s}", mask)) for s in (".oas", ".gds"))
    assert one.count() > 0
    assert (one ^ two).is_empty()


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_a_window_of_the_file_is_what_the_formula_draws(tmp_path, rules):
    """Rectangles drawn again from the ratio's definition alone, united by shapely."""
    length = 20.13
    path = written(tmp_path / "m.oas", build(rules=rules, length=length))
    count = round(length / rules.period)
    period = length * 1e6 / count
    ratio = PROCESS.aperture_ratio_of_curvature(CURVATURE)
    first, last = count // 2 - 6, count // 2 + 6
    drawn = []
    for i in np.flatnonzero(ratio):
        for k in range(first, last):
            across, along = 50_000, ratio[i] * period
            if rules.pattern == "dot":
                across = along = np.sqrt(ratio[i] * 50_000 * period)
            x, y = (i + 0.5) * 50_000, (k + 0.5) * period
            drawn.append(box(x - across / 2, y - along / 2, x + across / 2, y + along / 2))
    wanted = union_all(drawn)
    window = kdb.Box(0, round(first * period), 39 * 50_000, round(last * period))
    region = (flat(path) & kdb.Region(window)).merged().decompose_trapezoids_to_region()
    boxes = [polygon.bbox() for polygon in region.each()]
    read = union_all([box(b.left, b.bottom, b.right, b.top) for b in boxes])
    # XOR: only slivers along the edges. The period is on the grid, so six periods from the middle
    # an edge is off by 6 steps at most, and by 2 more from rounding size and place.
    difference = read.symmetric_difference(wanted)
    assert difference.area <= 8 * wanted.length
    assert difference.buffer(-4.01).is_empty
    assert wanted.area > 1e9


ALL = ("oas", "gds", "dxf", "gbr", "svg", "tif")
CODE = """
import sys, signal, numpy as np; from pathlib import Path; from mpfcad.film import *
from mpfcad.mask import *
g = Groove(0.05, 0.025); c = np.linspace(55, 63, 40)
m = build_mask(PrismFilm(g, 0.2, 20.13, 'filled', c), read_process(None, g),
               MaskRules('slot', 0.4, 0.01, 0.015), 'test-job')
"""


def test_the_same_bytes_twice_and_in_another_process(tmp_path):
    code = CODE + "[write_mask(m, Path(p)) for p in sys.argv[1:]]"
    mask = build(np.linspace(55, 63, 40))
    others = {suffix: tmp_path / f"other.{suffix}" for suffix in ALL}
    subprocess.run([sys.executable, "-c", code, *map(str, others.values())], check=True)
    for suffix, other in others.items():
        first = written(tmp_path / f"a.{suffix}", mask).read_bytes()
        second = written(tmp_path / f"b.{suffix}", mask).read_bytes()
        assert first == second == other.read_bytes(), suffix
    assert len(list(tmp_path.iterdir())) == 3 * len(ALL)


def test_a_full_disk_leaves_no_truncated_file(tmp_path):
    """A limit of the file size stands for the full disk; older files stay as they were."""
    paths = [tmp_path / f"m.{suffix}" for suffix in ALL]
    for path in paths:
        path.write_bytes(b"older")
    code = CODE + (
        "import resource; from mpfcad.errors import ExportError\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "paths = [Path(name) for name in sys.argv[1:]]\n"
        "for path in paths:\n    write_mask(m, path.with_stem('whole'))\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1500, 1500))\n"
        "for path in paths:\n    try:\n        write_mask(m, path)\n"
        "    except ExportError as error:\n        print(error)\n"
    )
    run = [sys.executable, "-c", code, *map(str, paths)]
    done = subprocess.run(run, check=True, capture_output=True, text=True)
    for path in paths:
        assert f"{path}: cannot be written" in done.stdout
        assert path.read_bytes() == b"older"
    names = [f"{stem}.{suffix}" for stem in ("m", "whole") for suffix in ALL]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_a_kill_leaves_no_truncated_file(tmp_path):
    path = tmp_path / "m.oas"
    code = CODE + (
        "import os\nfrom mpfcad.mask.format import oasis\n"
        "oasis._end = lambda out, table: (out.file.flush(), os.kill(os.getpid(), signal.SIGKILL))\n"
        "write_mask(m, Path(sys.argv[1]))\n"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert not path.exists()
    assert [p.name.startswith(".m.oas.part") for p in tmp_path.iterdir()] == [True]


def panel(rules=SLOT):
    position = np.linspace(0, 32.69, 67)
    curvature = 57 + 6 * np.cos(2 * np.pi * position / 32.69)
    centres = (np.arange(7846) + 0.5) * 0.05
    curvature = CurvatureMap(position, curvature, "pitch", "repeat").on_grooves(
        centres, 32.69, 16.345
    )
    return build(curvature, rules, length=697.68)


#: Bytes of the whole panel, and CPU seconds to check it.
SIZES = {"oas": 62_000, "gds": 800_000, "dxf": 2_000_000, "gbr": 400_000, "svg": 720_000}


def test_the_whole_panel_is_small_and_quick(tmp_path, suffix):
    mask = panel()
    path = written(tmp_path / f"m.{suffix}", mask)
    start = time.process_time()
    check = check_mask(path, mask)
    assert time.process_time() - start < (8 if suffix == "dxf" else 4)
    assert path.stat().st_size < SIZES[suffix]
    assert check.aperture_count == 7846 * 1744
    assert check.aperture_ratio_error_max < 5e-6


def test_oasis_of_109_million_dots(tmp_path):
    mask = panel(MaskRules("dot", 0.050, 0.010, 0.005))
    path = written(tmp_path / "m.oas", mask)
    assert mask.aperture_count > 109e6
    assert path.stat().st_size < 62_000
    assert check_mask(path, mask).aperture_count == mask.aperture_count


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"mask format '\.cif': expected \.oas, \.gds, \.dxf"):
        write_mask(build(), tmp_path / "m.cif")
    assert not list(tmp_path.iterdir())


def test_what_a_format_cannot_hold_is_refused(tmp_path):
    with pytest.raises(InputError, match="polarity: closed: expected oas, gds, gbr, svg, tif"):
        write_mask(build(), tmp_path / "m.dxf", Phototool(polarity="closed"))
    listed = build(rules=MaskRules("error-diffused", 0.100, 0.010, 0.010))
    with pytest.raises(InputError, match="polarity: closed: expected for patterns with one array"):
        write_mask(listed, tmp_path / "m.oas", Phototool(polarity="closed"))
    assert not list(tmp_path.iterdir())


def test_gdstk_and_klayout_agree_on_the_open_area(tmp_path):
    mask = build()
    wanted = mask.wanted_ratio.sum() * 50 * mask.length * 1e3
    for suffix in (".oas", ".gds"):
        path = written(tmp_path / f"m{suffix}", mask)
        library = gdstk.read_gds(path) if suffix == ".gds" else gdstk.read_oas(path)
        polygons = library.top_level()[0].get_polygons(layer=1, datatype=0)
        assert sum(p.area() for p in polygons) == pytest.approx(wanted, rel=1e-5)
        assert flat(path).area() * 1e-6 == pytest.approx(wanted, rel=1e-5)


def test_a_format_that_would_list_too_much_is_refused_before_anything_is_made(
    tmp_path, monkeypatch
):
    """One line with the job's field, and the formats that hold the mask."""
    mask = build(rules=SLOT)
    refuse_large(mask, ["oas", "gds"], Phototool(), "job.toml")
    monkeypatch.setattr("mpfcad.mask.format.write.LARGEST_FILE", 1000)
    with pytest.raises(InputError) as refused:
        refuse_large(mask, ["oas", "gds"], Phototool(), "job.toml")
    words = str(refused.value)
    assert words.startswith("job.toml: mask.formats: gds lists apertures one by one, here in ")
    assert words.endswith("formats of oas, gbr, tif")
    with pytest.raises(InputError, match=r"^mask\.gds: mask\.formats: gds lists"):
        write_mask(mask, tmp_path / "mask.gds")
    assert list(tmp_path.iterdir()) == []


def test_jobs_name_the_formats_that_there_are():
    assert get_args(MaskFormat) == MASK_FORMATS == tuple(FORMATS)
    assert set(FORMATS) == {*READERS, "tif"}
    assert {*CLOSED_ANY, *CLOSED_LATTICE} == {
        name for name, style in FORMATS.items() if style.closes
    }
