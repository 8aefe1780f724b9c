"""Bad input of every kind: exit code 2 and one short line that names file and field.

The cases of `corpus/` broke an earlier version each; the others are of their kinds.
"""

import io
import os
import shutil
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
from harness import BARE, extruded, film_file, row, write_facets

from mpfcad.cli import run_app

CORPUS = Path(__file__).parent / "corpus"
HEAD = 'name = "a"\n'
UNIFORM = HEAD + "[map]\ncurvature_per_mm = 60.0\n"
STACK = 'extends = "thesis-32in-mpf"\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    shutil.copytree(CORPUS, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(capsys, arguments, *words):
    """Run in this process; assert one short line with all these words, within two seconds."""
    start = time.process_time()
    code = run_app([str(a) for a in arguments])
    assert time.process_time() - start < 2.0
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("mpfcad: ")]
    assert code == 2, lines
    (line,) = lines
    assert line.isprintable() and len(line) <= 300
    for word in words:
        assert word in line, line


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("bigint.toml", ["digits"]),
        ("bigint400.toml", ["stack.override.lamp_count", "1e399", "expected below 2^64"]),
        ("emptynpz.toml", ["empty.npz", "not an NPZ file"]),
        ("hugeshape.toml", ["hugeshape.npz", "array position_mm", "shape (1000000000000000,)"]),
        ("isnpy.toml", ["isnpy.npz", "not an NPZ file"]),
        ("esc.toml", ["esc.toml: stack", "\\x1b[31mred", "no such preset"]),
        ("interp.toml", ["interp-stack.toml", "interpolation"]),
        ("kindlist.toml", ["kindlist-stack.toml", "list"]),
        ("loop.toml", ["loop-stack.toml", "extends itself"]),
        ("period-tiny.toml", ["mask.period_um: 0.001", "greater than or equal to 1"]),
        ("pitch-tiny.toml", ["film.pitch_um: 1e-09", "greater than or equal to 1"]),
        ("procdevzero.toml", ["/dev/zero", "device or pipe", "expected a process calibration"]),
    ],
)
def test_a_job_of_the_corpus(folder, capsys, file, words):
    refused(capsys, ["mask", file], *words)
    assert not (folder / "exports").exists()


@pytest.mark.parametrize(
    ("free", "memory", "words"),
    [
        (0.5, 8.0, ["1.2 GB of disk", "and 0.5 GB are free: expected at most 1"]),
        (50.0, 0.45, ["0.51 GB of memory", "0.45 and 50 GB are free: expected at most "]),
    ],
)
def test_a_picture_that_disk_or_memory_does_not_hold(
    folder, capsys, monkeypatch, free, memory, words
):
    from collections import namedtuple

    from mpfcad.pipeline.plan.printed import picture

    usage = namedtuple("usage", "free")
    monkeypatch.setattr(picture.shutil, "disk_usage", lambda _: usage(free * 1e9))
    monkeypatch.setattr(picture, "available_memory", lambda: memory)
    refused(capsys, ["mask", "tif25400.toml"], "mask.tif_dpi: 25400", "gigapixels need", *words)
    assert not (folder / "exports").exists()


@pytest.mark.parametrize("file", sorted(p.name for p in CORPUS.glob("*.npz")))
def test_an_npz_of_the_corpus(folder, capsys, file):
    (folder / "job.toml").write_text(f'{HEAD}[map]\nfile = "{file}"\n')
    refused(capsys, ["mask", "job.toml"], file)


@pytest.mark.parametrize("file", sorted(p.name for p in CORPUS.glob("*.*") if p.suffix in
                                        (".xml", ".bsdf", ".csv")))  # fmt: skip
def test_a_bsdf_of_the_corpus(folder, capsys, file):
    refused(capsys, ["bsdf", file], file)


def test_others_of_the_corpus(folder, capsys):
    refused(capsys, ["trace", "coll.stl"], "coll.stl")
    refused(capsys, ["sweep", "sweep-TypeError-2eb844.toml"], "map.file", "valid string")
    calibration = "process-OverflowError-604f91.toml"
    (folder / "job.toml").write_text(f'{UNIFORM}[process]\ncalibration = "{calibration}"\n')
    refused(capsys, ["mask", "job.toml"], calibration, "groove.pitch_um: 1e+308")


