"""A scheduler that is not there, has no worker, or a worker of another version: one line."""

import threading

import dask
import pytest
from distributed import LocalCluster, Scheduler, SpecCluster, Worker

from mpfcad.cli import run_app
from mpfcad.pipeline.sweep import cluster as clustered

SWEEP = """name = "few"
[axis]
"map.curvature_per_mm" = [60.0]
[trace]
half_width = 0.0
paths_million = 0.02
"""


@pytest.fixture
def refused(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    (tmp_path / "sweep.toml").write_text(SWEEP)

    def run(address):
        out = tmp_path / "out"
        code = run_app(
            ["sweep", str(tmp_path / "sweep.toml"), "--out", str(out), "--scheduler", address]
        )
        (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
        assert code == 2 and len(line) <= 300 and not out.exists()
        return line

    return run


@pytest.fixture(scope="module")
def address():
    with LocalCluster(1, processes=False, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


def test_a_worker_of_another_version_is_refused(refused, address, monkeypatch):
    asked = {**clustered.running(), "numba": "0.1.2"}
    calls = iter([asked])
    here = clustered.running
    monkeypatch.setattr(clustered, "running", lambda: next(calls, None) or here())
    assert "a worker runs numba" in (line := refused(address)) and "expected 0.1.2" in line


def test_a_worker_that_lacks_what_is_asked_is_refused(refused, address, monkeypatch):
    def lacking(point):
        raise AttributeError("module 'mpfcad' has no attribute 'trace_point'")

    monkeypatch.setattr(clustered, "trace_point", lacking)
    assert "expected the same version of mpfcad on each worker" in refused(address)


def test_no_scheduler_and_no_worker_are_one_line(refused, monkeypatch):
    monkeypatch.setattr(clustered, "_PATIENCE", 1.0)
    assert "expected a Dask scheduler" in refused("tcp://127.0.0.1:9")
    options = {"protocol": "inproc", "dashboard": False}
    with SpecCluster(scheduler={"cls": Scheduler, "options": options}, workers={}) as cluster:
        assert "expected a Dask scheduler with workers" in refused(cluster.scheduler_address)


@pytest.mark.parametrize(
    ("lost", "words"),
    [("worker", "no worker is left"), ("scheduler", "the connection was lost")],
)
def test_who_vanishes_while_a_point_is_traced_is_one_line(refused, monkeypatch, lost, words):
    began, over = threading.Event(), threading.Event()

    def hanging(point):
        began.set()
        over.wait(60)

    monkeypatch.setattr(clustered, "trace_point", hanging)
    monkeypatch.setattr(clustered, "_LOOK", 0.2)
    monkeypatch.setitem(dask.config.config["distributed"]["comm"]["timeouts"], "connect", "1s")
    options = {"protocol": "inproc", "dashboard": False}
    of_one = {"cls": Worker, "options": {"nthreads": 1}}
    with SpecCluster(
        scheduler={"cls": Scheduler, "options": options}, workers={0: of_one}
    ) as cluster:

        def vanish():
            assert began.wait(60)
            monkeypatch.setattr(clustered, "_PATIENCE", 1.0)
            gone = cluster.scheduler
            call = gone.close() if lost == "scheduler" else gone.remove_worker(
                next(iter(gone.workers)), stimulus_id="test", close=False
            )  # fmt: skip
            cluster.sync(lambda: call)

        thread = threading.Thread(target=vanish)
        thread.start()
        try:
            assert words in refused(cluster.scheduler_address)
        finally:
            over.set()
            thread.join()
