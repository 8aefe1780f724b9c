"""The order sheet, a mask made again from an export, and a maker's file compared with it."""

import json

import klayout.db as kdb
import pytest

from mpfcad.cli import run_app
from mpfcad.mask.check.read_gerber import read_gerber
from mpfcad.mask.check.read_layout import read_layout
from mpfcad.mask.check.read_oasis import read_oasis
from mpfcad.mask.check.read_svg import read_svg

JOB = """
schema = 1
name = "small"
[map]
rows = [[0.0, 50.0], [4.0, 63.0], [8.5, 50.0]]
extent = "panel"
[process]
solids_fraction = 0.5
[mask]
mesh = "150-31"
period_um = 560.0
formats = ["oas"]
[stack.override]
panel_width_mm = 8.5
panel_length_mm = 30.0
lamp_count = 1
"""
READERS = {"oas": read_oasis, "gds": read_layout, "dxf": read_layout, "gbr": read_gerber,
           "svg": read_svg}  # fmt: skip


@pytest.fixture(scope="module")
def export(tmp_path_factory):
    folder = tmp_path_factory.mktemp("order")
    (folder / "job.toml").write_text(JOB, "utf-8")
    formats = ",".join(READERS)
    out = str(folder / "out")
    assert run_app(["mask", str(folder / "job.toml"), "--format", formats, "--out", out]) == 0
    return folder


def test_the_order_is_one_page_that_states_everything(export):
    from pypdf import PdfReader

    pdf = PdfReader(export / "out" / "order.pdf")
    assert len(pdf.pages) == 1
    text = pdf.pages[0].extract_text()
    order = json.loads((export / "out" / "screen.json").read_text("utf-8"))["order"]
    for words in ("150-31 polyester", "22.5°", "slot", f"{order['smallest_aperture_um']:.3f} µm",
                  f"{order['smallest_web_um']:.3f} µm", "along the grooves (y)", "PASS",
                  order["content_sha256_12"], "squeegee's side", "4 crosses"):  # fmt: skip
        assert words in text, words
    manifest = json.loads((export / "out" / "manifest.json").read_text("utf-8"))
    assert {"order.pdf", "coupons.csv"} <= set(str(manifest).replace("'", " ").split())


def test_the_size_of_the_artwork_is_that_of_what_the_file_draws(export):
    layout = kdb.Layout()
    layout.read(str(export / "out" / "mask.gds"))
    top, box = layout.top_cell(), kdb.DBox()
    for layer in layout.layer_indexes():
        shapes = top.begin_shapes_rec(layer)
        shapes.shape_flags = kdb.Shapes.SPolygons | kdb.Shapes.SBoxes | kdb.Shapes.SPaths
        while not shapes.at_end():
            box += shapes.shape().bbox().transformed(shapes.itrans()).to_dtype(layout.dbu / 1000)
            shapes.next()
    order = json.loads((export / "out" / "screen.json").read_text("utf-8"))["order"]
    assert order["artwork_mm"] == pytest.approx([box.width(), box.height()], abs=1e-5)


def test_the_order_shows_the_artwork_of_the_file(export, tmp_path):
    from pypdf import PdfReader

    def page(folder):
        return PdfReader(folder / "order.pdf").pages[0]

    text = page(export / "out").extract_text()
    for words in ("x -10.000, 18.500; y -10.000, 40.000", "F1", "F4", "cut-out at x", "step wedge",
                  "drawn from mask.oas", "blue is open"):  # fmt: skip
        assert words in text, words
    # What was not stated is not printed as 0.
    assert "emulsion over mesh\nnot stated" in text
    # The cut-out holds the file's apertures: a closed drawing is its complement.
    for options in (["--emulsion-um", "5"], ["--polarity", "closed"], ["--format", "tif"]):
        out = tmp_path / options[1]
        assert run_app(["mask", str(export / "out"), *options, "--out", str(out)]) in (0, 1)
    assert "5 µm" in page(tmp_path / "5").extract_text()
    assert "cut-out" not in page(tmp_path / "tif").extract_text()
    drawn = [
        page(folder).get_contents().get_data() for folder in (export / "out", tmp_path / "closed")
    ]
    blue = [data.count(b"0.04 .37 .65 rg") + data.count(b".04 .37 .65 rg") for data in drawn]
    assert all(blue)


