"""The command line from outside: exit codes, one line an error, and a --help that is instant."""

import resource
import subprocess
import sys

import pytest
from command import called, mpfcad

from mpfcad.cli import run_app

HEAVY = (
    "numpy", "scipy", "numba", "pydantic", "plotly", "build123d", "OCP", "trimesh", "klayout",
    "gdstk", "manifold3d", "shapely", "rich",
)  # fmt: skip


def fails(result, code, *words):
    """Assert exit code and one line on stderr, besides lines of progress, with all `words`."""
    assert result.returncode == code, result.stderr
    lines = [line for line in result.stderr.splitlines() if line.startswith("mpfcad: ")]
    assert len(lines) == 1, result.stderr
    for word in words:
        assert word in lines[0]


def test_help_imports_nothing_heavy():
    code = (
        "import sys\nfrom mpfcad.cli import run_app\nassert run_app(['--help']) == 0\n"
        f"print(sorted(set({HEAVY!r}) & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert result.stdout.splitlines()[-1] == "[]", result.stdout + result.stderr


def test_help_is_instant():
    """Median of five under 0.3 CPU seconds beyond what the interpreter itself needs."""

    def median(code):
        used = []
        for _ in range(5):
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            used.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        return sorted(used)[2]

    own = median("import sys; sys.argv[1:] = ['--help']; from mpfcad.cli import main; main()")
    assert own - median("pass") < 0.3


@pytest.mark.parametrize(
    "command",
    [
        "run",
        "mask",
        "cad",
        "mould",
        "trace",
        "bsdf",
        "measure",
        "verify",
        "design",
        "sweep",
        "cache",
        "calibrate",
        "stacks",
        "init",
        "view",
        "doctor",
        "compare",
        "--help",
    ],
)
def test_every_subcommand_has_help(command):
    result = called(command, "--help")
    assert result.returncode == 0
    assert "Usage: mpfcad" in result.stdout


def test_every_subcommand_stands_in_a_group_with_an_example_that_parses():
    import shlex

    import typer

    from mpfcad.cli.app import app
    from mpfcad.cli.group import EXAMPLES

    group = typer.main.get_command(app)
    assert set(EXAMPLES) == set(group.commands)
    for name, example in EXAMPLES.items():
        program, command, *arguments = shlex.split(example)
        assert (program, command) == ("mpfcad", name)
        group.commands[name].make_context(name, arguments)
        assert example in called(name, "--help").stdout


def test_doctor_says_what_is_here():
    import json

    found = json.loads(mpfcad("doctor", "--json", "--no-speed").stdout)
    assert found["libraries"]["numpy"]
    assert int(found["cores"].split()[0]) >= 1
    assert "kernels" in found


def test_version():
    from mpfcad import __version__

    assert mpfcad("--version").stdout == f"mpfcad {__version__}\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bogus"], "--bogus"),
        (["bogus"], "bogus"),
        (["run"], "JOB.toml"),
        (["run", "job.toml", "--effort", "slow"], "--effort"),
        (["run", "job.toml", "--threads", "0"], "--threads"),
        (["mask", "job.toml", "--format", "oas,pdf"], "--format: pdf: expected some of oas, gds"),
        (["cad", "job.toml", "--format", ","], "--format: ','"),
        (["run", "nothing.toml"], "nothing.toml: no such file"),
        (["trace", "nothing.stl"], "nothing.stl: no such file"),
        (["verify", "nothing"], "nothing: no such folder"),
    ],
)
def test_bad_usage_is_one_line_and_exit_2(tmp_path, arguments, words):
    fails(called(*arguments, cwd=tmp_path), 2, words)
    assert not list(tmp_path.iterdir())


def test_init_writes_a_job_once(tmp_path):
    assert called("init", "my.toml", cwd=tmp_path).returncode == 0
    written = (tmp_path / "my.toml").read_text()
    fails(called("init", "my.toml", cwd=tmp_path), 2, "my.toml: exists")
    assert (tmp_path / "my.toml").read_text() == written


