"""The main job end to end with a short trace: same bytes again, verified, changes found."""

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from few_paths import few_paths
from jsonschema import ValidationError, validate

from mpfcad.cli import run_app
from mpfcad.errors import ExportError
from mpfcad.job import read_job
from mpfcad.pipeline import run_job, verify_export
from mpfcad.record import published_schema

MASKS = Path(__file__).parents[1] / "masks"
FILES = [
    "coupons.csv",
    "curvature.csv",
    "film.step",
    "film.stl",
    "manifest.json",
    "mask.gds",
    "mask.lyrdb",
    "mask.oas",
    "mask.png",
    "order.pdf",
    "report.html",
    "verification.json",
]
#: Of a job with a mesh alone.
PRINTED = ("coupons.csv", "order.pdf")


#: A narrow panel with lamps close together, so that its files are quickly made.
PRESET = 'preset = "thesis-32in-mpf"'
SMALL = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 40.0\npanel_length_mm = 50.0\n'
    "lamp_count = 5\nlamp_pitch_mm = 8.0\n"
)


@pytest.fixture(scope="module")
def short_trace():
    with few_paths():
        yield


def run(job_file, out, threads):
    return run_job(read_job(job_file), job_file, out, effort="quick", threads=threads)


@pytest.fixture(scope="module", params=["small", pytest.param("whole", marks=pytest.mark.slow)])
def job_file(request, tmp_path_factory):
    """Give the main job as it is, or for the narrow panel: its map a quarter as wide and high."""
    if request.param == "whole":
        return MASKS / "patterned-16mm.toml"
    folder = tmp_path_factory.mktemp("job")
    position, curvature = np.loadtxt(MASKS / "patterned-16mm.csv", delimiter=",", skiprows=1).T
    smaller = 8.0 / 32.69  # as a lamp pitch there; the slope, which registration bears, is the same
    curvature = curvature[0] + (curvature - curvature[0]) * smaller
    table = np.stack([position * smaller, curvature], axis=1)
    names = "position_mm,curvature_per_mm"
    np.savetxt(folder / "patterned-16mm.csv", table, "%.6f", ",", header=names, comments="")
    (folder / "small.toml").write_text(SMALL)
    text = (MASKS / "patterned-16mm.toml").read_text()
    assert PRESET in text
    text = text.replace(PRESET, 'file = "small.toml"') + "\n[cad]\nlength_mm = 0.5\n"
    (folder / "patterned-16mm.toml").write_text(text)
    return folder / "patterned-16mm.toml"


@pytest.fixture(scope="module")
def export(job_file, tmp_path_factory, short_trace):
    out = tmp_path_factory.mktemp("exports") / "patterned-16mm"
    run(job_file, out, 1)
    return out


@pytest.fixture
def copy(export, tmp_path):
    return shutil.copytree(export, tmp_path / "copy")


def test_export_holds_its_files_and_nothing_else_is_left(export):
    assert sorted(path.name for path in export.iterdir()) == FILES
    assert [path.name for path in export.parent.iterdir()] == ["patterned-16mm"]


def test_same_bytes_again_at_another_thread_count(job_file, export, tmp_path):
    run(job_file, tmp_path / "again", 2)
    for name in FILES:
        assert (tmp_path / "again" / name).read_bytes() == (export / name).read_bytes(), name


def test_verify_finds_the_same_figures(export):
    stored = json.loads((export / "verification.json").read_text())
    assert verify_export(export, threads=2) == stored


@pytest.mark.parametrize("name", FILES)
def test_one_changed_byte_fails_at_once_and_names_the_file(copy, name, capsys, monkeypatch):
    import mpfcad.pipeline.run.examine

    monkeypatch.delattr(mpfcad.pipeline.run.examine, "examine")
    path = copy / name
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert run_app(["verify", str(copy)]) == 4
    error = [line for line in capsys.readouterr().err.splitlines() if line.startswith("mpfcad: ")]
    assert len(error) == 1
    assert name in error[0]


def test_verification_document_holds_what_its_schema_says(export):
    record = json.loads((export / "verification.json").read_text())
    assert record["schema"] == 1
    assert {len(values) for values in record["luminance"].values()} == {33}
    curve = record["luminance"]
    assert curve["position_pitch"] == [i / 32 for i in range(33)]
    assert record["mask"]["aperture_ratio_error_max"] < 0.001
    assert record["mesh"]["watertight"] is True
    assert record["energy"]["lost"] == 0
    assert {entry["tag"] for entry in record["inputs"]} == {"given", "sourced", "assumed"}
    assert record["provenance"]["traced"]["sha256"] == record["provenance"]["sha256"]["film.stl"]
    assert record["provenance"]["command"] == "mpfcad run patterned-16mm.toml --effort quick"
    assert {gate["outcome"] for gate in record["gates"][1:]} == {"PASS"}


def test_verification_document_is_documented(export):
    text = (MASKS.parent / "docs" / "verification.md").read_text()
    record = json.loads((export / "verification.json").read_text())
    for key in [*record, *record["provenance"], *record["job"]]:
        assert f"`{key}`" in text, key
    for gate in record["gates"]:
        assert f"`{gate['name']}`" in text, gate["name"]


