"""Mask files: read back by another library, drawn again by a third, and tampered with."""

import subprocess
import sys
import time

import gdstk
import klayout.db as kdb
import numpy as np
import pytest
from shapely import box, union_all

from mpfcad.errors import ExportError, InputError
from mpfcad.film import CurvatureMap, Groove, PrismFilm, read_process
from mpfcad.mask import MaskRules, build_mask, check_mask, write_mask

BEF = Groove(0.050, 0.025)
PROCESS = read_process(None, BEF)
SLOT = MaskRules("slot", 0.400, 0.010, 0.015)
DOT = MaskRules("dot", 0.100, 0.010, 0.010)
CURVATURE = np.r_[np.linspace(55, 64, 30), [80.0] * 3, [60.0] * 4, 80.0, 58.0]


def build(curvature=CURVATURE, rules=SLOT, length=20.13, name="test-job"):
    film = PrismFilm(BEF, 0.2, length, "filled", np.asarray(curvature, float))
    return build_mask(film, PROCESS, rules, name)


def written(path, mask):
    write_mask(mask, path)
    return path


def flat(path):
    """Return all apertures of a file as a klayout region."""
    layout = kdb.Layout()
    layout.read(str(path))
    region = kdb.Region(layout.top_cell().begin_shapes_rec(layout.find_layer(1, 0)))
    return region.flatten()  # a region that is not flat dies with its layout


@pytest.mark.parametrize("suffix", [".oas", ".gds"])
@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_a_file_reads_back_as_what_was_wanted(tmp_path, rules, suffix):
    mask = build(rules=rules)
    check = check_mask(written(tmp_path / f"mask{suffix}", mask), mask)
    assert check.aperture_ratio_error_max < 1e-5
    assert np.abs(check.aperture_ratio - mask.aperture_ratio).max() < 1e-15
    assert check.aperture_count == mask.aperture_count == flat(tmp_path / f"mask{suffix}").count()
    assert (check.width, check.length) == (pytest.approx(39 * 0.05), pytest.approx(20.13))
    assert (check.unit, check.fiducial_count) == (0.001, 4)
    assert check.text[0] == f"test-job sha256:{mask.content_hash}"
    assert "drawn = open" in check.text[1]
    assert "emulsion" in check.text[1]


def test_smallest_aperture_and_web(tmp_path):
    slot = check_mask(written(tmp_path / "s.oas", mask := build()), mask)
    assert slot.smallest_aperture == pytest.approx(mask.along[mask.is_open].min() * 1e-6)
    assert slot.smallest_web == pytest.approx(0.05)  # the one closed groove between open ones
    wide = check_mask(written(tmp_path / "w.oas", mask := build([60.0] * 5)), mask)
    assert wide.smallest_web == pytest.approx(mask.period - mask.along[0] * 1e-6)
    dot = check_mask(written(tmp_path / "d.oas", mask := build([60.0, 55.0], DOT)), mask)
    assert dot.smallest_aperture == pytest.approx(mask.across[0] * 1e-6)
    assert dot.smallest_web == pytest.approx(0.05 - mask.across.mean() * 1e-6, abs=1e-6)


def test_a_mask_without_resin_is_an_empty_mask(tmp_path):
    mask = build([80.0] * 10)
    check = check_mask(written(tmp_path / "m.gds", mask), mask)
    assert (check.aperture_count, check.smallest_aperture, check.smallest_web) == (0, None, None)


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_oasis_and_gdsii_hold_the_same(tmp_path, rules):
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