def test_a_job_that_init_writes_has_its_file_s_name(tmp_path):
    result = called("init", "wave-2.toml", cwd=tmp_path)
    assert 'name = "wave-2" ' in (tmp_path / "wave-2.toml").read_text("utf-8")
    assert "exports/wave-2" in result.stdout
    fails(called("init", "our film.toml", cwd=tmp_path), 2, "our film.toml: name: our film")
    assert [path.name for path in tmp_path.iterdir()] == ["wave-2.toml"]


@pytest.mark.parametrize("columns", [20, 40, 50, 80])
def test_help_keeps_to_the_terminal(columns, monkeypatch):
    """Only a word alone may be wider: it is there to be copied."""
    import typer

    from mpfcad.cli.app import app

    monkeypatch.setenv("COLUMNS", str(columns))
    group = typer.main.get_command(app)
    for name in ("", *group.commands):
        command = group.commands[name] if name else group
        text = command.get_help(command.context_class(command, info_name=f"mpfcad {name}"))
        wide = [line for line in text.splitlines() if len(line) > columns and " " in line.strip()]
        assert wide == []


@pytest.mark.parametrize(
    ("map_table", "words"),
    [
        ("curvature_per_mm = 90.0", "map.curvature_per_mm: 90: not printable"),
        ("curvature_per_mm = 0.06", "1/µm"),
        ('file = "gone.csv"', "gone.csv: no such file"),
        ('file = "bad.csv"', "bad.csv: row 3: "),
    ],
)
def test_bad_map_is_one_line_exit_2_and_nothing_is_written(tmp_path, map_table, words):
    (tmp_path / "job.toml").write_text(f'name = "bad"\n[map]\n{map_table}\n')
    (tmp_path / "bad.csv").write_text("position_mm,curvature_per_mm\n0,60\n1,nan\n32.69,60\n")
    before = sorted(path.name for path in tmp_path.iterdir())
    fails(called("run", "job.toml", cwd=tmp_path), 2, words)
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_traceback_only_when_asked(tmp_path):
    assert "Traceback" not in mpfcad("run", "nothing.toml", cwd=tmp_path).stderr
    assert "Traceback" in mpfcad("--debug", "run", "nothing.toml", cwd=tmp_path).stderr


def test_any_other_error_is_one_line_and_exit_3(monkeypatch, capsys):
    import mpfcad.job
    from mpfcad.cli import run_app
    from mpfcad.errors import ExportError, TraceError

    for kind, code, prefix in ((TraceError, 3, "TraceError: "), (ExportError, 1, "")):

        def broken(_, kind=kind):
            raise kind("film.stl: two\nlines")

        monkeypatch.setattr(mpfcad.job, "read_job", broken)
        assert run_app(["run", "job.toml"]) == code
        assert capsys.readouterr().err == f"mpfcad: {prefix}film.stl: two lines\n"


@pytest.mark.parametrize("long", ["a" * 3000, "a/" * 3000 + "b", "a" * 3000 + ".toml"])
@pytest.mark.parametrize(
    "command",
    [
        ("run", "{}"), ("mask", "{}"), ("cad", "{}"), ("trace", "{}"), ("measure", "{}"),
        ("rays", "{}", "--out", "a.ray"), ("compare", "{}"), ("verify", "{}"), ("judge", "{}"),
        ("calibrate", "{}"), ("bsdf", "{}"), ("sweep", "{}"), ("design", "{}"), ("fit", "{}"),
        ("mask", "job.toml", "--out", "{}"), ("rays", "thesis-32in-mpf", "--out", "{}.ray"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_a_path_too_long_is_one_line(tmp_path, monkeypatch, capsys, command, long):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "job.toml").write_text('name = "a"\n[map]\ncurvature_per_mm = 60.0\n')
    assert run_app([part.format(long) for part in command]) == 2
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert len(line) <= 300 and "aaa" in line.replace("/", "")
    assert [path.name for path in tmp_path.iterdir()] == ["job.toml"]
