"""A sweep takes kept points of the same backlight, code and settings, and no damaged ones."""

import json
import shutil

import pytest
from few_paths import few_paths

from mpfcad.job.sweep import read_sweep
from mpfcad.pipeline import run_sweep
from mpfcad.pipeline.point.trace import build_point
from mpfcad.store import Store

SWEEP = """
name = "few"
[axis]
"map.curvature_per_mm" = [50.0, 60.0]
[trace]
half_width = 0.0
paths_million = 0.02
[stack]
file = "own.toml"
"""
STACK = """
extends = "thesis-32in-mpf"
layers = ["clear_plate", "bottom_sheet", "film", "top_sheet"]
[value]
thickness_mm = 18.0
"""


class Told:
    """Progress that remembers."""

    def __init__(self):
        self.stages, self.notes = [], []
        self.stage, self.note = self.stages.append, self.notes.append

    def trace(self, state):
        """Forget it."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    (tmp_path / "sweep.toml").write_text(SWEEP)
    (tmp_path / "own.toml").write_text(STACK)
    return tmp_path


@pytest.fixture(scope="module")
def first(tmp_path_factory):
    """Give a folder whose sweep was run once: its kept points, what it told and its dataset."""
    folder = tmp_path_factory.mktemp("swept")
    (folder / "sweep.toml").write_text(SWEEP)
    (folder / "own.toml").write_text(STACK)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MPFCAD_CACHE", str(folder / "cache"))
        return folder, *swept(folder)


@pytest.fixture
def done(first, folder):
    """Give the folder with what `first` has kept and made, and its dataset."""
    shutil.copytree(first[0] / "cache", folder / "cache")
    shutil.copytree(first[0] / "out", folder / "out")
    return folder, first[2]


def swept(folder, out="out"):
    """Return what a sweep tells, and the bytes of its dataset."""
    told, file = Told(), folder / "sweep.toml"
    with few_paths():
        run_sweep(read_sweep(file), file, folder / out, workers=1, progress=told)
    return told, (folder / out / "sweep.nc").read_bytes()


def keys(folder):
    file = folder / "sweep.toml"
    sweep = read_sweep(file)
    return [build_point(sweep, file, place).key() for place in sweep.points()]


def test_a_kept_point_is_not_traced_again(first, done):
    folder, data = done
    assert first[1].stages[0] == "0 of 2 points are there"
    told, again = swept(folder, "again")
    assert told.stages[0] == "2 of 2 points are there" and again == data
    # More points keep those that are there.
    (folder / "sweep.toml").write_text(SWEEP.replace("60.0]", "60.0, 55.0]"))
    assert swept(folder, "more")[0].stages[0] == "2 of 3 points are there"


@pytest.mark.parametrize(
    ("file", "change"),
    [
        ("own.toml", ('"bottom_sheet", "film", "top_sheet"', '"film"')),
        ("own.toml", ('"film", "top_sheet"', '"top_sheet", "film"')),
        ("own.toml", ("= 18.0", "= 18.5")),
        ("own.toml", ("[value]", 'extent = "panel"\n[value]')),
        ("own.toml", ("[value]", "[value]\nmeter_spot_mm = 0.7")),
        ("own.toml", ('"film"', '{kind = "sheet", name = "extra", sigma = 0.2}, "film"')),
        ("sweep.toml", ('name = "few"', 'name = "few"\nseed = 2')),
        ("sweep.toml", ("paths_million = 0.02", "paths_million = 0.04")),
        ("sweep.toml", ("half_width = 0.0", "half_width = 0.9")),
        ("sweep.toml", ("[trace]", "[film]\npitch_um = 60.0\ndepth_um = 30.0\n[trace]")),
        ("sweep.toml", ("[trace]", "[film]\nrefractive_index = 1.51\n[trace]")),
        ("sweep.toml", ("[trace]", "[cad]\nangle_tolerance_deg = 0.3\n[trace]")),
    ],
)  # fmt: skip
def test_another_backlight_film_or_setting_has_other_keys(folder, file, change):
    before = keys(folder)
    text = (folder / file).read_text()
    assert change[0] in text
    (folder / file).write_text(text.replace(*change))
    assert not set(keys(folder)) & set(before)


def test_where_the_files_lie_makes_no_difference(folder, tmp_path):
    before = keys(folder)
    other = folder / "elsewhere"
    other.mkdir()
    for name in ("sweep.toml", "own.toml"):
        (folder / name).rename(other / name)
    assert keys(other) == before


def test_edited_layers_are_traced_anew(done):
    folder, full = done
    (folder / "own.toml").write_text(STACK.replace('"bottom_sheet", "film", "top_sheet"', '"film"'))
    told, bare = swept(folder)
    assert told.stages[0] == "0 of 2 points are there"
    bare_contrast, full_contrast = (_contrast(data, folder) for data in (bare, full))
    # Without its sheets the film hides the lamps far less: 0.378 for 0.018 at full length.
    assert bare_contrast > 3 * full_contrast


def _contrast(data, folder):
    import xarray

    path = folder / "one.nc"
    path.write_bytes(data)
    return float(xarray.load_dataset(path, engine="scipy").lamp_mura_contrast.max())


def test_other_code_takes_no_old_points(folder, monkeypatch):
    before = keys(folder)
    monkeypatch.setattr("mpfcad.store.digest.work_hash", lambda kind: "0" * 64)
    assert not set(keys(folder)) & set(before)


@pytest.mark.parametrize("how", ["flip a digit", "empty", "cut", "NULs", "no JSON"])
def test_a_damaged_point_is_said_and_traced_again(done, how):
    folder, whole = done
    path = Store(folder / "cache").path("point", keys(folder)[0])
    content = bytearray(path.read_bytes())
    at = content.index(b'"mean_luminance_cd_m2"') + 40
    if how == "flip a digit":
        content[at] ^= 1
    elif how == "no JSON":
        content[at] = ord("{")
    elif how == "NULs":
        content[at : at + 8] = bytes(8)
    path.write_bytes(b"" if how == "empty" else content[:at] if how == "cut" else content)
    told, again = swept(folder)
    assert again == whole
    assert told.stages[0] == "1 of 2 points are there"
    (note,) = told.notes
    assert str(path) in note and "computed again" in note


def test_what_is_kept_is_what_is_reported(done):
    folder, _ = done
    record = json.loads((folder / "out" / "sweep.json").read_bytes())
    kept = [Store(folder / "cache").read_json("point", key) for key in keys(folder)]
    assert record["points"] == kept