def test_a_seed_that_no_generator_takes(folder, capsys):
    refused(capsys, ["measure", "coll.stl", "--seed", str(2**64)], "--seed")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 3000, ["not TOML"]),
        ("a = " + "[" * 3000 + "]" * 3000, ["nested too deep"]),
        ("\x00", ["not TOML"]),
        (HEAD + "[map]\ncurvature_per_mm = -" + "9" * 5000, ["digits"]),
        (HEAD + "[map]\ncurvature_per_mm = 0x" + "f" * 400, ["map.curvature_per_mm", "2^64"]),
        (HEAD + "seed = 99999999999999999999999", ["seed", "2^64"]),
        (UNIFORM + "[film]\ndepth_um = 1e-9", ["film.depth_um"]),
        (UNIFORM + "[film]\npitch_um = nan", ["film.pitch_um"]),
        (UNIFORM + '[stack]\npreset = ["a"]', ["stack.preset"]),
        (UNIFORM + '[mask]\nformats = [["oas"]]', ["mask.formats"]),
        (UNIFORM + "[cad]\nextent = 'panel'\nangle_tolerance_deg = 0.01",
         ["cad.angle_tolerance_deg: 0.01", "million triangles", "expected at least"]),
        (HEAD + '[map]\nfile = "\\u0000"', ["job.toml"]),
        (HEAD + '[map]\nfile = "."', ["map.file", "is a folder"]),
        (HEAD + f'[map]\nfile = "{"x" * 5000}.csv"', ["File name too long"]),
    ],
)  # fmt: skip
def test_a_job_of_their_kind(folder, capsys, text, words):
    (folder / "job.toml").write_text(text)
    refused(capsys, ["cad", "job.toml"], "job.toml", *words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("layers = [{kind = {}}]", ["layers"]),
        ("layers = [[]]", ["layers"]),
        ('layers = ["film", {kind = "sheet", name = []}]', ["layers"]),
        ('[value]\nlamp_count = "many"', ["lamp_count"]),
        ("[value]\nlamp_count = []", ["lamp_count"]),
        ("[value]\nlamp_pitch_mm = inf", ["lamp_pitch_mm"]),
        ("[value.a]\nb = {c = 1}", ["own.toml"]),
        ("value = 3", ["value"]),
        ("extent = []", ["extent"]),
        ("extends = []", ["extends"]),
    ],
)
def test_a_stack_of_their_kind(folder, capsys, text, words):
    head = "" if text.startswith("extends") else STACK
    (folder / "own.toml").write_text(head + text)
    (folder / "job.toml").write_text(UNIFORM + '[stack]\nfile = "own.toml"\n')
    refused(capsys, ["mask", "job.toml"], "own.toml", *words)


def test_many_files_that_extend_one_another(folder, capsys):
    for i in range(1200):
        (folder / f"s{i}.toml").write_text(f'extends = "s{i + 1}.toml"\n')
    (folder / "job.toml").write_text(UNIFORM + '[stack]\nfile = "s0.toml"\n')
    refused(capsys, ["mask", "job.toml"], "extends: more than 20 files")


@pytest.mark.parametrize("suffix", ["csv", "npz"])
@pytest.mark.parametrize("kind", ["pipe", "folder", "device"])
def test_what_is_no_file(folder, capsys, kind, suffix):
    path = folder / f"m.{suffix}"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/zero")
    (folder / "job.toml").write_text(f'{HEAD}[map]\nfile = "{path.name}"\n')
    words = {"folder": "is a folder"}.get(kind, "is a device or pipe")
    refused(capsys, ["mask", "job.toml"], path.name, words)
    for command in (["trace", path.name], ["calibrate", path.name]):
        refused(capsys, command, path.name)


@pytest.mark.parametrize("suffix", ["csv", "ies", "ldt", "tm25ray", "dat", "ray"])
def test_what_a_source_names_is_a_file(folder, capsys, suffix):
    path = folder / f"m.{suffix}"
    path.symlink_to("/dev/zero")
    board = 'extends = "mini-led-4mm"\n[source]\nkind = "leds"\n'
    for line in (
        f'lattice = "list"\nemission = "cosine"\npositions = "{path.name}"\n',
        f'lattice = "square"\nemission = "{path.name}"\n',
    ):
        (folder / "board.toml").write_text(board + line)
        (folder / "job.toml").write_text(UNIFORM + '[stack]\nfile = "board.toml"\n')
        refused(capsys, ["mask", "job.toml"], "board.toml", path.name, "is a device or pipe")


