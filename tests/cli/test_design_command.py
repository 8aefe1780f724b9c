"""`mpfcad design` and `mpfcad sweep` through the command line: files, resuming, refusals."""

import json
import os
import signal
import subprocess
import sys
import time
import tomllib

import numpy as np
import psutil
import pytest
from command import called, content, mpfcad, refused
from few_paths import few_paths

DESIGN = """
schema = 1
name = "slim"
[goal]
contrast_target = 0.000001
[constraint]
curvature_min_per_mm = 55.0
curvature_max_per_mm = 62.0
change_max_per_mm2 = 1.5
harmonics = 2
[search]
iterations = 2
paths_million = 0.05
[stack]
thickness_mm = 18.0
[film]
profile = "{profile}"
[mask]
period_um = 640.0
"""
SWEEP = """
schema = 1
name = "few"
contrast_limit = 0.2
[axis]
"map.curvature_per_mm" = [50.0, 60.0]
shift_mm = [0.0, 0.5]
[trace]
half_width = 0.0
paths_million = 0.02
"""


@pytest.mark.slow
def test_a_design_is_found_and_resumes_to_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    (tmp_path / "design.toml").write_text(DESIGN.format(profile="filled"))
    arguments = ("design", "design.toml", "--no-verify")
    result = mpfcad(*arguments, "--threads", "1", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    out = tmp_path / "exports" / "slim-design"
    whole = content(out)
    names = {"slim.toml", "slim.csv", "design.json", "design.html", "manifest.json"}
    assert set(whole) == names
    record = json.loads(whole["design.json"])
    assert len(record["iterations"]) == 2
    job = tomllib.loads(whole["slim.toml"].decode())
    assert job["map"]["file"] == "slim.csv"
    position, curvature = np.loadtxt(out / "slim.csv", delimiter=",", skiprows=1).T
    assert (curvature >= 55).all() and (curvature <= 62).all()
    # Positions are rounded to 1e-6 mm of rows 0.25 mm apart.
    assert np.abs(np.diff(curvature) / np.diff(position)).max() <= 1.5 * (1 + 1e-5)
    assert curvature == pytest.approx(curvature[::-1])

    # As if it had been killed in the second trace.
    traces = sorted((tmp_path / "cache" / "design").iterdir(), key=lambda p: p.stat().st_ctime_ns)
    for later in traces[1:]:
        later.unlink()
    result = mpfcad(*arguments, "--threads", "2", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "tracing iteration 2" in result.stderr and "tracing iteration 1" not in result.stderr
    assert content(out) == whole


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("iterations = 2", "iterations = 0"), ["search.iterations: 0", "greater than or equal"]),
        (("harmonics = 2", "harmonix = 2"), ["constraint.harmonix", "known: curvature_min"]),
        (("= 62.0", "= 40.0"), ["constraint.curvature_max_per_mm: 40", "above the smallest"]),
        (("= 18.0", "= 1.0"), ["thickness_mm: 1"]),
        (("[goal]", '[goal]\naim = "trade"'), ["goal", "luminance_weight"]),
        (
            (
                DESIGN[DESIGN.index("contrast_target") : DESIGN.index("iterations")],
                'aim = "confidence"\n[search]\nmethod = "thesis"\n',
            ),
            ['goal.aim = "confidence"', 'expected search.method = "response"'],
        ),
        (
            ("[goal]", 'thickness = { min_mm = 10, max_mm = 12 }\n[goal]\naim = "confidence"'),
            ['goal.aim = "confidence"', "expected one thickness"],
        ),
    ],
)
def test_what_is_wrong_with_a_design_is_said_in_one_line(tmp_path, change, words):
    (tmp_path / "design.toml").write_text(DESIGN.format(profile="filled").replace(*change))
    result = called("design", "design.toml", cwd=tmp_path)
    refused(result, "design.toml", *words)
    assert not (tmp_path / "exports").exists()


