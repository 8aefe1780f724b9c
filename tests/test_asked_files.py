"""A file that the user asks for: refused before work where it cannot be; replaces its own kind."""

import pytest

from mpfcad.boundary.out import asked_file, check_out
from mpfcad.cli import run_app
from mpfcad.errors import InputError

JOB = 'name = "a"\n[map]\ncurvature_per_mm = 60.0\n'


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.txt").write_text("notes")
    (tmp_path / "job.toml").write_text(JOB)
    rows = "".join(f"{x / 10},{1000 + x % 3}\n" for x in range(400))
    (tmp_path / "m.csv").write_text("position_mm,luminance\n" + rows)
    trace = "".join(f"{x},{abs(x % 50 - 25)}\n" for x in range(500))
    (tmp_path / "trace.csv").write_text("x_um,z_um\n" + trace)
    return tmp_path


def refused(capsys, *arguments):
    assert run_app([*map(str, arguments)]) == 2
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert len(line) <= 300
    return line


CALIBRATE = ("calibrate", "trace.csv", "--aperture", "0.3")


@pytest.mark.parametrize(
    "command",
    [
        ("mask", "job.toml", "--out", "notes.txt/x"),
        ("mask", "job.toml", "--out", "notes.txt/deep/x"),
        ("cad", "job.toml", "--out", "notes.txt/x"),
        ("run", "job.toml", "--out", "notes.txt/x"),
        ("run", "job.toml", "--junit", "notes.txt/x.xml"),
        ("rays", "thesis-32in-mpf", "--out", "notes.txt/x.dat"),
        ("judge", "m.csv", "--out", "notes.txt/x.json"),
        ("judge", "m.csv", "--page", "notes.txt/x.html"),
        (*CALIBRATE, "--out", "notes.txt/x.toml"),
    ],
    ids=" ".join,
)
def test_a_path_through_a_file_names_the_file_before_work(place, capsys, command):
    before = sorted(place.iterdir())
    line = refused(capsys, *command)
    assert "notes.txt is a file: expected a folder" in line and "notes.txt/" in line
    assert sorted(place.iterdir()) == before


@pytest.mark.parametrize(
    ("command", "file"),
    [
        (("judge", "m.csv", "--out", "m.csv"), "m.csv"),
        (("judge", "m.csv", "--page", "notes.txt"), "notes.txt"),
        (("run", "job.toml", "--junit", "job.toml"), "job.toml"),
        ((*CALIBRATE, "--out", "job.toml"), "job.toml"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else value,
)
def test_a_file_of_another_kind_is_not_replaced(place, capsys, command, file):
    before = (place / file).read_bytes()
    assert f"{file}: exists and is no such file" in refused(capsys, *command)
    assert (place / file).read_bytes() == before


@pytest.mark.parametrize("suffix", [".tm25ray", ".dat", ".ray"])
def test_a_ray_file_replaces_ray_files_alone(place, capsys, suffix):
    path = place / f"light{suffix}"
    path.write_bytes(b"a table of somebody's")
    ask = ("rays", "thesis-32in-conventional", "--rays", "200", "--out", path, "--threads", "1")
    assert "exists and is no such file" in refused(capsys, *ask)
    assert path.read_bytes() == b"a table of somebody's"
    path.unlink()
    assert run_app([*map(str, ask)]) == 0
    first = path.read_bytes()
    assert run_app([*map(str, ask), "--seed", "2"]) == 0
    assert path.read_bytes() != first
    assert "the lamps emit" in capsys.readouterr().out


def test_the_light_sources_own_file_is_not_replaced(place):
    from mpfcad.backlight import read_stack
    from mpfcad.pipeline import write_rays
    from mpfcad.pipeline.measure.case import mesh_case

    ask = ["--rays", "5000", "--threads", "1", "--out", "lamp.ray"]
    assert run_app(["rays", "thesis-32in-conventional", *ask]) == 0
    before = (place / "lamp.ray").read_bytes()
    (place / "board.toml").write_text(
        'extends = "mini-led-4mm"\nlayers = ["clear_plate", "top_sheet"]\n'
        '[source]\nkind = "leds"\nlattice = "square"\nemission = "lamp.ray"\n'
    )
    case = mesh_case(None, read_stack("board.toml"), 0.0)
    with pytest.raises(InputError, match="is the light source's own file"):
        write_rays(case, place / "lamp.ray", "screen", 10, threads=1)
    assert (place / "lamp.ray").read_bytes() == before


def test_bsdf_files_replace_none_of_another_kind(place, capsys):
    table = "theta_in_deg,theta_out_deg,phi_out_deg,btdf\n"
    (place / "mine.csv").write_text("what I measured\n" + table)
    with pytest.raises(InputError, match=r"mine\.csv: exists and is no such file"):
        from mpfcad.optics.bsdf.file import write_texts

        write_texts(place, {"other.csv": "# basis: klems\n", "mine.csv": "# basis: klems\n"})
    assert not (place / "other.csv").exists()


def test_a_file_is_whole_or_not_there(place):
    with pytest.raises(ZeroDivisionError), asked_file(place / "deep" / "a.json") as part:
        part.write_text("half")
        raise ZeroDivisionError
    assert list((place / "deep").iterdir()) == []
    (place / "a.json").write_text("{\n}")
    check_out("--out", place / "a.json", (b"{\n",))
    with asked_file(place / "a.json") as part:
        part.write_text("whole")
    assert (place / "a.json").read_text() == "whole"