def test_export_names_neither_time_nor_place(export):
    for name in ("verification.json", "manifest.json"):
        text = (export / name).read_text()
        assert str(export.parent) not in text
        assert not re.search(r"\b20\d\d-\d\d-\d\d", text), name
        assert '"/' not in text


class Page(HTMLParser):
    """Collects what a page refers to, its ids, and whether its tags match."""

    VOID = (
        "meta",
        "br",
        "input",
        "rect",
        "polygon",
        "polyline",
        "line",
        "circle",
        "path",
        "img",
        "link",
    )

    def __init__(self):
        super().__init__()
        self.references, self.ids, self.open = [], [], []

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("src", "href"):
                # An embedded picture refers to nothing outside the page, nor does no icon at all.
                inside = value.startswith("data:image/png;base64,") or value == "data:,"
                self.references += [value] * (not inside)
            if name == "id":
                self.ids.append(value)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in self.VOID:
            assert self.open.pop() == tag


def test_report_is_self_contained_and_well_formed(export):
    page = Page()
    text = (export / "report.html").read_text()
    page.feed(text)
    assert page.open == []
    assert set(page.references) <= set(FILES)
    assert len(page.ids) == len(set(page.ids))
    assert {"plot-film", "plot-grooves", "plot-luminance"} <= set(page.ids)
    record = json.loads((export / "verification.json").read_text())
    assert f'<div class="banner {record["verdict"]}">' in text
    for digest in record["provenance"]["sha256"].values():
        assert digest in text


def test_what_is_written_is_what_the_published_schemas_say(export):
    for name in ("verification", "manifest"):
        document = json.loads((export / f"{name}.json").read_text())
        validate(document, published_schema(name))
    broken = {**document, "files": {"film.stl": {"sha256": "0", "bytes": 1}}}
    with pytest.raises(ValidationError):
        validate(broken, published_schema("manifest"))


def small_job(folder, text):
    """Write a job on a small panel and return its path."""
    (folder / "small.toml").write_text(SMALL)
    job = folder / "job.toml"
    job.write_text(f'{text}[cad]\nlength_mm = 0.5\n[stack]\nfile = "small.toml"\n')
    return job


def test_ideal_film_has_no_mask_and_says_so(tmp_path, short_trace):
    text = 'name = "ideal"\n[map]\ncurvature_per_mm = 60.0\n[film]\nprofile = "ideal"\n'
    job = small_job(tmp_path, text)
    out = tmp_path / "out"
    record = run_job(read_job(job), job, out, effort="quick", threads=2)
    assert record["mask"] is None
    assert sorted(path.name for path in out.iterdir()) == [
        name for name in FILES if name not in PRINTED and "mask" not in name
    ]
    assert "no mask" in (out / "report.html").read_text()
    assert run_app(["mask", str(job), "--out", str(tmp_path / "m")]) == 2
    assert not (tmp_path / "m").exists()


@pytest.fixture(scope="module")
def own(tmp_path_factory, short_trace):
    """Return an export of a job with its own stack and calibration, whose files are deleted."""
    folder = tmp_path_factory.mktemp("own")
    shutil.copy(MASKS / "process-thesis.toml", folder / "p.toml")
    text = 'name = "own"\n[map]\ncurvature_per_mm = 58.0\n[process]\ncalibration = "p.toml"\n'
    job = small_job(folder, text)
    run_job(read_job(job), job, folder / "out", effort="quick", threads=2)
    for path in folder.glob("*.toml"):
        path.unlink()
    return folder / "out"


def test_own_stack_and_calibration_travel_with_the_export(own):
    record = json.loads((own / "verification.json").read_text())
    assert sorted(record["provenance"]["inputs_sha256"]) == ["job.toml", "p.toml", "small.toml"]
    assert verify_export(own) == record


def test_figure_changed_together_with_its_hashes_is_found(own):
    from mpfcad.export import canonical_json, write_manifest

    path = own / "verification.json"
    before = path.read_text()
    record = json.loads(before)
    values = record["luminance"]["luminance_cd_m2"]
    values[3] = float(np.nextafter(values[3], np.inf))
    path.write_text(canonical_json(record))
    write_manifest(own, record["name"], "run")
    with pytest.raises(ExportError, match=r"verification.json: luminance.luminance_cd_m2\[3\]"):
        verify_export(own)
    path.write_text(before)
    write_manifest(own, record["name"], "run")


@pytest.mark.parametrize("name", ["report.html", pytest.param("mask.png", marks=pytest.mark.slow)])
def test_a_forged_page_or_picture_is_found_though_every_hash_holds(own, tmp_path, name):
    from mpfcad.export import canonical_json, sha256, write_manifest

    folder = tmp_path / "out"
    shutil.copytree(own, folder)
    path = folder / name
    before = path.read_bytes()
    forged = before.replace(b"INCONCLUSIVE", b"PASS") if name == "report.html" else before + b" "
    assert forged != before
    path.write_bytes(forged)
    record = json.loads((folder / "verification.json").read_text())
    if name in record["provenance"]["sha256"]:
        record["provenance"]["sha256"][name] = sha256(path)
        (folder / "verification.json").write_text(canonical_json(record))
    write_manifest(folder, "own", "run")
    with pytest.raises(ExportError, match=f"{name}: differs from what the record"):
        verify_export(folder)