def test_smallest_features_of_the_order_are_those_of_the_file(export):
    screen = json.loads((export / "out" / "screen.json").read_text("utf-8"))
    gates = {gate["name"]: gate["value"] for gate in screen["gates"]}
    assert screen["order"]["smallest_aperture_um"] == pytest.approx(gates["screen_aperture_um"])
    assert screen["order"]["smallest_web_um"] == pytest.approx(gates["screen_web_um"])


@pytest.mark.parametrize("suffix", READERS)
def test_the_facts_stand_in_the_text_of_every_format(export, suffix):
    text = "\n".join(READERS[suffix](export / "out" / f"mask.{suffix}").text)
    for words in ("mesh 150-31 polyester at 22.5 deg", "smallest aperture", "squeegee along y",
                  "revision A", "drawn = open"):  # fmt: skip
        assert words in text


def test_the_same_order_gives_the_same_bytes(export, tmp_path):
    job = str(export / "job.toml")
    assert run_app(["mask", job, "--format", "oas", "--out", str(tmp_path / "a")]) == 0
    assert run_app(["mask", job, "--format", "oas", "--out", str(tmp_path / "b")]) == 0
    for name in ("order.pdf", "mask.oas", "screen.json", "coupons.csv"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_wedge_goes_beyond_the_job_s_own_ratios(export):
    order = json.loads((export / "out" / "screen.json").read_text("utf-8"))["order"]
    ratios, (low, high) = order["coupon_aperture_ratio"], order["aperture_ratio"]
    assert ratios[0] == 0 and ratios[-1] == 1
    assert ratios[1] == pytest.approx(low / 1.6, rel=0.01)
    assert ratios[-2] > high
    rows = (export / "out" / "coupons.csv").read_text("utf-8").splitlines()
    assert rows[0] == "file,aperture_ratio"
    assert [float(row.split(",")[1]) for row in rows[1:]] == ratios[1:-1]


def test_an_export_is_issued_again(export, tmp_path, capsys):
    out = export / "out"
    again = tmp_path / "again"
    assert run_app(["mask", str(out), "--format", "oas", "--out", str(again)]) == 0
    assert (again / "mask.oas").read_bytes() == (out / "mask.oas").read_bytes()
    assert (again / "curvature.csv").read_bytes() == (out / "curvature.csv").read_bytes()
    options = ["--mesh", "140-34", "--mirror", "--revision", "B", "--format", "gds"]
    other = tmp_path / "other"
    assert run_app(["mask", str(out), *options, "--out", str(other)]) == 0
    order = json.loads((other / "screen.json").read_text("utf-8"))["order"]
    assert (order["mesh"], order["mirror"], order["revision"]) == ("140-34", True, "B")
    # An export that was issued again can be issued again.
    third = tmp_path / "third"
    options = ["--mesh", "150-31", "--no-mirror", "--revision", "A", "--format", "oas"]
    assert run_app(["mask", str(other), *options, "--out", str(third)]) == 0
    assert (third / "mask.oas").read_bytes() == (out / "mask.oas").read_bytes()


def test_a_folder_that_is_no_export_is_refused(tmp_path, capsys):
    assert run_app(["mask", str(tmp_path)]) == 2
    assert "no verification.json or screen.json: expected a job, or an export" in (
        capsys.readouterr().err
    )


@pytest.mark.parametrize("suffix", ["oas", "gds", "gbr", "dxf"])
def test_what_comes_back_unchanged_is_the_same(export, capsys, suffix):
    job, file = str(export / "job.toml"), str(export / "out" / f"mask.{suffix}")
    assert run_app(["mask", job, "--compare", file]) == 0
    assert capsys.readouterr().out == "the same in all 170 grooves\n"


def test_a_dxf_in_another_unit_is_refused(export, tmp_path, capsys):
    text = (export / "out" / "mask.dxf").read_text("utf-8")
    assert text.count("$INSUNITS\n 70\n4\n") == 1
    for unit, code, words in ((1, 2, "$INSUNITS 1 (in): its numbers are not mm"), (0, 0, "")):
        file = tmp_path / "back.dxf"
        file.write_text(text.replace("$INSUNITS\n 70\n4\n", f"$INSUNITS\n 70\n{unit}\n"), "utf-8")
        assert run_app(["mask", str(export / "job.toml"), "--compare", str(file)]) == code
        assert words in capsys.readouterr().err


def edited(export, tmp_path, change):
    """Return the export's GDSII as a maker's program may write it."""
    layout = kdb.Layout()
    layout.read(str(export / "out" / "mask.gds"))
    change(layout, layout.top_cell())
    path = tmp_path / "returned.gds"
    layout.write(str(path))
    return str(path)


def merged(layout, top):
    layer = layout.find_layer(1, 0)
    region = kdb.Region(top.begin_shapes_rec(layer)).merged()
    layout.clear_layer(layer)
    top.shapes(layer).insert(region)


def moved(layout, top):
    layout.transform(kdb.Trans(kdb.Vector(5_000_000, 7_000_000)))


def mirrored(layout, top):
    merged(layout, top)
    top.transform(kdb.Trans(kdb.Trans.M90))


def without_groove_7(layout, top):
    merged(layout, top)
    layer = layout.find_layer(1, 0)
    strip = kdb.Region(kdb.Box(7 * 50_000, 0, 8 * 50_000, 30_000_000))
    region = kdb.Region(top.shapes(layer)) - strip
    top.shapes(layer).clear()
    top.shapes(layer).insert(region)


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (merged, 0, "shapes instead of 9180 apertures"),
        (moved, 1, "moved as a whole by 5.000000, 7.000000 mm"),
        (mirrored, 1, "moved as a whole by -8.500000, 0.000000 mm"),
        (without_groove_7, 1, "groove 7: aperture ratio 0.000000: expected 0."),
    ],
)
def test_what_a_maker_changed_is_said(export, tmp_path, capsys, change, code, words):
    file = edited(export, tmp_path, change)
    assert run_app(["mask", str(export / "job.toml"), "--compare", file]) == code
    assert words in capsys.readouterr().out


