"""What is printed reads in any encoding and terminal."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from mpfcad.cli.character import PLAIN

CODE = "from mpfcad.cli import main; main()"


def run(*arguments, encoding=None, columns=None, cwd=None, **options):
    environment = dict(os.environ)
    if encoding:
        environment |= {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    if columns:
        environment |= {"COLUMNS": str(columns)}
    command = [sys.executable, "-c", CODE, *map(str, arguments)]
    return subprocess.run(
        command, capture_output=True, env=environment, cwd=cwd, timeout=120, **options
    )


@pytest.fixture(scope="module")
def plain():
    return run("stacks").stdout.decode()


@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "cp437", "utf-8"])
def test_text_reads_in_any_encoding(encoding, plain):
    found = run("stacks", encoding=encoding)
    assert (found.returncode, found.stderr) == (0, b"")
    text = found.stdout.decode(encoding)
    assert len(text.splitlines()) == len(plain.splitlines())
    assert text.count("thesis-32in-mpf") == plain.count("thesis-32in-mpf")
    assert text.count("?") == plain.count("?")


def test_json_is_the_same_in_any_encoding(tmp_path):
    curve = tmp_path / "µ-sheet.csv"
    place = np.arange(0.0, 70.0, 0.5)
    light = 6000 * (1 + 0.005 * np.cos(2 * np.pi * place / 16))
    light += np.random.default_rng(3).normal(0, 3, len(place))
    rows = np.stack([place, light], axis=1)
    np.savetxt(curve, rows, "%.4f", ",", header="position_mm,luminance_cd_m2", comments="")
    found = [
        run("judge", curve.name, "--json", encoding=encoding, cwd=tmp_path).stdout
        for encoding in ("utf-8", "cp1252", "ascii")
    ]
    texts = [
        json.loads(part.decode("utf-8" if i == 0 else "ascii")) for i, part in enumerate(found)
    ]
    assert texts[0] == texts[1] == texts[2]
    assert texts[0]["file"] == curve.name


@pytest.mark.parametrize("columns", [20, 80])
def test_help_reads_in_a_narrow_terminal(columns):
    found = run("run", "--help", columns=columns)
    assert found.returncode == 0
    assert "--effort" in found.stdout.decode()


def test_every_stand_in_is_plain():
    assert all(text.isascii() and len(sign) == 1 for sign, text in PLAIN.items())
