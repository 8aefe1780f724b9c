"""The confidence of a job: its inputs, changed films, figures against full traces."""

from dataclasses import replace

import numpy as np
import pytest

from mpfcad.confidence import draw_steps
from mpfcad.errors import InputError
from mpfcad.job import build_job
from mpfcad.measure import TraceRun, light_film, luminance_over_pitch
from mpfcad.pipeline.confidence.covariance import with_covariance
from mpfcad.pipeline.confidence.find import find_confidence
from mpfcad.pipeline.confidence.variant import Variants
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad

#: All but these are exact here.
WIDE = {"top_sheet_sigma": 0.35, "thickness_mm": 20.0}
EXACT = """
lamp_radius_mm lamp_height_mm lamp_reflectance reflector_reflectance plate_index
reflector_specular_fraction plate_thickness_mm bottom_sheet_sigma sheet_index
sheet_transmission film_index
""".split()  # noqa: SIM905


def job(tmp_path, **tables):
    from mpfcad.backlight import read_stack

    stack = read_stack("thesis-32in-mpf")
    override = {name: {"value": stack[name], "sigma": 0} for name in EXACT}
    override["lamp_pitch_mm"] = 8.0
    document = {
        "schema": 1,
        "name": "c",
        "map": {"rows": [[0.0, 64.0], [4.0, 52.0], [8.0, 64.0]]},
        "stack": {"preset": "thesis-32in-mpf", "override": override},
        **tables,
    }
    return build_job(document, str(tmp_path / "job.toml"))


@pytest.fixture
def made(tmp_path):
    def make(**tables):
        plan = read_plan(job(tmp_path, **tables), tmp_path / "job.toml")
        write_cad(plan, tmp_path, ("stl",), SILENT)
        return plan, Variants(plan, plan.stack, tmp_path, plan.job.confidence_table)

    return make


def test_only_inputs_that_change_the_scene_are_carried(made):
    _, variants = made(confidence={"base_um": 0.0})
    names = {factor.name for factor in variants.factors()}
    # A clear plate has no scattering; the meter and the panel are exact.
    assert names == {*WIDE, "resin_percent", "registration_mm", "depth_um"}
    assert variants.left_out() == []


def test_a_changed_film_has_that_much_more_resin(made):
    plan, variants = made()
    changed = variants._changed({"resin_percent": 10.0})
    assert changed.fill_fraction == pytest.approx(1.1 * plan.piece.fill_fraction, rel=1e-6)
    deeper = variants._changed({"depth_um": 1.0, "base_um": 5.0})
    assert deeper.thickness == pytest.approx(plan.piece.thickness + 0.006)
    assert deeper.fill_fraction == pytest.approx(plan.piece.fill_fraction, rel=1e-6)


def test_a_changed_film_is_made_once_and_few_are_kept(made, monkeypatch, tmp_path):
    from mpfcad.pipeline.confidence import variant

    _, variants = made()
    factor = {f.name: f for f in variants.factors()}
    monkeypatch.setattr(variant, "_FILMS", 2)

    def light(**steps):
        return variants.light({factor[name]: z for name, z in steps.items()})

    first = light(resin_percent=1.0, thickness_mm=1.0)
    again = light(resin_percent=1.0, thickness_mm=-1.0, registration_mm=1.0)
    other = light(resin_percent=-1.0)
    # The same film elsewhere, and another; each by what is in its file.
    assert again.elements[3].mesh is first.elements[3].mesh is not other.elements[3].mesh
    assert again.case["mesh"] == first.case["mesh"] != other.case["mesh"]
    assert again.elements[3].offset == pytest.approx(first.elements[3].offset + 0.3)
    light(depth_um=1.0)
    assert len(list(tmp_path.glob("changed-*.stl"))) == 2
    # What had to go is made again, the same.
    assert light(resin_percent=1.0).case["mesh"] == first.case["mesh"]


def test_a_film_of_cells_is_carried_without_its_making_and_that_is_said(made):
    _, variants = made(film={"cell": "pyramid"}, map={"curvature_per_mm": 60.0})
    assert [text.split(":")[0] for text in variants.left_out()] == [
        "resin_percent", "depth_um", "base_um",
    ]  # fmt: skip
    assert "resin_percent" not in {factor.name for factor in variants.factors()}


def test_confidence_is_found(made, tmp_path):
    plan, _ = made(confidence={"paths_million": 0.6, "depth_um": 0.0, "base_um": 0.0})
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    luminance = luminance_over_pitch(lit, TraceRun(seed=1), half_width_goal=0.02)
    found = find_confidence(tmp_path, plan, luminance, 2, SILENT)
    for name, limit in (("pass", 0.012), ("marginal", 0.018)):
        row = found["probability"][name]
        assert row["limit"] == limit
        assert 0 <= row["ci95"][0] <= row["value"] <= row["ci95"][1] <= 1
    assert found["probability"]["pass"]["value"] <= found["probability"]["marginal"]["value"]
    assert sum(row["share_of_variance"] for row in found["inputs"]) == pytest.approx(1)
    assert {row["name"] for row in found["inputs"]} == {*WIDE, "resin_percent", "registration_mm"}
    assert found["measure_next"] and found["left_out"] == []
    # Nothing is left beside the film.
    assert [path.name for path in tmp_path.glob("*.stl")] == ["film.stl"]


def test_a_finite_panel_is_refused(made, tmp_path):
    plan, _ = made()
    stack = replace(plan.stack, extent="panel")
    with pytest.raises(InputError, match=r'confidence: .* expected extent = "pitch"'):
        find_confidence(tmp_path, replace(plan, stack=stack), None, 1, SILENT)