def beyond_the_panel(layout, top):
    merged(layout, top)
    layer = layout.find_layer(1, 0)
    top.shapes(layer).insert(kdb.Box(8_490_000, 0, 8_510_000, 1_000_000))


def test_apertures_beyond_the_panel_are_refused_with_their_place(export, tmp_path, capsys):
    """They lie over no groove, so that no ratio tells them."""
    file = edited(export, tmp_path, beyond_the_panel)
    assert run_app(["mask", str(export / "job.toml"), "--compare", file]) == 2
    error = capsys.readouterr().err
    assert "returned.gds: apertures reach over x " in error and "8.510000" in error
    assert "expected them on the panel, 0 … 8.500000" in error and len(error.splitlines()) == 1


def one_nanometre(layout, top):
    merged(layout, top)
    layer = layout.find_layer(1, 0)
    shape = next(top.shapes(layer).each())
    box = shape.bbox()
    top.shapes(layer).insert(kdb.Box(box.left, box.bottom, box.right, box.top + 1))


def test_a_nanometre_is_seen_in_the_digits(export, tmp_path, capsys):
    file = edited(export, tmp_path, one_nanometre)
    assert run_app(["mask", str(export / "job.toml"), "--compare", file]) == 1
    line = next(line for line in capsys.readouterr().out.splitlines() if "ratio" in line)
    seen, wanted = line.split("ratio ")[1].split(": expected ")
    assert seen != wanted


