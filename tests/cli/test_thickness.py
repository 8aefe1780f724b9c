"""Thickness: the least that serves, where the luminance is the conventional stack's, more lamps."""

import json
import tomllib
from types import SimpleNamespace

import pytest
from command import called, content, mpfcad, refused
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.job.design import Design, ThicknessTable
from mpfcad.job.reader import validate
from mpfcad.measure import flux, rounds
from mpfcad.pipeline.design.thickness import ThicknessSearch
from mpfcad.pipeline.point.thickness_limit import crossings, describe_limit, spread_lamps

RANGE = """
schema = 1
name = "least"
[goal]
contrast_target = 0.1
[constraint]
curvature_min_per_mm = 50.0
curvature_max_per_mm = 62.0
harmonics = 2
[search]
iterations = 1
paths_million = 0.05
[thickness]
min_mm = 8.0
max_mm = 20.0
step_mm = 12.0
[gates]
contrast_pass = 0.05
contrast_marginal = 0.09
[mask]
period_um = 640.0
"""
SWEEP = """
schema = 1
name = "slim"
contrast_limit = 0.09
[axis]
"stack.thickness_mm" = [8.0, 20.0]
lamp_count = [12.0, 14.0]
[map]
curvature_per_mm = 60.0
[trace]
half_width = 0.0
paths_million = 0.02
"""


class KnownSearch(ThicknessSearch):
    """A search of which the model and the traces say what the test gives them."""

    def __init__(self, values, model, truth):
        self.values, self.limit, self.tried = values, 0.5, []
        self._model, self._truth = model, truth

    def _predict(self, thickness):
        return SimpleNamespace(contrast=0.0 if thickness >= self._model else 1.0)

    def _serves(self, thickness):
        assert thickness not in self.tried
        self.tried.append(thickness)
        return thickness >= self._truth


@given(st.integers(1, 40), st.integers(0, 45), st.integers(0, 45))
def test_the_least_thickness_is_found_whatever_the_model_says(count, model, truth):
    search = KnownSearch(list(range(count)), model, truth)
    found = search.search()
    assert found == (truth if truth < count else None)
    if model == truth:
        assert len(search.tried) <= 2


def test_thicknesses_of_a_range():
    table = ThicknessTable(min_mm=10.0, max_mm=12.2, step_mm=0.5)
    assert table.values() == [10.0, 10.5, 11.0, 11.5, 12.0, 12.2]
    assert ThicknessTable(min_mm=10.0, max_mm=12.0).values()[-2:] == [11.5, 12.0]


def test_where_the_luminance_is_the_conventional_stacks():
    assert crossings([10, 12, 14], [1.0, 3.0, 2.0], 2.5) == pytest.approx([11.5, 13.0])
    assert crossings([10, 12], [1.0, 2.0], 1.0) == [10]
    assert crossings([10, 12], [1.0, 2.0], 2.0) == [12]
    contrast = [{"ci95": [0.02, 0.03]}, {"ci95": [0.01, 0.02]}, {"ci95": [0.0, 0.018]}]
    found = describe_limit([10, 12, 14], contrast, [900.0, 1100.0, 1200.0], 1000.0, 0.018)
    assert (found["fails_mm"], found["undecided_mm"], found["serves_mm"]) == ([10], [12], [14])
    assert found["equal_luminance_mm"] == pytest.approx([11.0])


