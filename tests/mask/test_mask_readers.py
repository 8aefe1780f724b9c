"""Each format opened by software that has nothing to do with ours, and compared place by place."""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import ezdxf
import ezdxf.bbox
import klayout.db as kdb
import klayout.rdb as rdb
import numpy as np
import pytest
from PIL import Image
from pygerber.gerberx3.parser2.parser2 import Parser2
from pygerber.gerberx3.tokenizer.tokenizer import Tokenizer
from small_mask import DOT, SLOT, build, flat_boxes, written

from mpfcad.errors import ExportError
from mpfcad.gate import demand
from mpfcad.mask import MaskRules, Phototool, check_mask, write_markers, write_preview
from mpfcad.mask.check.check import SQUARE
from mpfcad.mask.check.drc import check_windows, sample_windows
from mpfcad.mask.check.found import FoundMask, region_of
from mpfcad.mask.check.preview import panel_ratio, whole_periods

SHORT = [55.0, 57.5, 60.0, 80.0, 61.0]


def short(rules=SLOT):
    return build(SHORT, rules, length=4.1)


def same(found, wanted, tolerance=0):
    found = np.array(found, float)
    found = found[np.lexsort(np.rint(found).T)]
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).max() <= tolerance


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_klayout_reads_strict_oasis(tmp_path, rules):
    mask = short(rules)
    options = kdb.LoadLayoutOptions()
    options.oasis_expect_strict_mode = 1
    layout = kdb.Layout()
    layout.read(str(written(tmp_path / "m.oas", mask)), options)
    shapes = layout.top_cell().shapes(layout.find_layer(1, 0))
    boxes = [(b.left, b.bottom, b.right, b.top) for b in (s.box for s in shapes.each())]
    same(boxes, flat_boxes(mask))
    names = {layout.get_info(i).to_s() for i in layout.layer_indexes()}
    assert names == {
        "aperture (1/0)", "outline (2/0)", "fiducial (10/0)", "text (11/0)", "coupon (20/0)"
    }  # fmt: skip


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_ezdxf_reads_dxf(tmp_path, rules):
    mask = short(rules)
    document = ezdxf.readfile(written(tmp_path / "m.dxf", mask))
    assert document.dxfversion == "AC1015"  # R2000
    assert document.header["$INSUNITS"] == 4  # mm
    assert document.header["$MEASUREMENT"] == 1
    low, high = document.header["$EXTMIN"], document.header["$EXTMAX"]
    assert not document.audit().errors
    boxes = []
    for insert in document.modelspace().query('INSERT[layer=="APERTURE_1"]'):
        for copy in insert.multi_insert():
            for line in copy.virtual_entities():
                assert line.is_closed
                corner = np.array(list(line.vertices()))[:, :2]
                boxes.append((*corner.min(axis=0), *corner.max(axis=0)))
    same(np.array(boxes) * 1e6, flat_boxes(mask), 1e-3)
    drawn = ezdxf.bbox.extents(document.modelspace().query("LWPOLYLINE"))
    assert np.all(np.array(low) <= np.array(drawn.extmin) + 1e-6)
    assert np.all(np.array(high) >= np.array(drawn.extmax) - 1e-6)
    text = [entity.dxf.text for entity in document.modelspace().query("TEXT")]
    assert "unit: mm" in text
    assert Phototool().statement in text


@pytest.mark.parametrize("rules", [SLOT, DOT])
def test_pygerber_reads_gerber(tmp_path, rules):
    mask = short(rules)
    text = written(tmp_path / "m.gbr", mask).read_text()
    width, length = mask.width, mask.length
    boxes = []
    for flash in flashes(Parser2().parse(Tokenizer().tokenize(text)).commands):
        x, y = (float(v.value) for v in (flash.flash_point.x, flash.flash_point.y))
        w, h = (float(v.value) for v in (flash.aperture.x_size, flash.aperture.y_size))
        if 0 <= x <= width and 0 <= y <= length:
            boxes.append((x - w / 2, y - h / 2, x + w / 2, y + h / 2))
    same(np.array(boxes) * 1e6, flat_boxes(mask), 0.501)


def flashes(commands):
    """Yield the flashes of a command buffer, those of step-and-repeat blocks too."""
    for command in commands:
        if type(command).__name__ == "Flash2":
            yield command
        elif hasattr(command, "command_buffer") and type(command).__name__ != "Region2":
            yield from flashes(command.command_buffer.commands)


def test_an_xml_reader_finds_the_apertures_of_svg(tmp_path):
    mask = short()
    root = ElementTree.parse(written(tmp_path / "m.svg", mask)).getroot()
    space = "{http://www.w3.org/2000/svg}"
    count = area = 0
    group = next(g for g in root.iter(f"{space}g") if g.get("class") == "aperture")
    lines = {line.get("id"): line for line in group.iter(f"{space}path")}
    for use in group.iter(f"{space}use"):
        line = lines[use.get("{http://www.w3.org/1999/xlink}href")[1:]]
        dash, gap = (float(value) for value in use.get("stroke-dasharray").split())
        rows = round(float(line.get("d").rpartition("V")[2]) / (dash + gap))
        count += rows
        area += rows * dash * float(line.get("stroke-width"))
    assert count == mask.aperture_count
    assert area / (mask.width * mask.length) == pytest.approx(mask.aperture_ratio.mean(), rel=1e-9)


