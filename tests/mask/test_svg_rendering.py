"""What renderers make of an SVG: the share that is black, in windows of the panel."""

import io
import re
import shutil
import subprocess

import numpy as np
import pytest
import resvg_py
from PIL import Image
from small_mask import build, written

from mpfcad.mask import MaskRules, Phototool

RULES = {
    "slot": MaskRules("slot", 0.4, 0.01, 0.015),
    "staggered": MaskRules("staggered", 0.05, 0.008, 0.008),
    "error-diffused": MaskRules("error-diffused", 0.05, 0.008, 0.008),
}
PIXELS = 1000


def window(path, x, y, side):
    """Return the SVG cut to a square window whose lower left corner is x, y [mm]."""
    text = path.read_text("utf-8")
    foot = float(re.search(r"matrix\(1 0 0 -1 0 ([\d.]+)\)", text)[1]) - y - side
    head = re.search(r'width="\S+mm" height="\S+mm" viewBox="[^"]+"', text)[0]
    cut = f'width="{PIXELS}" height="{PIXELS}" viewBox="{x} {foot} {side} {side}"'
    return text.replace(head, cut, 1)


def black(png):
    pixels = np.asarray(Image.open(io.BytesIO(png)).convert("RGBA"))
    return float(((pixels[..., 3] > 127) & (pixels[..., 0] < 128)).mean())


def wanted(mask, x, y, side, polarity):
    first, count = round(x / mask.pitch), round(side / mask.pitch)
    opened = np.diff(mask.open_length(first, count, np.array([y, y + side])), axis=1)
    ratio = float(opened.mean()) / side
    return ratio if polarity == "open" else 1 - ratio


@pytest.mark.parametrize("polarity", ["open", "closed"])
@pytest.mark.parametrize("pattern", RULES)
def test_resvg_renders_the_ratio(tmp_path, pattern, polarity):
    mask = build(np.linspace(54, 61, 80), RULES[pattern], length=60.0)
    path = written(tmp_path / "m.svg", mask, Phototool(polarity=polarity, furniture=()))
    side = 0.5 if pattern == "staggered" else 2.0  # dots of 13 µm: pixels of 0.5 µm
    for x, y in ((0.0, 0.0), (2.0, 58.0)):
        png = bytes(resvg_py.svg_to_bytes(svg_string=window(path, x, y, side)))
        assert black(png) == pytest.approx(wanted(mask, x, y, side, polarity), abs=2e-3)


@pytest.mark.parametrize("renderer", ["rsvg-convert", "chromium", "inkscape"])
def test_other_renderers_render_the_ratio_where_they_are(tmp_path, renderer):
    if shutil.which(renderer) is None:
        assert resvg_py  # the test above has rendered it
        return
    mask = build(np.linspace(54, 61, 80), RULES["slot"], length=60.0)
    path = written(tmp_path / "m.svg", mask, Phototool(furniture=()))
    cut, png = tmp_path / "cut.svg", tmp_path / "cut.png"
    cut.write_text(window(path, 2.0, 58.0, 2.0), "utf-8")
    command = ["rsvg-convert", "-o", str(png), str(cut)]
    if renderer == "inkscape":
        command = ["inkscape", "--export-type=png", f"--export-filename={png}",
                   f"--export-width={PIXELS}", f"--export-height={PIXELS}", str(cut)]  # fmt: skip
    if renderer == "chromium":
        command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu",
                   "--disable-background-networking", "--hide-scrollbars",
                   f"--window-size={PIXELS},{PIXELS}", f"--screenshot={png}",
                   f"file://{cut}"]  # fmt: skip
    subprocess.run(command, check=True, capture_output=True, timeout=120)
    found = black(png.read_bytes())
    assert found == pytest.approx(wanted(mask, 2.0, 58.0, 2.0, "open"), abs=2e-3)
