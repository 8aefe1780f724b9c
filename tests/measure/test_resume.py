"""An interrupted trace goes on where it was, and ends with the bits of one never interrupted."""

import numpy as np
import pytest
from few_paths import few_paths
from harness import film_file, groove

from mpfcad.backlight import read_stack
from mpfcad.errors import ExportError
from mpfcad.measure import Checkpoints, TraceRun, light_film, luminance_over_pitch
from mpfcad.store import Store

GOAL, LIMIT = 1e-9, 100_000


@pytest.fixture(autouse=True, scope="module")
def _few_paths():
    """Have rounds of two blocks of 33 · 512 paths: three in a whole trace."""
    with few_paths():
        yield


@pytest.fixture(scope="module")
def lit(tmp_path_factory):
    mesh = film_file(tmp_path_factory.mktemp("film") / "film.stl", [groove(60.0)] * 20, base=0.2)
    return light_film(read_stack("thesis-32in-mpf"), mesh)


def traced(lit, folder, progress=None, **run):
    with Checkpoints(Store(folder)) as checkpoints:
        setting = TraceRun(**{"seed": 5, "path_limit": LIMIT, **run}, checkpoints=checkpoints,
                           progress=progress)  # fmt: skip
        return luminance_over_pitch(lit, setting, half_width_goal=GOAL)


@pytest.fixture(scope="module")
def whole(lit):
    return traced(lit, None)


def interrupt_after(paths):
    def watch(state):
        if state.paths > paths:
            raise KeyboardInterrupt

    return watch


def leave_half(lit, folder, **run):
    """Interrupt a trace of three rounds in its third one."""
    with pytest.raises(KeyboardInterrupt):
        traced(lit, folder, interrupt_after(80_000), **run)
    return entries(folder)


def entries(folder):
    return sorted(path for path in folder.rglob("*") if path.is_file())


def test_a_resumed_trace_has_the_bits_of_an_uninterrupted_one(tmp_path, lit, whole):
    (left,) = leave_half(lit, tmp_path)
    assert left == Store(tmp_path).path("trace", left.stem)
    seen = []
    resumed = traced(lit, tmp_path, seen.append, threads=2)
    # It went on after two rounds …
    assert seen[0].start == 2 * 2 * 33 * 512 and seen[0].paths > seen[0].start
    # … to the same bits, and nothing is left.
    assert np.array_equal(resumed.luminance, whole.luminance)
    assert np.array_equal(resumed.standard_error, whole.standard_error)
    assert (resumed.contrast, resumed.paths) == (whole.contrast, whole.paths)
    # What the rounds before the interruption gave is still known.
    assert len(whole.convergence) > 2 and np.array_equal(resumed.convergence, whole.convergence)
    assert not entries(tmp_path)


def test_a_finished_trace_waits_for_the_rest_of_the_work(tmp_path, lit, whole):
    with pytest.raises(KeyboardInterrupt), Checkpoints(Store(tmp_path)) as checkpoints:
        run = TraceRun(5, path_limit=LIMIT, checkpoints=checkpoints)
        luminance_over_pitch(lit, run, half_width_goal=GOAL)
        raise KeyboardInterrupt
    seen = []
    again = traced(lit, tmp_path, seen.append)
    assert [state.paths for state in seen] == [whole.paths]
    assert np.array_equal(again.luminance, whole.luminance)


@pytest.mark.parametrize("other", [{"seed": 6}, {"path_limit": 90_000}])
def test_another_trace_does_not_take_it(tmp_path, lit, other):
    (left,) = leave_half(lit, tmp_path)
    seen = []
    traced(lit, tmp_path, seen.append, **other)
    assert seen[0].start == 0
    assert entries(tmp_path) == [left]


def test_another_film_or_backlight_does_not_take_it(tmp_path, lit):
    other = film_file(tmp_path / "other.stl", [groove(61.0)] * 20, base=0.2)
    slim = read_stack("thesis-32in-mpf", thickness=19.0)
    cases = [lit.case, light_film(lit.stack, other).case, light_film(slim, other).case]
    cases.append(light_film(lit.stack, other, offset=0.01).case)
    assert len({str(case) for case in cases}) == 4


def test_a_damaged_checkpoint_is_said_and_traced_again(tmp_path, lit, whole, capsys):
    (left,) = leave_half(lit, tmp_path)
    content = bytearray(left.read_bytes())
    content[len(content) // 2] ^= 1
    left.write_bytes(content)
    seen = []
    again = traced(lit, tmp_path, seen.append)
    assert seen[0].start == 0 and np.array_equal(again.luminance, whole.luminance)
    (line,) = capsys.readouterr().err.splitlines()
    assert str(left) in line and "does not verify" in line and "computed again" in line
    assert entries(tmp_path) == [left.with_suffix(".damaged")]


def test_a_full_disk_at_the_report_loses_no_trace(tmp_path, monkeypatch):
    """What was traced stays until the export has its name."""
    from mpfcad.job import build_job
    from mpfcad.pipeline import run_job

    stack = 'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 40.0\npanel_length_mm = 50.0\n'
    (tmp_path / "s.toml").write_text(stack + "lamp_count = 5\nlamp_pitch_mm = 8.0\n")
    document = {
        "name": "a", "map": {"curvature_per_mm": 60.0}, "stack": {"file": "s.toml"},
        "mask": {"formats": ["oas"]},
    }  # fmt: skip
    job, file = build_job(document, "job.toml"), tmp_path / "job.toml"
    file.write_text("")
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))

    class Seen:
        def __init__(self):
            self.starts = []

        def stage(self, text):
            """Forget it."""

        note = stage

        def trace(self, state):
            self.starts.append(state.start)

    def run(seen):
        return run_job(job, file, tmp_path / "out", effort="quick", progress=seen)

    def full(*arguments, **options):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("mpfcad.report.write_report", full)
        with pytest.raises(ExportError, match="/out: cannot be written: No space"):
            run(Seen())
    assert not (tmp_path / "out").exists()
    assert len(entries(tmp_path / "cache" / "trace")) >= 2
    with monkeypatch.context() as patch:
        patch.setattr("mpfcad.export.folder._publish", full)
        with pytest.raises(ExportError, match="/out: cannot be written: No space"):
            run(Seen())
    seen = Seen()
    run(seen)
    assert seen.starts and min(seen.starts) > 0, "a trace began anew"
    assert (tmp_path / "out" / "report.html").is_file()
    assert entries(tmp_path / "cache" / "trace") == []