def test_a_covariance_goes_into_the_job(tmp_path):
    (tmp_path / "c.csv").write_text("top_sheet_sigma,thickness_mm\n4e-4,1e-3\n1e-3,0.04\n")
    read = with_covariance(job(tmp_path, confidence={"covariance": "c.csv"}), tmp_path / "job.toml")
    assert read.confidence.covariance is None
    assert read.confidence.sigmas() == pytest.approx({"top_sheet_sigma": 0.02, "thickness_mm": 0.2})
    plan = read_plan(read, tmp_path / "job.toml")
    write_cad(plan, tmp_path, ("stl",), SILENT)
    factors = Variants(plan, plan.stack, tmp_path, read.confidence).factors()
    sizes = {factor.name: factor.sigma for factor in factors}
    assert sizes["thickness_mm"] == pytest.approx(0.2)


def test_a_covariance_of_no_input_is_refused(made):
    table = {"names": ["lamp_count"], "matrix": [[1.0]]}
    _, variants = made(confidence=table)
    with pytest.raises(InputError, match=r"covariance: lamp_count: expected inputs .*thickness_mm"):
        variants.factors()


def test_a_fits_covariance_may_name_what_this_scene_does_not_use(made):
    # A clear plate does not scatter; the fit saw a diffusing one too.
    names = ["thickness_mm", "plate_scattering_per_mm"]
    table = {"names": names, "matrix": [[0.04, 0.001], [0.001, 0.0025]]}
    _, variants = made(confidence=table)
    factors = {factor.name: factor.sigma for factor in variants.factors()}
    assert factors["thickness_mm"] == pytest.approx(0.2)
    assert "plate_scattering_per_mm" not in factors


def test_smooth_inputs_are_told_apart_from_geometry(made):
    from mpfcad.optics import sheet
    from mpfcad.optics.score.columns import Columns

    _, variants = made(stack={
        "preset": "thesis-32in-mpf", "override": {"sheet_transmission": 1.0, "lamp_pitch_mm": 8.0},
    })  # fmt: skip
    columns = Columns.of(variants.light({}).scene)
    found = {f.name: (f, variants.direction(f, columns)) for f in variants.factors()}
    smooth = {name for name, (_, row) in found.items() if row is not None}
    assert smooth == {
        "lamp_reflectance", "reflector_reflectance", "reflector_specular_fraction",
        "bottom_sheet_sigma", "top_sheet_sigma", "sheet_index", "sheet_transmission",
    }  # fmt: skip
    factor, row = found["top_sheet_sigma"]
    moved = np.flatnonzero(row)
    # A round lobe has two widths; the topmost element is the sheet.
    assert columns.place[moved].tolist() == [[4, sheet.SIGMA], [4, sheet.ACROSS]]
    assert row[moved] == pytest.approx(factor.sigma)
    # At the end of its range, too: a sheet passes no more than all.
    factor, row = found["sheet_transmission"]
    assert row[row != 0] == pytest.approx([factor.sigma] * 2)


def test_slopes_of_coefficients_are_those_of_finite_differences(made, tmp_path):
    from mpfcad.pipeline.confidence.runs import Runs, reading_of

    plan, variants = made()
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    luminance = luminance_over_pitch(lit, TraceRun(seed=1), half_width_goal=0.02)
    factors = [f for f in variants.factors() if f.name == "top_sheet_sigma"]
    runs = Runs(variants, factors, reading_of(luminance), 1, 2, SILENT)
    shape = (1, len(runs.reading.start))
    slope, covariance = np.zeros(shape), np.zeros((*shape, shape[1]))
    assert runs._smooth(slope, covariance, 0.6) == {0}
    (low, spread), (high, _) = (runs.trace(np.array([z]), 18) for z in (-1.5, 1.5))
    # Without what the common random numbers save: 2 (spread/3)².
    error = np.sqrt(np.diag(covariance[0]) + 2 * np.diag(spread) / 9)
    assert np.abs((slope[0] - (high - low) / 3) / error).max() < 4
    # And it tells what one sigma does, which is more than this.
    assert np.sqrt(covariance[0, 0, 0]) < 0.25 * abs(slope[0, 0])


@pytest.mark.slow
def test_confidence_is_the_same_again_at_any_number_of_threads(made, tmp_path):
    plan, _ = made(confidence={"paths_million": 0.6})
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    luminance = luminance_over_pitch(lit, TraceRun(seed=1), half_width_goal=0.02)
    one, two = (find_confidence(tmp_path, plan, luminance, n, SILENT) for n in (1, 2))
    assert one == two


@pytest.mark.slow
def test_harmonics_follow_full_traces_with_drawn_inputs(made, tmp_path):
    from mpfcad.pipeline.confidence.runs import Runs, reading_of

    plan, variants = made()
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    luminance = luminance_over_pitch(lit, TraceRun(seed=1, threads=2), half_width_goal=0.002)
    factors = variants.factors()
    runs = Runs(variants, factors, reading_of(luminance), 1, 2, SILENT)
    response = runs.respond(6.5).shrunk()
    steps = draw_steps(factors, np.eye(len(factors)), 9, 12)
    runs.seed = 2
    off = []
    for z in steps:
        found, spread = runs.trace(z, 48)
        told = response.start + z @ response.slope + z**2 @ response.bend
        off.append((found - told)[:2] / np.sqrt(np.diag(spread)[:2]))
    # Noise of both traces and what the model leaves out: within twice the noise of one.
    assert np.sqrt(np.mean(np.square(off))) < 2.0