@pytest.mark.parametrize(
    ("table", "change", "said"),
    [
        pytest.param(
            "versions",
            {"mpfcad": "0.1.0"},
            r"made by mpfcad 0\.1\.0 \(here ",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "versions",
            {"numba": "0.61.0"},
            r"made by numba 0\.61\.0 \(here ",
            marks=pytest.mark.slow,
        ),
        (None, {"code_sha256": "0" * 64}, r"made by mpfcad \S+ of code 000000000000 \(here "),
    ],
)
def test_an_export_of_another_version_says_which(own, table, change, said):
    """Of its figures one differs, or its job is not read by this version."""
    from mpfcad.export import canonical_json, write_manifest

    path = own / "verification.json"
    before = path.read_text()
    for damage in ({"paths": 1}, {"job": {**json.loads(before)["job"], "stack": {}}}):
        record = {**json.loads(before), **damage}
        place = record["provenance"] if table is None else record["provenance"][table]
        place.update(change)
        path.write_text(canonical_json(record))
        write_manifest(own, record["name"], "run")
        with pytest.raises(ExportError, match=said):
            verify_export(own)
    path.write_text(before)
    write_manifest(own, json.loads(before)["name"], "run")


def test_empty_film_is_a_bef_without_apertures(tmp_path, short_trace):
    job = small_job(tmp_path, 'name = "bef"\n[map]\ncurvature_per_mm = 80.0\n')
    record = run_job(read_job(job), job, tmp_path / "out", effort="quick", threads=2)
    assert record["mask"]["files"]["mask.oas"]["aperture_count"] == 0
    assert list(record["step"]["bodies_volume_mm3"]) == ["BEF"]
    assert record["mask_mesh_curvature_difference_per_mm"] < 0.01


@pytest.mark.parametrize(("command", "kind"), [("mask", "oas"), ("cad", "stl")])
def test_single_steps_write_only_what_was_asked(tmp_path, command, kind, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = 'name = "c60"\n[map]\ncurvature_per_mm = 60.0\n[process]\nsolids_fraction = 0.5\n'
    job = small_job(tmp_path, text + '[mask]\nmesh = "150-31"\n')
    assert run_app([command, str(job), "--format", kind]) == 0
    folder = tmp_path / "exports" / f"c60-{command}"
    made = {
        "mask": ["coupons.csv", "mask.lyrdb", "mask.oas", "mask.png", "order.pdf", "screen.json"],
        "cad": ["film.stl"],
    }[command]
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        ["curvature.csv", "manifest.json", *made]
    )
    # An export with a verdict is never replaced by a part of it, nor the other way round.
    assert run_app(["run", str(job), "--out", str(folder)]) == 2


@pytest.fixture(scope="module")
def changed(own, tmp_path_factory):
    """Return a copy of an export in which one byte of the mesh differs."""
    folder = tmp_path_factory.mktemp("changed") / "out"
    shutil.copytree(own, folder)
    content = bytearray((folder / "film.stl").read_bytes())
    content[200] ^= 1
    (folder / "film.stl").write_bytes(bytes(content))
    return folder


def test_verify_tells_a_build_server(own, changed, tmp_path, capsys):
    from xml.etree import ElementTree

    for folder, verified in ((own, True), (changed, False)):
        report = tmp_path / "junit.xml"
        code = run_app(["verify", str(folder), "--json", "--junit", str(report)])
        found = json.loads(capsys.readouterr().out)
        validate(found, published_schema("verify"))
        assert found["verified"] is verified
        suite = ElementTree.fromstring(report.read_bytes())
        failed = [case.get("name") for case in suite if case.find("failure") is not None]
        if not verified:
            assert code != 0
            assert "film.stl" in found["changed"]
            assert failed == ["export_unchanged"]
            continue
        assert [gate["name"] for gate in found["gates"]] == [c.get("name") for c in suite][1:]
        bad = [g["name"] for g in found["gates"] if g["outcome"] in ("FAIL", "INCONCLUSIVE")]
        assert failed == bad
        assert suite.get("failures") == str(len(bad))


def test_trace_of_the_shipped_file_gives_the_figures_of_the_run(job_file, export, capsys):
    stored = json.loads((export / "verification.json").read_text())
    offset = repr(stored["provenance"]["traced"]["offset_mm"])
    options = ["--thickness-mm", "16", "--offset-mm", offset, "--effort", "quick", "--json"]
    if (stack := job_file.parent / "small.toml").is_file():
        options = ["--stack", str(stack), *options]
    assert run_app(["trace", str(export / "film.stl"), *options]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["luminance"] == stored["luminance"]
    assert figures["accelerator"] == "chain"
    validate(figures, published_schema("trace"))
    assert run_app(["trace", str(export / "film.stl"), *options[:-1]]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-2] == "accelerator chain"
    assert lines[-1].startswith("read film.stl: binary STL, ")
