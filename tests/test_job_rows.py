"""A map in the job itself is the map of a file with the same rows; a job in memory is a job."""

import json
from pathlib import Path

import numpy as np
import pytest
from few_paths import few_paths

from mpfcad.errors import InputError
from mpfcad.job import build_job
from mpfcad.pipeline import read_plan, run_job, verify_export

ROWS = [[0.0, 62.0], [1.0, 60.0], [2.5, 57.0], [4.0, 55.0]]
STACK = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 40.0\npanel_length_mm = 50.0\n'
    "lamp_count = 5\nlamp_pitch_mm = 8.0\n"
)


def job(folder, **mapped):
    (folder / "stack.toml").write_text(STACK)
    table = {"extent": "pitch", "repeat": "mirror", **mapped}
    return build_job(
        {"name": "rows", "map": table, "stack": {"file": "stack.toml"}, "cad": {"length_mm": 0.1}},
        "memory",
    )


def test_rows_are_the_rows_of_a_file(tmp_path):
    lines = "".join(f"{x},{c}\n" for x, c in ROWS)
    (tmp_path / "m.csv").write_text("position_mm,curvature_per_mm\n" + lines)
    of_file = read_plan(job(tmp_path, file="m.csv"), tmp_path / "job.toml")
    of_rows = read_plan(job(tmp_path, rows=ROWS), tmp_path / "job.toml")
    assert np.array_equal(of_file.panel.curvature, of_rows.panel.curvature)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([[0.0, 62.0], [4.0, 90.0]], ["map.rows: row 1: curvature_per_mm 90"]),
        ([[0.0, 66.0], [0.0, 60.0]], ["map.rows: row 1: position_mm 0: duplicate of row 0"]),
        ([[0.0, 66.0], [3.0, 60.0]], ["map.rows: row 1: position_mm 3: gap"]),
    ],
)
def test_a_wrong_row_is_named(tmp_path, rows, words):
    with pytest.raises(InputError) as error:
        read_plan(job(tmp_path, rows=rows), tmp_path / "job.toml")
    for word in words:
        assert word in str(error.value)


def test_one_map_only(tmp_path):
    with pytest.raises(InputError, match="exactly one of file, curvature_per_mm, rows"):
        job(tmp_path, rows=ROWS, curvature_per_mm=60.0)


def test_a_job_that_is_in_no_file_is_run_and_verified(tmp_path):
    with few_paths():
        record = run_job(
            job(tmp_path, rows=ROWS), tmp_path / "none.toml", tmp_path / "out", effort="quick"
        )
        assert not Path(tmp_path / "none.toml").exists()
        assert len(record["provenance"]["inputs_sha256"]["none.toml"]) == 64
        stored = json.loads((tmp_path / "out" / "verification.json").read_text())
        assert verify_export(tmp_path / "out") == stored
