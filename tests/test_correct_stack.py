"""`mpfcad correct --stack`: the fitted backlight and its covariance stand in the next job."""

from dataclasses import replace

import numpy as np
import pytest
import tomli_w

from mpfcad.backlight import read_stack
from mpfcad.backlight.written import stack_tables
from mpfcad.errors import InputError
from mpfcad.export import export_folder, write_manifest, write_text
from mpfcad.job import build_job, read_job
from mpfcad.pipeline.correct.next_job import write_job
from mpfcad.pipeline.correct.printed import _fitted
from mpfcad.pipeline.plan.plan import read_plan


@pytest.fixture
def plan(tmp_path):
    document = {
        "name": "printed",
        "map": {"rows": [[0.0, 62.0], [8.0, 60.0], [16.345, 58.0]], "repeat": "mirror"},
    }
    return read_plan(build_job(document, "printed"), tmp_path / "printed.toml")


def fitted(tmp_path, **changed):
    """Return a fitted stack's file, in a folder as `mpfcad fit` makes it."""
    change = {"top_sheet_sigma": {"value": 0.31, "sigma": 0.01}, **changed}
    stack = read_stack("thesis-32in-mpf", overrides=change)
    with export_folder(tmp_path / "fit", "fit") as folder:
        write_text(folder / "b.toml", tomli_w.dumps(stack_tables(stack)))
        write_text(folder / "covariance.csv", "top_sheet_sigma\n0.0001\n")
        write_manifest(folder, "b", "fit")
    return tmp_path / "fit" / "b.toml"


class Found:
    """What a reprint says that the job's writer reads."""

    position = np.linspace(0, 1, 5)
    curvature = np.full(5, 60.0)


def test_the_next_job_has_the_fitted_backlight_and_its_covariance(tmp_path, plan):
    file = fitted(tmp_path)
    changed = replace(plan, stack=_fitted(plan, file))
    assert changed.stack["top_sheet_sigma"] == 0.31
    out = tmp_path / "next"
    out.mkdir()
    write_job(out, changed, Found(), changed.job.given(), None, file)
    job = read_job(out / "printed-corrected.toml")
    again = read_plan(job, out / "printed-corrected.toml")
    assert again.stack.quantity == changed.stack.quantity
    assert job.confidence.sigmas() == {"top_sheet_sigma": pytest.approx(0.01)}


def test_another_lamp_pitch_is_refused(tmp_path, plan):
    with pytest.raises(InputError, match=r"lamp pitch 30 mm: expected the export.s 32.69 mm"):
        _fitted(plan, fitted(tmp_path, lamp_pitch_mm=30.0))