@pytest.mark.parametrize(
    "tool",
    [
        Phototool(dpi=5080, furniture=()),
        Phototool("closed", mirror=True, dpi=5080, furniture=()),
    ],
)
def test_pillow_reads_tiff(tmp_path, tool):
    """Edges within half a pixel across; the open area of each groove is right all the same."""
    mask = build([55.0, 57.5, 60.0, 61.0], length=40.0)
    path = written(tmp_path / "m.tif", mask, tool)
    with Image.open(path) as picture:
        assert picture.mode == "1"
        assert picture.info["dpi"] == (5080, 5080)
        pixels = ~np.asarray(picture)  # black is drawn
        text = picture.tag_v2[270]
    words = text.splitlines()[-1].split()
    left, bottom = int(words[3]), int(words[7])
    columns, rows = 40, 8000  # 5 µm pixels: 0.2 mm × 40 mm
    panel = pixels[len(pixels) - bottom - rows : len(pixels) - bottom, left : left + columns]
    if tool.mirror:
        panel = panel[:, ::-1]
    ratio = panel.reshape(rows, 4, 10).mean(axis=(0, 2))
    ratio = ratio if tool.polarity == "open" else 1 - ratio
    assert np.abs(ratio - mask.aperture_ratio).max() < 1e-3
    check = check_mask(path, mask, tool)
    assert check.aperture_ratio == pytest.approx(ratio)
    assert check.snap_error == pytest.approx(0.0025)
    assert tool.statement in check.text
    assert "edges snapped by up to half a pixel" in text
    damaged = bytearray(path.read_bytes())
    damaged[len(damaged) // 2] ^= 255
    path.write_bytes(damaged)
    with pytest.raises(ExportError, match=r"damaged|groove|readable"):
        demand(check_mask(path, mask, tool).gates)


def narrow_file():
    """Return a found mask with an aperture of 9 µm and a web of 8 µm."""
    boxes = [(0, 0, 50_000, 9_000), (0, 17_000, 50_000, 47_000), (0, 100_000, 50_000, 130_000)]
    from mpfcad.mask import ApertureArray, Placement

    arrays = [ApertureArray((b[2] - b[0], b[3] - b[1]), Placement(b[:2])) for b in boxes]
    return FoundMask(
        outline=(0, 0, 50_000, 200_000),
        unit=0.001,
        text=(),
        fiducials=(),
        coupon=(),
        drawn="open",
        arrays=lambda: iter(arrays),
        window=lambda box: region_of(iter(arrays), box),
    )


def test_what_is_too_narrow_is_marked(tmp_path):
    found = narrow_file()
    check = check_windows(
        found, MaskRules("slot", 0.4, 0.015, 0.015), sample_windows(found.outline)
    )
    assert sorted({v.rule for v in check.violations}) == ["min_aperture", "min_web"]
    path = tmp_path / "m.lyrdb"
    write_markers(path, "mask.oas", check)
    first = path.read_bytes()
    write_markers(path, "mask.oas", check)
    assert path.read_bytes() == first
    report = rdb.ReportDatabase("read")
    report.load(str(path))
    count = {category.path(): category.num_items() for category in report.each_category()}
    assert count == {"min_aperture": 1, "min_web": 1, "window": len(check.windows)}
    markers = [
        v.box() for i in report.each_item() for v in i.each_value()
        if report.category_by_id(i.category_id()).path() != "window"
    ]  # fmt: skip
    assert sorted(round(min(box.width(), box.height()), 3) for box in markers) == [8.0, 9.0]


def test_the_preview_is_a_picture_of_the_file(tmp_path):
    mask = build(np.r_[np.full(20, 55.0), np.full(20, 62.0)], length=20.0)
    path = written(tmp_path / "m.oas", mask)
    check = check_mask(path, mask)
    for name in ("a.png", "b.png"):
        write_preview(tmp_path / name, path, check, mask)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    with Image.open(tmp_path / "a.png") as picture:
        pixels = np.asarray(picture.convert("L"), float)
    panel = pixels[70:740, 26:85]  # wide open on the left is dark
    assert panel[:, :25].mean() < panel[:, -25:].mean() - 50
    code = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[2])\n"
        "from small_mask import *\n"
        "from mpfcad.mask import *\n"
        "p = Path(sys.argv[1])\n"
        "m = build(np.r_[np.full(20, 55.0), np.full(20, 62.0)], length=20.0)\n"
        "write_preview(p.with_name('c.png'), p, check_mask(p, m), m)\n"
    )
    subprocess.run([sys.executable, "-c", code, str(path), str(Path(__file__).parent)], check=True)
    assert (tmp_path / "c.png").read_bytes() == (tmp_path / "a.png").read_bytes()


def test_the_preview_has_no_beats_of_squares_with_slots(tmp_path):
    """Slots of 640 µm in squares of 1 mm: a square holds one or two of them."""
    rules = MaskRules("slot", 0.640, 0.010, 0.015)
    mask = build(np.linspace(50.0, 62.0, 60), rules, length=32.0)
    path = written(tmp_path / "m.oas", mask)
    check = check_mask(path, mask)
    assert np.ptp(check.ratio_map, axis=0).max() > 0.01
    shown = panel_ratio(check, mask)
    assert shown.max() == check.aperture_ratio.max()
    assert shown.min() == check.aperture_ratio.min()
    assert np.ptp(shown, axis=0).max() == 0


def test_a_map_that_varies_along_is_averaged_over_whole_periods():
    assert whole_periods(0.640) * SQUARE / 0.640 == pytest.approx(11, abs=0.11)
    assert whole_periods(0.400) == 2
    assert whole_periods(1.0) == 1