def test_what_options_name_is_a_file(folder, capsys):
    os.mkfifo(folder / "pipe.csv")
    refused(capsys, ["calibrate", "--coupons", "pipe.csv"], "pipe.csv", "is a device or pipe")
    for option in ("--dark", "--flat"):
        command = ["judge", "pipe.csv", "--pixel-mm", "0.1", option, "pipe.csv"]
        refused(capsys, command, "pipe.csv")


def _npz(path, **entries):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in entries.items():
            archive.writestr(f"{name}.npy", data)


def _npy(array, **change):
    file = io.BytesIO()
    np.save(file, array)
    data = file.getvalue()
    for old, new in change.items():
        data = data.replace(old.encode(), new.encode().ljust(len(old)))
    return data


@pytest.mark.parametrize(
    ("position", "words"),
    [
        (_npy(np.array(["a"])), ["array position_mm", "expected numbers"]),
        (_npy(np.array([1 + 1j])), ["array position_mm", "expected numbers"]),
        (_npy(np.zeros((2, 2))), ["array position_mm"]),
        (_npy(np.zeros(0)), ["m.npz"]),
        (_npy(np.array(1.0)), ["array position_mm"]),
        (_npy(np.zeros(3))[:40], ["array position_mm"]),
        (b"", ["array position_mm"]),
        (b"\x93NUMPY\x09\x09" + bytes(100), ["NPY version"]),
        (_npy(np.full(2, np.nan)), ["position_mm"]),
        (_npy(np.zeros(2)).replace(b"(2,)", b"-2, "), ["array position_mm"]),
    ],
)
def test_an_npz_of_their_kind(folder, capsys, position, words):
    _npz(folder / "m.npz", position_mm=position, curvature_per_mm=_npy(np.full(2, 60.0)))
    (folder / "job.toml").write_text(f'{HEAD}[map]\nfile = "m.npz"\n')
    refused(capsys, ["mask", "job.toml"], "m.npz", *words)


def test_an_npz_that_grows_a_thousandfold_is_not_unpacked(folder, capsys):
    with zipfile.ZipFile(folder / "m.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("position_mm", "curvature_per_mm"):
            with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                head = _npy(np.zeros(0)).replace(b"(0,)", b"(9,)")
                file.write(head)
                for _ in range(40):
                    file.write(bytes(1_000_000))
    assert (folder / "m.npz").stat().st_size < 200_000
    (folder / "job.toml").write_text(f'{HEAD}[map]\nfile = "m.npz"\n')
    refused(capsys, ["mask", "job.toml"], "m.npz")


def test_prisms_that_no_light_sees_or_that_are_not_there_are_refused(folder, capsys):
    film_file(folder / "film.stl", [BARE])
    (folder / "resin.toml").write_text(STACK + "[value]\nresin_index = 1.49\n")
    asked = ["trace", "film.stl", "--prism", "film.stl", "--stack"]
    refused(capsys, [*asked, "thesis-32in-mpf"], "--prism: film.stl", "resin that scatters")
    asked[3] = "none.stl"
    refused(capsys, [*asked, "resin.toml"], "--prism: none.stl: no such file")


def test_a_wrong_stack_leaves_no_repaired_mesh(folder, capsys):
    facets = extruded(*row([BARE], 0.15), 0.1)
    write_facets(folder / "film.stl", facets[:-1])
    before = sorted(p.name for p in folder.iterdir())
    refused(capsys, ["trace", "film.stl", "--repair", "--stack", "none.toml"], "none.toml")
    assert sorted(p.name for p in folder.iterdir()) == before


def test_a_covariance_of_no_input_is_refused_before_anything_is_traced(folder, capsys):
    Path("c.csv").write_text("top_sigma\n1e-4\n")
    Path("a.toml").write_text(UNIFORM + '[confidence]\ncovariance = "c.csv"\n')
    refused(capsys, ["run", "a.toml"], "a.toml: confidence.covariance: top_sigma: expected inputs",
            "resin_percent, resin_tone_percent, registration_mm")  # fmt: skip
    assert not (folder / "exports").exists()