def test_a_sweep_resumes_and_is_a_labelled_dataset(tmp_path, monkeypatch):
    import xarray

    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    (tmp_path / "sweep.toml").write_text(SWEEP)
    with few_paths():
        result = called("sweep", "sweep.toml", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    out, points = tmp_path / "exports" / "few-sweep", tmp_path / "cache" / "point"
    whole = content(out)
    assert len(list(points.iterdir())) == 4
    data = xarray.open_dataset(out / "sweep.nc", engine="scipy")
    assert data.sizes == {"map_curvature_per_mm": 2, "shift_mm": 2, "position_pitch": 33}
    assert data.sel(shift_mm=0.5).local_shift.values == pytest.approx(0.5)
    low, value, high = (data[f"lamp_mura_contrast{end}"].values for end in ("_low", "", "_high"))
    assert ((low <= value) & (value <= high)).all()

    next(points.iterdir()).unlink()
    with few_paths():
        result = called("sweep", "sweep.toml", "--workers", "1", cwd=tmp_path)
    assert "3 of 4 points are there" in result.stderr
    assert content(out) == whole


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("shift_mm", "shift_um"), ["shift_um", "expected table.field"]),
        (("[50.0, 60.0]", "[50.0, 90.0]"), ["90", "not printable", "map.curvature_per_mm = 90"]),
        (("[50.0, 60.0]", "[50.0, 50.0]"), ["none twice"]),
        (
            (
                '"map.curvature_per_mm" = [50.0, 60.0]\nshift_mm = [0.0, 0.5]',
                '"stack.thickness_mm" = [16.0]\n[design.goal]\naim = "confidence"',
            ),
            ["expected another aim in a sweep"],
        ),
        (("shift_mm = [0.0, 0.5]", '"film.profile" = ["filed"]'), ["film.profile: filed"]),
    ],
)
def test_what_is_wrong_with_a_sweep_is_said_before_it_starts(tmp_path, change, words):
    (tmp_path / "sweep.toml").write_text(SWEEP.replace(*change))
    result = called("sweep", "sweep.toml", cwd=tmp_path)
    refused(result, *words)
    assert not (tmp_path / "exports").exists()


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Return a folder with a sweep, and the bytes that one process makes of it."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "sweep.toml").write_text(SWEEP.replace("0.02", "0.3"))
    assert mpfcad("sweep", "sweep.toml", "--workers", "1", cwd=folder).returncode == 0
    return folder, content(folder / "exports" / "few-sweep")


def start_sweep(folder, out, *options):
    """Start a sweep and return its process once the first point is on the disk."""
    code = "from mpfcad.cli import main; main()"
    command = [sys.executable, "-c", code, "sweep", "sweep.toml", "--out", out, *options]
    cache = folder / f"{out}-cache"
    environment = {**os.environ, "MPFCAD_CACHE": str(cache)}
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stderr=subprocess.PIPE, text=True
    )
    while process.poll() is None and not any((cache / "point").glob("[!.]*")):
        time.sleep(0.05)
    return process


@pytest.mark.slow
def test_workers_change_nothing_and_a_killed_one_loses_nothing(alone):
    folder, expected = alone
    process = start_sweep(folder, "two", "--workers", "2")
    workers = [
        child
        for child in psutil.Process(process.pid).children(recursive=True)
        if "spawn_main" in " ".join(child.cmdline())
    ]
    assert workers
    workers[0].kill()
    assert process.wait(timeout=300) == 0, process.stderr.read()
    assert content(folder / "two") == expected


@pytest.mark.slow
@pytest.mark.parametrize("end", ["SIGKILL", "SIGSTOP"])
def test_a_scheduler_changes_nothing_and_a_worker_that_vanishes_or_hangs_loses_nothing(
    alone, monkeypatch, end
):
    folder, expected = alone
    # How long a worker may be silent before its work is given to another.
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL", "20 s")
    contact = folder / f"scheduler-{end}.json"
    where = ("--scheduler-file", str(contact), "--no-dashboard")
    started = [start_dask(folder, "scheduler", "--host", "127.0.0.1", "--port", "0", *where)]
    worker = ("worker", "--nthreads", "1", "--no-nanny", *where)
    started += [start_dask(folder, *worker) for _ in range(2)]
    try:
        while not contact.is_file():
            assert started[0].poll() is None
            time.sleep(0.05)
        address = json.loads(contact.read_text())["address"]
        process = start_sweep(folder, end, "--scheduler", address)
        assert process.poll() is None
        started[1].send_signal(signal.Signals[end])
        assert process.wait(timeout=300) == 0, process.stderr.read()
    finally:
        for one in started:
            one.kill()
            one.wait()
    assert content(folder / end) == expected


def start_dask(folder, *arguments):
    command = [sys.executable, "-m", "dask", *arguments]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.DEVNULL)
