"""No network at run time: a whole job runs where no socket can be opened to another machine."""

import socket

import pytest
from test_run_job import small_job

from mpfcad.cli import run_app
from mpfcad.pipeline.effort import TRACE_SETTINGS, TraceSetting


@pytest.mark.slow
def test_a_job_its_report_and_its_verification_open_no_connection(tmp_path, monkeypatch):
    tried = []

    def refuse(self, address, *rest):
        tried.append(address)
        raise OSError("no network")

    for name in ("connect", "connect_ex", "sendto"):
        monkeypatch.setattr(socket.socket, name, refuse)
    monkeypatch.setattr(socket, "getaddrinfo", lambda *a, **k: refuse(None, a))
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(1.0, 100_000))
    monkeypatch.chdir(tmp_path)
    small_job(tmp_path, 'name = "a"\n[map]\ncurvature_per_mm = 58.0\n[mask]\nformats = ["oas"]\n')
    assert run_app(["run", "job.toml", "--effort", "quick"]) in (0, 1)
    assert run_app(["verify", "exports/a"]) in (0, 1)
    assert tried == []
    with pytest.raises(OSError, match="no network"):
        socket.create_connection(("192.0.2.1", 80))
    assert tried, "the block does not block"