def with_job(tmp_path, change):
    (tmp_path / "job.toml").write_text(change(JOB), "utf-8")
    return str(tmp_path / "job.toml")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('["oas"]', '["oas", "dxf"]\npolarity = "closed"', "mask.polarity: closed: dxf cannot"),
        ('["oas"]', '["tif"]', "mask.formats: tif: a pixel of 10 µm is 0.0017"),
        ('mesh = "150-31"\nperiod_um = 560.0', 'pattern = "error-diffused"',
         "mask.pattern: error-diffused: one dot of 35 µm is 0.0041"),
    ],
)  # fmt: skip
def test_what_a_format_cannot_hold_is_refused_before_work(tmp_path, capsys, old, new, words):
    job = with_job(tmp_path, lambda text: text.replace(old, new).replace("mm = 30.0", "mm = 6.0"))
    assert run_app(["mask", job, "--out", str(tmp_path / "out")]) == 2
    assert words in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_mask_without_furniture_is_made(tmp_path):
    job = with_job(tmp_path, lambda text: text.replace('["oas"]', '["oas"]\nfurniture = []'))
    out = str(tmp_path / "out")
    assert run_app(["mask", job, "--format", "oas,gds,dxf,gbr,svg", "--out", out]) == 0


def test_without_a_mesh_it_is_a_phototool_only(tmp_path, capsys):
    bare = 'mesh = "150-31"\n'
    job = with_job(tmp_path, lambda text: text.replace(bare, ""))
    assert run_app(["mask", job, "--plan"]) == 0
    assert "phototool only: the job names no mesh" in capsys.readouterr().out
    assert run_app(["mask", job, "--out", str(tmp_path / "out")]) == 0
    assert "printability: phototool only" in capsys.readouterr().out
    text = "\n".join(read_oasis(tmp_path / "out" / "mask.oas").text)
    assert "phototool only: no mesh named" in text


def test_the_ripple_is_what_another_program_finds_in_the_file(tmp_path):
    """Slots of one groove from the OASIS by gdstk, averaged with numpy; period 2.2 mm."""
    import gdstk
    import numpy as np

    from mpfcad.film import Groove

    job = with_job(tmp_path, lambda text: text.replace("560.0", "2200.0").replace(
        "mm = 30.0", "mm = 110.0"))  # fmt: skip
    assert run_app(["mask", job, "--out", str(tmp_path / "out")]) == 1  # such a ripple fails
    screen = json.loads((tmp_path / "out" / "screen.json").read_text("utf-8"))
    printing = screen["printing"]
    left = printing["ripple_groove"] * 50.0
    step = 2.0  # µm
    opened = np.zeros(round(110_000 / step))
    top = gdstk.read_oas(tmp_path / "out" / "mask.oas", unit=1e-6).top_level()[0]
    for polygon in top.flatten().get_polygons(layer=1, datatype=0):
        x, y = polygon.points.T
        if x.min() <= left + 25 < x.max():
            opened[round(y.min() / step) : round(y.max() / step)] = 1
    sigma = printing["levelling_length_mm"] * 1000 / (2 * (2 * np.log(2)) ** 0.5) / step
    kernel = np.exp(-0.5 * (np.arange(-round(5 * sigma), round(5 * sigma) + 1) / sigma) ** 2)
    levelled = np.convolve(opened, kernel / kernel.sum(), "same")[10_000:-10_000]
    ratio, groove = opened.mean(), Groove(0.050, 0.025)
    curvature = curvature_of(tmp_path / "out" / "curvature.csv", printing["ripple_groove"])
    fill = float(groove.fill_fraction(curvature))
    wave = np.clip(fill * levelled / ratio, 0, 1)
    slope = (groove.curvature_of_fill(fill * 0.999) - groove.curvature_of_fill(fill * 1.001)) / (
        0.002 * fill
    )
    found = float(np.sqrt(np.mean((wave - fill) ** 2))) * slope
    assert printing["ripple_curvature_per_mm"] == pytest.approx(found, rel=0.05)


def curvature_of(path, groove):
    """Return the curvature of a groove in curvature.csv [1/mm]."""
    row = path.read_text("utf-8").splitlines()[groove + 1]
    return float(row.split(",")[2])