def test_the_same_bytes_twice_and_in_another_process(tmp_path):
    code = (
        "import sys, numpy as np; from pathlib import Path; from mpfcad.film import *\n"
        "from mpfcad.mask import *\n"
        "g = Groove(0.05, 0.025); c = np.linspace(55, 63, 40)\n"
        "m = build_mask(PrismFilm(g, 0.2, 20.13, 'filled', c), read_process(None, g),\n"
        "               MaskRules('slot', 0.4, 0.01, 0.015), 'test-job')\n"
        "[write_mask(m, Path(p)) for p in sys.argv[1:]]\n"
    )
    mask = build(np.linspace(55, 63, 40))
    for suffix in (".oas", ".gds"):
        other = tmp_path / f"other{suffix}"
        subprocess.run([sys.executable, "-c", code, str(other)], check=True)
        first = written(tmp_path / f"a{suffix}", mask).read_bytes()
        assert first == written(tmp_path / f"b{suffix}", mask).read_bytes() == other.read_bytes()
    names = sorted(p.name for p in tmp_path.iterdir())
    assert names == ["a.gds", "a.oas", "b.gds", "b.oas", "other.gds", "other.oas"]


def test_arrays_stay_symbolic_and_are_split_at_the_gdsii_limit(tmp_path):
    mask = build([60.0], MaskRules("slot", 0.020, 0.001, 0.001), length=700.0)
    assert mask.period_count == 35_000
    for suffix in (".oas", ".gds"):
        path = written(tmp_path / f"m{suffix}", mask)
        assert check_mask(path, mask).aperture_count == 35_000
        assert path.stat().st_size < 30_000
        layout = kdb.Layout()
        layout.read(str(path))
        arrays = [i for i in layout.top_cell().each_inst() if i.is_regular_array()]
        assert sorted(max(i.na, i.nb) for i in arrays) == [2233, 32_767]


def panel():
    position = np.linspace(0, 32.69, 67)
    curvature = 57 + 6 * np.cos(2 * np.pi * position / 32.69)
    centres = (np.arange(7846) + 0.5) * 0.05
    curvature = CurvatureMap(position, curvature, "pitch", "repeat").on_grooves(
        centres, 32.69, 16.345
    )
    return build(curvature, length=697.68)


def test_the_whole_panel_is_small_and_quick(tmp_path):
    mask = panel()
    for suffix, size in ((".oas", 1_000_000), (".gds", 3_000_000)):
        start = time.process_time()
        check = check_mask(written(tmp_path / f"m{suffix}", mask), mask)
        assert time.process_time() - start < 3
        assert (tmp_path / f"m{suffix}").stat().st_size < size
        assert check.aperture_count == 7846 * 1744
        assert check.aperture_ratio_error_max < 5e-6


def edit(path, change):
    """Let `change(layout, top)` tamper with a file."""
    layout = kdb.Layout()
    layout.read(str(path))
    top = layout.top_cell()
    change(layout, top)
    for cell in layout.top_cells():
        if cell.name != top.name:
            cell.delete()
    layout.write(str(path))


def aperture_instance(layout, top, groove):
    """Return the array of the given groove."""
    for instance in top.each_inst():
        if instance.cell.name.startswith("A") and instance.trans.disp.x == groove * 50_000:
            return instance
    raise AssertionError(groove)


def other_size(layout, top):
    aperture_instance(layout, top, 5).cell = aperture_instance(layout, top, 25).cell


def removed(layout, top):
    aperture_instance(layout, top, 7).delete()


def shorter(layout, top):
    instance = aperture_instance(layout, top, 9)
    if instance.nb > instance.na:
        instance.nb -= 1
    else:
        instance.na -= 1


def extra(layout, top):
    top.shapes(layout.layer(1, 0)).insert(kdb.Box(31 * 50_000, 0, 31 * 50_000 + 49_000, 900_000))


def overlapping(layout, top):
    box = aperture_instance(layout, top, 3).cell.bbox().moved(3 * 50_000, 190_000)
    top.shapes(layout.layer(1, 0)).insert(box)


def outside(layout, top):
    top.shapes(layout.layer(1, 0)).insert(kdb.Box(-20_000, 0, -10_000, 10_000))


def slanted(layout, top):
    points = [kdb.Point(0, 0), kdb.Point(9_000, 0), kdb.Point(0, 9_000)]
    top.shapes(layout.layer(1, 0)).insert(kdb.Polygon(points))


