"""The documentation: its site builds without a warning, and what it tells one to type works."""

import re
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pytest
import tifffile
from command import mpfcad
from page import DOCS, NAMED, blocks, write_files

from mpfcad.cli import run_app

#: Pages that tell one to type commands and need no file of one's own.
TYPED = ("tutorial", "howto-backlight", "howto-led", "howto-measured", "python")


def take_photos(folder):
    """Write the images that the page on measured screens takes: photo, dark frame, flat field."""
    rng = np.random.default_rng(5)
    place = np.arange(160)
    lens = 1 - 0.1 * ((place - 80) / 80) ** 2
    wave = 1 + 0.006 * np.cos(2 * np.pi * (0.5 * place - 5.3) / 32.69)
    for name, light in (("photo", 23_800 * wave * lens), ("flat", 20_000 * lens), ("dark", 0.0)):
        counts = light + 100 + rng.normal(0, 60, (120, 160))
        tifffile.imwrite(folder / f"{name}.tif", np.clip(counts, 0, 65_535).astype(np.uint16))


def test_the_site_builds_strictly_and_asks_nothing_of_a_network(tmp_path):
    command = [
        sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", DOCS, tmp_path,
    ]  # fmt: skip
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    for page in tmp_path.rglob("*.html"):
        text = page.read_text("utf-8")
        asked = re.findall(r'<(?:script|img|link|iframe)[^>]+(?:src|href)="(https?:[^"]+)"', text)
        assert asked == [], page.name
    assert "<math" in (tmp_path / "theory.html").read_text("utf-8")


def test_every_page_stands_in_the_index():
    index = (DOCS / "index.md").read_text("utf-8")
    names = {path.stem for path in DOCS.glob("*.md")} - {"index"}
    assert {name for name in names if not re.search(rf"^{name}$", index, re.MULTILINE)} == set()


def test_a_measured_screen_is_judged_as_its_page_says(tmp_path, monkeypatch, capsys):
    page = blocks("howto-measured")
    (tmp_path / "luminance.csv").write_text(NAMED.sub("", page[0][1]), "utf-8")
    take_photos(tmp_path)
    monkeypatch.chdir(tmp_path)
    lines = [line for language, text in page if language == "sh" for line in text.splitlines()]
    alone = [line for line in lines if line.startswith("mpfcad judge") and "--against" not in line]
    printed = []
    for line in alone:
        assert run_app(shlex.split(line)[1:]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == page[2][1]
    assert len(printed) == 4 and (tmp_path / "judged.html").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("page", TYPED)
def test_what_a_page_tells_one_to_type_works(page, tmp_path):
    ran = 0
    take_photos(tmp_path)
    write_files(page, tmp_path)
    for language, text in blocks(page):
        if language == "sh":
            for line in text.strip().splitlines():
                typed(line, tmp_path)
                ran += 1
    script = "".join(text for language, text in blocks(page) if language == "python")
    if script:
        command = [sys.executable, "-c", script]
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, timeout=1200)
        assert done.returncode == 0, done.stderr
        ran += 1
    assert ran > 0
    shutil.rmtree(tmp_path / "exports", ignore_errors=True)


def typed(line, folder):
    """Run a line of a page; a film of it may be INCONCLUSIVE after a quick trace, or fail."""
    program, *arguments = shlex.split(line)
    assert program == "mpfcad"
    done = mpfcad(*arguments, cwd=folder, timeout=1200)
    expected = (0, 1) if arguments[0] in ("run", "verify") else (0,)
    assert done.returncode in expected, (line, done.stderr)
