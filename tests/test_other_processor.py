"""`verify` on another processor: its paths in OpenBLAS and numpy; and forgeries that are none."""

import copy
import json
import os
import shutil
import subprocess
import sys

import pytest
from test_run_job import small_job

from mpfcad.cli import run_app
from mpfcad.export import write_manifest
from mpfcad.job import read_job
from mpfcad.pipeline import run_job
from mpfcad.pipeline.effort import TRACE_SETTINGS, TraceSetting
from mpfcad.record import compare_records

#: What a processor with nothing beyond SSE3 takes.
OLD = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL "
       "AVX512_SPR AVX2 FMA3 AVX512F AVX512CD AVX512_SKX"}  # fmt: skip


@pytest.fixture(scope="module")
def export(tmp_path_factory):
    folder = tmp_path_factory.mktemp("other")
    text = 'name = "own"\n[map]\ncurvature_per_mm = 58.0\n[mask]\nformats = ["oas"]\n'
    job = small_job(folder, text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(TRACE_SETTINGS, "quick", TraceSetting(1.0, 100_000))
        run_job(read_job(job), job, folder / "out", effort="quick", threads=2)
    return folder / "out"


def test_an_untouched_export_verifies_there(export, tmp_path):
    code = "from mpfcad.cli import main; main()"
    result = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code, "verify", str(export)], text=True, timeout=600,
        capture_output=True, env={**os.environ, **OLD, "MPFCAD_CACHE": str(tmp_path)},
    )  # fmt: skip
    assert result.returncode in (0, 1), result.stderr
    line = result.stdout.splitlines()[0]
    assert line.startswith("verified: every hash holds, and the figures come out the same")


@pytest.fixture(scope="module")
def record(export):
    return json.loads((export / "verification.json").read_bytes())


def changed(record, path, factor):
    """Return a copy of a record with one number multiplied."""
    other = copy.deepcopy(record)
    *places, last = path
    table = other
    for place in places:
        table = table[place]
    table[last] *= factor
    return other


FIT = [
    ("lamp_mura_contrast", "ci95", 1),
    ("mean_luminance_cd_m2", "value"),
    ("gates", 0, "ci95", 1),
]
SUMS = [
    ("luminance", "luminance_cd_m2", 3),
    ("energy", "out"),
    ("baseline", "luminance", "luminance_cd_m2", 0),
    ("gates", 0, "limit"),
    ("paths",),
]


@pytest.mark.parametrize("path", FIT, ids=map(str, FIT))
def test_the_last_bits_of_a_fit_are_said_and_no_more_than_they(record, path):
    rounded = compare_records(changed(record, path, 1 + 1e-13), record)
    assert rounded.difference is None and len(rounded.rounded) == 1
    assert rounded.rounded[0].share == pytest.approx(1e-13, rel=0.1)
    assert compare_records(changed(record, path, 1 + 1e-10), record).difference


@pytest.mark.parametrize("path", SUMS, ids=map(str, SUMS))
def test_what_is_summed_or_given_is_compared_bit_for_bit(record, path):
    assert compare_records(changed(record, path, 1 + 2.3e-16), record).difference


def test_a_word_a_type_and_a_missing_key_differ(record):
    for change in ({"verdict": "PASS "}, {"schema": True}, {"step": None}):
        assert compare_records({**record, **change}, record).difference
    less = {key: value for key, value in record.items() if key != "mesh"}
    assert "mesh: only in the new result" in compare_records(less, record).difference
    assert "mesh: only in the file" in compare_records(record, less).difference


@pytest.fixture
def forge(export, tmp_path):
    """Return what puts another verification.json into a copy, every hash computed anew."""

    def made(text):
        folder = shutil.copytree(export, tmp_path / "copy", dirs_exist_ok=True)
        (folder / "verification.json").write_text(text)
        write_manifest(folder, "own", "run")
        return folder

    return made


@pytest.mark.parametrize("text", ["", "[]", "{}", "[" * 99_999, '{"job": {}}', "NaN"])
def test_a_malformed_record_is_one_line(forge, capsys, text):
    assert run_app(["verify", str(forge(text))]) == 4
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert "verification.json" in line and len(line) <= 300


@pytest.mark.parametrize("key", ["stack", "given", "resolved", "trace"])
@pytest.mark.parametrize("value", [None, []])
def test_a_job_that_is_none_is_one_line(forge, record, capsys, key, value):
    job = {**record["job"], key: value}
    if job == record["job"]:
        return
    assert run_app(["verify", str(forge(json.dumps({**record, "job": job})))]) == 4
    (line,) = [x for x in capsys.readouterr().err.splitlines() if x.startswith("mpfcad: ")]
    assert "verification.json" in line and len(line) <= 300