def turned(layout, top):
    instance = aperture_instance(layout, top, 4)
    instance.trans = kdb.Trans(1, False, instance.trans.disp)


def sheared(layout, top):
    instance = aperture_instance(layout, top, 4)
    step = kdb.Vector(1, 400_000)
    if instance.nb > instance.na:
        instance.b = step
    else:
        instance.a = step


def outline(layout, top):
    layer = layout.find_layer(2, 0)
    top.shapes(layer).clear()
    top.shapes(layer).insert(kdb.Box(0, 0, 39 * 50_000, 20_000_000))


def no_text(layout, top):
    top.shapes(layout.find_layer(11, 0)).clear()


def no_fiducial(layout, top):
    next(i for i in top.each_inst() if i.cell.name == "FIDUCIAL").delete()


def unit(layout, top):
    layout.dbu = 0.002


TAMPER = {
    other_size: r"groove 5 \(counted from 0\): aperture ratio 0\.0\d+: wanted 0\.0\d+ ± 0\.001",
    removed: r"groove 7 \(counted from 0\): aperture ratio 0\.0+: wanted 0\.0",
    shorter: r"groove 9 \(counted|\d+ apertures: wanted \d+",
    extra: r"groove 31 \(counted from 0\): aperture ratio 0\.0\d+: wanted 0\.0+ ",
    overlapping: r"groove 3 \(counted|\d+ apertures: wanted \d+",
    outside: "outside the outline",
    slanted: "no rectangle",
    turned: "turned or scaled",
    sheared: "oblique",
    outline: "outline .*wanted",
    no_text: "text: wanted 'test-job'",
    no_fiducial: "3 fiducials: wanted 4",
    unit: "database unit 0.002 µm: wanted 0.001",
}


@pytest.mark.parametrize("change", TAMPER)
@pytest.mark.parametrize("suffix", [".oas", ".gds"])
def test_tampering_is_found(tmp_path, change, suffix):
    mask = build()
    path = written(tmp_path / f"m{suffix}", mask)
    edit(path, lambda layout, top: None)
    check_mask(path, mask)
    edit(path, change)
    with pytest.raises(ExportError, match=TAMPER[change]) as error:
        check_mask(path, mask)
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(f"{path}: ")


def test_overlap_that_keeps_the_count_is_found(tmp_path):
    """One array pushed onto its neighbour by a nanometre: ratios pass, the overlap does not."""
    mask = build()
    path = written(tmp_path / "m.oas", mask)

    def push(layout, top):
        instance = aperture_instance(layout, top, 6)
        instance.trans = kdb.Trans(instance.trans.disp + kdb.Vector(-1, 0))

    edit(path, push)
    with pytest.raises(ExportError, match=r"groove \d .*apertures overlap"):
        check_mask(path, mask)


def test_another_map_is_found(tmp_path):
    path = written(tmp_path / "m.oas", build())
    with pytest.raises(ExportError, match=r"groove 20 \(counted from 0\)"):
        check_mask(path, build(CURVATURE - 3 * (np.arange(39) == 20)))


def test_a_broken_file_is_an_export_error(tmp_path):
    path = written(tmp_path / "m.oas", build())
    path.write_bytes(path.read_bytes()[:200])
    for bad in (path, tmp_path / "absent.oas"):
        with pytest.raises(ExportError, match="not a readable mask"):
            check_mask(bad, build())


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"mask format '\.dxf': allowed \.oas or \.gds"):
        write_mask(build(), tmp_path / "m.dxf")
    assert not list(tmp_path.iterdir())


def test_gdstk_reads_the_same_ratio(tmp_path):
    """The writer's own library agrees on the open area of the whole mask."""
    mask = build()
    path = written(tmp_path / "m.gds", mask)
    top = gdstk.read_gds(path).top_level()[0]
    area = sum(p.area() for p in top.get_polygons(layer=1, datatype=0))
    wanted = mask.wanted_ratio.sum() * 50 * mask.length * 1e3
    assert area == pytest.approx(wanted, rel=1e-5)
