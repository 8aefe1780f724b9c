"""A file that was changed behind our back is found out, in every format."""

import re

import gdstk
import klayout.db as kdb
import numpy as np
import pytest
from small_mask import CURVATURE, build, written

from mpfcad.errors import ExportError
from mpfcad.mask import check_mask


def edit(path, change):
    """Let `change(layout, top)` tamper with a GDSII file."""
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
        if instance.cell.name.startswith("L1R") and instance.trans.disp.x == groove * 50_000:
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
    shapes = top.shapes(layout.find_layer(10, 0))
    shapes.erase(next(shapes.each()))


def no_wedge(layout, top):
    next(i for i in top.each_inst() if i.cell.name.startswith("L20R")).delete()


def unit(layout, top):
    layout.dbu = 0.002


TAMPER = {
    other_size: r"groove 5 \(counted from 0\): an aperture is not where, or not as large",
    removed: r"groove 7 \(counted from 0\): an aperture is not where, or not as large",
    shorter: r"groove 9 \(counted|\d+ apertures: expected \d+",
    extra: r"groove 31 \(counted from 0\): an aperture is not where, or not as large",
    overlapping: r"groove 3 \(counted|\d+ apertures: expected \d+",
    outside: "expected them on the panel",
    slanted: "no rectangle",
    turned: "turned or scaled",
    sheared: "oblique",
    outline: "outline .*expected",
    no_text: "text: states no polarity",
    no_fiducial: "3 fiducials: expected 4",
    no_wedge: "coupon: expected the step wedge",
    unit: "database unit 0.002 µm: expected 0.001",
}


@pytest.mark.parametrize("change", TAMPER)
def test_tampering_with_gdsii_is_found(tmp_path, change):
    mask = build()
    path = written(tmp_path / "m.gds", mask)
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
    path = written(tmp_path / "m.gds", mask)

    def push(layout, top):
        instance = aperture_instance(layout, top, 6)
        instance.trans = kdb.Trans(instance.trans.disp + kdb.Vector(-1, 0))

    edit(path, push)
    with pytest.raises(ExportError, match=r"grooves 5-6 .*: an aperture is not where"):
        check_mask(path, mask)


def aperture(top, groove):
    return next(p for p in top.polygons if p.layer == 1 and p.points[0][0] == groove * 50)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda top: top.remove(aperture(top, 7)), r"groove 7 .*an aperture is not where"),
        (lambda top: aperture(top, 5).scale(1, 1.2), "groove 5 "),
        (
            lambda top: top.labels[0].__setattr__("text", "other sha256:0"),
            "text: expected 'test-job'",
        ),
        (lambda top: top.remove(*[p for p in top.polygons if p.layer == 20]), "coupon: expected"),
    ],
)
def test_tampering_with_oasis_is_found(tmp_path, change, message):
    mask = build()
    path = written(tmp_path / "m.oas", mask)
    library = gdstk.read_oas(path)
    change(library.top_level()[0])
    library.write_oas(path, validation="crc32")
    with pytest.raises(ExportError, match=message):
        check_mask(path, mask)


def test_a_flipped_byte_is_found(tmp_path, suffix):
    """Anywhere in the file: what is read differs, or cannot be read; or the byte means nothing."""
    mask = build()
    path = written(tmp_path / f"m.{suffix}", mask)
    whole = path.read_bytes()
    found = 0
    places = np.linspace(0, len(whole) - 1, 25).astype(int)
    for place in places:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 9]) + whole[place + 1 :])
        try:
            check_mask(path, mask)
        except ExportError as error:
            assert "\n" not in str(error)
            found += 1
    # Furniture's letters and DXF's header may change unseen; the manifest's hash holds them.
    assert found >= {"oas": 25, "gds": 5, "dxf": 2, "gbr": 6, "svg": 6}[suffix]


TEXTUAL = {
    "svg": [
        (r'stroke-dasharray="0\.02', r'stroke-dasharray="0.03', "whole number of dashes|groove"),
        (r'viewBox="(\S+) 0 (\S+)', r'viewBox="\1 0 9', "one unit is"),
        (r'(<use xlink:href="#a0" x="0.025" y="[.\d]+)"', r'\g<1>4567"', "off the 1 nm grid"),
        (r'(d="M0 0V\d)', r"\g<1>9", "whole number of dashes|line with gaps|outside|groove"),
        ("drawn = open", "drawn = closed", "is not what is painted"),
        (r'(<g class="aperture" fill=)"#000"', r'\1"#fff"', "wrong polarity"),
    ],
    "gbr": [
        ("%MOMM", "%MOIN", "no command of a mask"),
        (r"%SRX1Y(\d+)I0.000000J0\.4", r"%SRX1Y\1I0.000000J0.3", "apertures|groove|outline|coupon"),
        ("drawn = open", "drawn = closed", "is not what is painted"),
        (r"M02\*\n", "", "not a readable mask"),
        (r"%ADD(\d+)R,0.050000X", r"%ADD\1R,0.040000X", "groove"),
    ],
    "dxf": [("sha256:", "sha512:", "text: expected 'test-job'")],
}


@pytest.mark.parametrize(
    ("suffix", "change"), [(s, c) for s, changes in TEXTUAL.items() for c in changes]
)
def test_tampering_with_text_formats_is_found(tmp_path, suffix, change):
    mask = build()
    path = written(tmp_path / f"m.{suffix}", mask)
    text = path.read_text()
    changed = re.sub(change[0], change[1], text)
    assert changed != text
    path.write_text(changed)
    with pytest.raises(ExportError, match=change[2]):
        check_mask(path, mask)


def test_another_map_is_found(tmp_path, suffix):
    path = written(tmp_path / f"m.{suffix}", build())
    with pytest.raises(ExportError, match=r"groove 20 \(counted from 0\)"):
        check_mask(path, build(CURVATURE - 3 * (np.arange(39) == 20)))


def test_a_broken_file_is_an_export_error(tmp_path, suffix):
    path = written(tmp_path / f"m.{suffix}", build())
    path.write_bytes(path.read_bytes()[:200])
    for bad in (path, tmp_path / f"absent.{suffix}"):
        with pytest.raises(ExportError, match=r"not a readable|no element|no command of a mask"):
            check_mask(bad, build())


@pytest.mark.parametrize("side", ["left", "bottom", "right", "top"])
def test_a_fiducial_that_reaches_into_the_panel_is_found(tmp_path, side):
    """By one nanometre it is refused; beside the panel, touching its edge, it is not."""
    mask = build()
    width, length = round(mask.width * 1e6), round(mask.length * 1e6)
    path = written(tmp_path / "m.gds", mask)

    def place(inside):
        def move(layout, top):
            shape = next(top.shapes(layout.find_layer(10, 0)).each())
            box = shape.bbox()
            middle = (width // 2 - box.center().x, length // 2 - box.center().y)
            x, y = {
                "left": (inside - box.right, middle[1]),
                "right": (width - inside - box.left, middle[1]),
                "bottom": (middle[0], inside - box.top),
                "top": (middle[0], length - inside - box.bottom),
            }[side]
            shape.transform(kdb.Trans(x, y))

        return move

    edit(path, place(0))
    check_mask(path, mask)
    edit(path, place(1))
    with pytest.raises(ExportError, match="a fiducial inside the panel"):
        check_mask(path, mask)
