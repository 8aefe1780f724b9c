"""What a run needs is said by --plan, and refused where the memory is not there."""

import pytest

from mpfcad.cli import run_app
from mpfcad.job import read_job
from mpfcad.pipeline import read_plan, run_need
from mpfcad.pipeline.plan import need

JOB = 'name = "a"\n[map]\ncurvature_per_mm = 60.0\n[cad]\nextent = "{extent}"\n'


@pytest.fixture
def job(tmp_path):
    def written(extent):
        path = tmp_path / "job.toml"
        path.write_text(JOB.format(extent=extent))
        return path

    return written


def test_what_is_needed_grows_with_the_piece_and_not_with_the_paths(job):
    found = {
        (extent, effort): run_need(read_plan(read_job(job(extent)), job(extent)), effort)
        for extent in ("pitch", "panel")
        for effort in ("quick", "final")
    }
    piece, panel = found["pitch", "quick"], found["panel", "quick"]
    assert panel.grooves > 10 * piece.grooves and panel.memory_gb > piece.memory_gb
    assert found["panel", "final"].memory_gb == panel.memory_gb < 4
    assert found["panel", "final"].paths == 100 * panel.paths
    assert piece.trace_minutes(2.0) == piece.trace_minutes(1.0) / 2


def test_more_memory_than_there_is_is_refused_before_work(job, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(need, "available_memory", lambda: 1.5)
    out = tmp_path / "out"
    assert run_app(["run", str(job("panel")), "--out", str(out)]) == 2
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert "job.toml: cad.extent: 7846 grooves need" in line and "expected at most 1.5 GB" in line
    assert not out.exists() and len(line) <= 300


def test_a_plan_says_memory_and_time_and_makes_nothing(job, tmp_path, monkeypatch, capsys):
    from mpfcad.pipeline import speed

    monkeypatch.setattr(speed, "trace_speed", lambda: (0.0, 2.0))
    out = tmp_path / "out"
    assert (
        run_app(["run", str(job("pitch")), "--plan", "--effort", "quick", "--out", str(out)]) == 0
    )
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["film", "memory", "CAD", "traces"]
    assert "8 million paths (quick): 0.1 min at 2.00 million a second" in lines[3]
    assert not out.exists()


def test_a_plan_refuses_the_format_that_a_run_refuses(job, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("mpfcad.mask.format.write.LARGEST_FILE", 1000)
    path, out = job("pitch"), tmp_path / "out"
    path.write_text(path.read_text() + '[mask]\nformats = ["gds"]\n')
    said = []
    for options in (["--plan"], []):
        assert run_app(["run", str(path), *options, "--out", str(out)]) == 2
        said += [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert len(said) == 2 and said[0] == said[1]
    assert "job.toml: mask.formats: gds lists apertures one by one" in said[0]
    assert not out.exists()
