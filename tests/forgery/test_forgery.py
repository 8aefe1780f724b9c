"""Forgeries without a key and with one; `python -m tests.forgery` is the long run."""

import json
import shutil

import pytest
from command import content

from mpfcad.errors import ExportError
from mpfcad.export import write_manifest
from mpfcad.export.text import canonical_json, encoded
from mpfcad.pipeline import verify_export

from .attack import Outcome, attack, make_export, memoised, wrong
from .edit import MAP, PAGE, RECORD, restated


@pytest.fixture(scope="module")
def export(tmp_path_factory):
    return make_export(tmp_path_factory.mktemp("forged"))


@pytest.fixture(scope="module")
def memo():
    with memoised(Outcome()):
        yield


def check(export, times, seed):
    original = content(export)
    del original["manifest.json"]
    outcome = attack(export, times, seed)
    faults = [wrong(original, *passed) for passed in outcome.passed]
    assert not any(faults), faults
    assert outcome.by_signature == outcome.unsigned > 0.9 * times
    assert sum(outcome.found.values()) > 0.8 * times


def test_forgeries_are_found(export, tmp_path):
    check(shutil.copytree(export, tmp_path / "e"), 25, seed=1)


@pytest.mark.slow
def test_many_forgeries_are_found(export, tmp_path):
    check(shutil.copytree(export, tmp_path / "e"), 1000, seed=2)


def test_a_wrong_pass_is_seen(export):
    """Else an attack that lets all pass would say that nothing passed."""
    original = content(export)
    record = json.loads(original[RECORD])
    record["verdict"] = "PASS!"
    forged = {**original, RECORD: json.dumps(record).encode()}
    assert wrong(original, "a", [RECORD], forged) == "a: a figure"
    assert wrong(original, "a", [PAGE], {**original, PAGE: b""}) == "a: the page"
    assert wrong(original, "a", [MAP], {**original, MAP: b""}) == "a: curvature.csv"
    assert wrong(original, "a", ["b"], {**original, "b": b""}) == "a: files"
    solid = restated(original, {**original, "film.step": b"solid"})
    assert wrong(original, "a", ["film.step"], solid) is None


def _twice(files):
    """Have a key stand twice: the last one counts here, another reader takes the first."""
    first = b'{\n "schema": 1,\n "verdict": "PASS",'
    files[RECORD] = files[RECORD].replace(b'{\n "schema": 1,', first, 1)


def _position(files):
    files[MAP] = files[MAP].replace(b"0,0.025000,", b"0,0.026000,", 1)


def _ratio(files):
    rows = files[MAP].decode().splitlines()
    rows[1] = rows[1].rpartition(",")[0] + ",0.5"
    files[MAP] = ("\n".join(rows) + "\n").encode()


def _more(files):
    files["release.html"] = b"<p>PASS"


def _less(files):
    del files[PAGE]


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        (_twice, "but not written as a run does"),
        (_position, "curvature.csv: differs from what its own curvatures"),
        (_ratio, "curvature.csv: differs from what its own curvatures"),
        (_more, "release.html: is no file of this export"),
        (_less, r"report.html: missing, and not in manifest.json"),
    ],
)
def test_what_no_figure_tells_is_found(export, memo, tmp_path, edit, says):
    files = content(export)
    del files["manifest.json"]
    edit(files)
    folder = tmp_path / "e"
    folder.mkdir()
    for name, data in files.items():
        (folder / name).write_bytes(data)
    write_manifest(folder, "forged", "run")
    with pytest.raises(ExportError, match=says):
        verify_export(folder)


@pytest.mark.parametrize(("name", "kind"), [("other", "run"), ("forged", "mask")])
def test_name_and_kind_of_a_manifest_are_those_of_the_record(export, tmp_path, name, kind):
    folder = shutil.copytree(export, tmp_path / "e")
    write_manifest(folder, name, kind)
    with pytest.raises(ExportError, match=r"manifest.json: (name|kind): '\w+': expected"):
        verify_export(folder)


def test_a_figure_of_the_trace_is_found(export, memo, tmp_path):
    """Forged in the record and on the page alike."""
    folder = shutil.copytree(export, tmp_path / "e")
    record = json.loads((folder / RECORD).read_bytes())
    record["luminance"]["luminance_cd_m2"][3] *= 1 + 1e-15
    (folder / RECORD).write_bytes(encoded(canonical_json(record)))
    write_manifest(folder, "forged", "run")
    with pytest.raises(ExportError, match=r"luminance_cd_m2\[3\]"):
        verify_export(folder)
