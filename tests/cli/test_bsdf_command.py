"""`mpfcad bsdf` and tables in `mpfcad trace`, from outside."""

import json

import numpy as np
import pytest
from harness import BARE, film_file

from mpfcad.cli import run_app
from mpfcad.optics.bsdf.file import read_bsdf


def output(capsys, *arguments):
    assert run_app([*map(str, arguments)]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_mesh_becomes_a_table_that_reads_back_and_converts(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    film_file(tmp_path / "bef.stl", [BARE])
    made = output(
        capsys, "bsdf", "bef.stl", "--index", 1.5, "--basis", "klems-quarter", "--rays", 2000,
        "--seed", 3, "--threads", 1, "--page", "--out", "o", "--json",
    )  # fmt: skip
    assert made["written"] == ["o/bef.xml", "o/bef-bsdf.html"]
    assert sorted(p.name for p in (tmp_path / "o").iterdir()) == ["bef-bsdf.html", "bef.xml"]
    assert made["lambertian_transmittance"]["below"] == pytest.approx(0.5382, abs=0.005)
    assert all(row["most"] == pytest.approx(1, abs=1e-9) for row in made["energy"])
    assert made["trace"]["rays_per_bin"] == 2000
    shown = output(capsys, "bsdf", "o/bef.xml", "--reciprocal", "--format", "csv", "--json")
    assert shown["reciprocity_error"] < 1e-9
    assert shown["energy"][0]["incidence_deg"] == 0
    xml, csv = read_bsdf(tmp_path / "o" / "bef.xml"), read_bsdf(tmp_path / "bef.csv")
    np.testing.assert_allclose(csv.value, xml.value, rtol=1e-9, atol=1e-12)
    page = (tmp_path / "o" / "bef-bsdf.html").read_text()
    assert "barpolar" in page and "https://" not in page.split("</script>")[-1]
    # The same seed, the same bytes, at any number of threads.
    first = (tmp_path / "o" / "bef.xml").read_bytes()
    output(capsys, "bsdf", "bef.stl", "--index", 1.5, "--basis", "klems-quarter", "--rays", 2000,
           "--seed", 3, "--threads", 2, "--out", "o", "--json")  # fmt: skip
    assert (tmp_path / "o" / "bef.xml").read_bytes() == first


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["gone.xml"], "gone.xml: no such file"),
        (["gone.stl"], "gone.stl: no such file"),
        (["bef.stl", "--basis", "fine"], "--basis: fine: expected klems-full"),
        (["bef.stl", "--format", "ldt"], "--format: ldt: expected some of klems, csv, zemax"),
        (["bef.stl", "bef.stl"], "several files: expected for Zemax .bsdf only"),
        (["a.csv", "b.csv"], "b.csv: several files: expected for Zemax .bsdf only"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    film_file(tmp_path / "bef.stl", [BARE])
    (tmp_path / "a.csv").write_text("x")
    (tmp_path / "b.csv").write_text("x")
    before = sorted(p.name for p in tmp_path.iterdir())
    assert run_app(["bsdf", *arguments]) == 2
    error = capsys.readouterr().err
    assert words in error and error.count("mpfcad: ") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_trace_needs_a_mesh_or_a_table(tmp_path, capsys):
    assert run_app(["trace", "--effort", "quick"]) == 2
    assert "stack thesis-32in-mpf: its film needs a mesh" in capsys.readouterr().err