def test_one_thickness_of_a_range_is_a_design_of_its_own():
    design = validate(Design, tomllib.loads(RANGE), "design.toml")
    job = design.at_thickness(12.0, spread_lamps(392.26, 14)).job_document("map.csv")
    assert "thickness" not in job
    assert job["stack"]["thickness_mm"] == 12.0 and job["stack"]["override"]["lamp_count"] == 14
    assert 14 * job["stack"]["override"]["lamp_pitch_mm"] == pytest.approx(392.26, abs=1e-4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("max_mm = 20.0", "max_mm = 8.0"), ["thickness", "max_mm = 8: expected above min_mm = 8"]),
        (
            ("[mask]", "[stack]\nthickness_mm = 16.0\n[mask]"),
            ["stack.thickness_mm: expected no such field"],
        ),
        (("iterations = 1", 'method = "thesis"'), ["thesis", "no model"]),
        (("min_mm = 8.0", "min_mm = 1.0"), ["thickness_mm: 1"]),
    ],
)
def test_what_is_wrong_with_a_range_is_said_in_one_line(tmp_path, change, words):
    (tmp_path / "design.toml").write_text(RANGE.replace(*change))
    result = called("design", "design.toml", cwd=tmp_path)
    refused(result, "design.toml", *words)
    assert not (tmp_path / "exports").exists()


def test_a_sweep_over_thickness_and_lamps_says_which_thickness_serves(tmp_path, monkeypatch):
    # As many as tell a contrast of 0.02 to less than the 0.09 that is allowed.
    monkeypatch.setattr(rounds, "LEAST_PATHS", 130_000)
    monkeypatch.setattr(flux, "_ENERGY_BLOCKS", 4)
    (tmp_path / "sweep.toml").write_text(SWEEP)
    result = called("sweep", "sweep.toml", "--workers", "1", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    record = json.loads((tmp_path / "exports" / "slim-sweep" / "sweep.json").read_bytes())
    few, many = record["thickness_limits"]
    assert few["curve"] == {"lamp_count": 12.0} and many["curve"] == {"lamp_count": 14.0}
    assert few["fails_mm"] == [8.0] and few["serves_mm"] == [20.0]
    # A sixth more lamps, each as bright: a sixth more light, within the noise of 130 000 paths.
    assert many["relative_luminance"][0] > 1.05 * few["relative_luminance"][0]
    assert "lamp_count = 12.0: The printed film serves 20 mm" in result.stdout
    assert "does not serve 8 mm" in result.stdout
    page = (tmp_path / "exports" / "slim-sweep" / "sweep.html").read_text()
    assert "Limit of thickness" in page


@pytest.mark.slow
def test_a_design_finds_the_least_thickness_and_resumes_to_the_same_bytes(tmp_path, monkeypatch):
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "cache"))
    (tmp_path / "design.toml").write_text(RANGE)
    arguments = ("design", "design.toml", "--no-verify", "--threads", "1")
    result = mpfcad(*arguments, cwd=tmp_path, timeout=1800)
    assert result.returncode == 0, result.stderr
    out = tmp_path / "exports" / "least-design"
    whole = content(out)
    found = json.loads(whole["design.json"])["thickness"]
    least = found["least_mm"]
    assert least == 20.0
    assert tomllib.loads(whole["least.toml"].decode())["stack"]["thickness_mm"] == least
    outcomes = {p["thickness_mm"]: p["traced"]["outcome"] for p in found["points"] if p["traced"]}
    assert outcomes == {8.0: "fails", 20.0: "serves"}
    bare, *changed = found["remedies"]
    assert bare["override"] == {} and len(changed) == 4
    assert min(one["lamp_mura_contrast"] for one in changed) < bare["lamp_mura_contrast"]
    bounds = {one["thickness_mm"]: one["contrast_bound"] for one in found["bounds"]}
    assert 0.09 < bounds[8.0] <= bare["lamp_mura_contrast"]
    assert "The printed film cannot serve 8 mm" in result.stdout
    assert f"Least thickness that serves, of 8 … 20 mm: {least:g} mm." in result.stdout
    assert "conventional stack's" in result.stdout

    # As if it had been killed in its last trace.
    kept = (tmp_path / "cache" / "design").iterdir()
    max(kept, key=lambda path: path.stat().st_mtime_ns).unlink()
    result = mpfcad(*arguments, cwd=tmp_path, timeout=1800)
    assert result.returncode == 0, result.stderr
    assert result.stderr.count("tracing iteration") == 1
    assert "tracing the conventional stack" not in result.stderr
    assert content(out) == whole
