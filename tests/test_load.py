"""Many jobs one after another in one process: no growth of memory, handles or threads."""

import gc

import numpy as np
import psutil
import pytest
from command import SMALL_STACK
from few_paths import few_paths

from mpfcad.job import read_job
from mpfcad.pipeline import run_job

#: What one more job may leave behind [bytes]: a thousand of them 20 MB.
GROWTH = 20_000


def used():
    """Return memory [bytes], handles and threads of this process."""
    gc.collect()
    process = psutil.Process()
    handles = process.num_fds() if hasattr(process, "num_fds") else process.num_handles()
    return process.memory_info().rss, handles, process.num_threads()


def run_many(folder, count, every):
    """Run jobs of changing curvature; return what is used after each `every` of them."""
    rows = []
    for number in range(count):
        text = f'name = "a"\nseed = {number}\n[map]\ncurvature_per_mm = {55 + number % 9}\n'
        (folder / "job.toml").write_text(text + SMALL_STACK)
        run_job(read_job(folder / "job.toml"), folder / "job.toml", folder / "out", effort="quick")
        if (number + 1) % every == 0:
            rows.append((number + 1, *used()))
            print(*rows[-1])
    return np.array(rows, float)


@pytest.mark.slow
@pytest.mark.parametrize("count", [100, 1000])
def test_jobs_leave_nothing_in_memory(tmp_path, monkeypatch, count):
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    with few_paths():
        number, memory, handles, threads = run_many(tmp_path, count, count // 10).T
    later = number > 0.3 * count  # the first ones fill caches of fixed size
    assert np.polyfit(number[later], memory[later], 1)[0] < GROWTH
    assert np.ptp(handles[later]) <= 2 and np.ptp(threads[later]) <= 2
