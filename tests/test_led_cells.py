"""Jobs of patterned pyramids and dishes under LEDs: their files, their masks by volume, a run."""

import numpy as np
import pytest
from test_led_job import STACK, plan_of, quick  # noqa: F401

from mpfcad.errors import ExportError, InputError
from mpfcad.film import CellFilm, Groove, PyramidGroove
from mpfcad.job import read_job
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.printed.order import phototool
from mpfcad.pipeline.plan.restored import restore_plan, stored_job
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.examine import compare_curvature, compare_resin
from mpfcad.pipeline.run.file_check import examine_files
from mpfcad.pipeline.run.make import (
    check_cad,
    plan_mask,
    write_cad,
    write_curvature,
    write_masks,
)
from mpfcad.pipeline.run.run import run_job
from mpfcad.pipeline.run.verify import verify_export

MAP = "[map]\nseries_per_mm = [[60.0, 3.0], [2.0, 0.0]]\n"


def write(folder, shape="pyramid", profile="filled", more=""):
    film = f'[film]\ncell = "{shape}"\nprofile = "{profile}"\n'
    cad = "[cad]\nangle_tolerance_deg = 4.0\nlength_mm = 0.3\nlevels = 6\n"
    path = folder / "job.toml"
    path.write_text(f'name = "led"\n{MAP}{film}{STACK}{cad}{more}')
    return path


@pytest.mark.parametrize("curvature", [0.0, 12.0, 40.0, 63.0, 79.9, 80.0])
def test_resin_between_pyramids_is_their_volume(curvature):
    groove = PyramidGroove(0.05, 0.025)
    film = CellFilm(groove, 0.2, "pyramid", "filled", curvature, (1, 1))
    fill = (film.mean_height - film.bare_height) / groove.room
    assert float(groove.fill_fraction(curvature)) == pytest.approx(fill, abs=1e-14)
    assert float(groove.curvature_of_fill(fill)) == pytest.approx(curvature, abs=1e-9)
    place = (np.arange(400) + 0.5) / 400 * 0.05
    mean = film.height(*np.meshgrid(place, place)).mean()
    assert film.mean_height == pytest.approx(mean, abs=3e-7)


@pytest.mark.parametrize(
    ("profile", "along"), [("filled", 45.0), ("filled", 80.0), ("ideal", 20.0)]
)
def test_the_mean_height_of_two_curvatures(profile, along):
    film = CellFilm(Groove(0.05, 0.025), 0.2, "pyramid", profile, 70.0, (1, 1), along)
    place = (np.arange(600) + 0.5) / 600 * 0.05
    mean = film.height(*np.meshgrid(place, place)).mean()
    assert film.mean_height == pytest.approx(mean, abs=3e-7)


@pytest.mark.parametrize(
    ("shape", "profile"), [("pyramid", "filled"), ("pyramid", "ideal"), ("paraboloid", "ideal")]
)
def test_every_file_reads_back(tmp_path, shape, profile):
    plan = plan_of(write(tmp_path, shape, profile))
    assert plan.drawn.chosen.shape == (80, 80)
    files = ("3mf", "step", "stl", "csv")
    assert {*files, "tif", "dat"} <= set(kind_of(plan.drawn, plan.job.cad).formats)
    write_cad(plan, tmp_path, files, SILENT)
    gates = [gate for check in check_cad(plan, tmp_path, files, SILENT) for gate in check.gates]
    assert {gate.outcome for gate in gates} == {"PASS"}
    first = {name: (tmp_path / f"film.{name}").read_bytes() for name in files}
    write_cad(plan, tmp_path, files, SILENT)
    assert first == {name: (tmp_path / f"film.{name}").read_bytes() for name in files}


def test_another_cell_is_found_in_every_file(tmp_path):
    plan = plan_of(write(tmp_path))
    files = ("3mf", "step", "stl", "csv")
    write_cad(plan, tmp_path, files, SILENT)
    path = tmp_path / "job.toml"
    path.write_text(path.read_text().replace("[60.0, 3.0]", "[61.0, -3.0]"))
    kind = kind_of(plan_of(path).drawn, plan.job.cad)
    for name in ("3mf", "csv"):
        with pytest.raises(ExportError):
            kind.check(tmp_path / f"film.{name}")
    with pytest.raises(ExportError, match="bodies"):
        kind.check(tmp_path / "film.step")
    lines = (tmp_path / "film.csv").read_text().splitlines()
    lines[7] = lines[7].replace("0,1,0,0,0,1,0,1,", "0,0,1,0,0,1,0,1,")
    (tmp_path / "film.csv").write_text("\n".join(lines))
    with pytest.raises(ExportError, match="line 8"):
        kind_of(plan.drawn, plan.job.cad).check(tmp_path / "film.csv")


def test_the_mask_prints_the_volume_that_the_file_holds(tmp_path):
    more = '[process]\nsolids_fraction = 0.3\n[mask]\nmesh = "120-40"\nperiod_um = 320.0\n'
    plan = plan_of(write(tmp_path, more=more + 'formats = ["oas"]\n'))
    groove = plan.process.groove
    assert isinstance(groove, PyramidGroove) and groove.room == pytest.approx(0.05 / 3)
    write_cad(plan, tmp_path, ("3mf",), SILENT)
    mask = plan_mask(plan)
    write_masks(mask, phototool(plan.job, mask, plan.process), tmp_path, ["mask.oas"], SILENT)
    found = examine_files(tmp_path, plan, mask, SILENT)
    assert {gate.outcome for gate in found.gates} == {"PASS"}
    assert compare_curvature(plan, found.mask, found.solid, mask.wanted_ratio) < 0.5
    resin = compare_resin(plan, found.mask, found.solid, mask.wanted_ratio)
    (by_mask,) = resin.by_mask.values()
    # The closed form of the map: what the process gives, over the area of the cell.
    fill = float(np.mean(groove.fill_fraction(plan.drawn.wanted[..., 0])))
    assert by_mask == pytest.approx(fill * groove.room * 16.0, rel=0.005)
    assert resin.in_mesh == pytest.approx(by_mask, rel=0.01)  # facets of 4°


def test_an_export_gives_the_plan_again(tmp_path):
    plan = plan_of(write(tmp_path))
    write_curvature(plan, tmp_path)
    again = restore_plan(tmp_path, stored_job(plan))
    assert np.array_equal(plan.drawn.chosen, again.drawn.chosen)
    assert again.process.groove == plan.process.groove


@pytest.mark.parametrize(
    ("shape", "profile", "more", "match"),
    [
        ("pyramid", "filled", "[crossed]\n", "cells are patterned both ways"),
        ("paraboloid", "filled", "", "expected 'ideal', a mould's"),
        ("pyramid", "filled", "[confidence]\n", "confidence"),
    ],
)
def test_jobs_that_cannot_be_are_refused_in_a_line(tmp_path, shape, profile, more, match):
    with pytest.raises(InputError, match=match):
        plan_of(write(tmp_path, shape, profile, more))


TWO = "[map]\nseries_per_mm = [[20.0, 3.0]]\nseries_along_per_mm = [[12.0], [2.0]]\n"


def write_two(folder, table=TWO, shape="paraboloid", profile="ideal", more=""):
    path = write(folder, shape, profile, more)
    path.write_text(path.read_text().replace(MAP, table))
    return path


@pytest.mark.parametrize("shape", ["paraboloid", "pyramid"])
def test_cells_of_two_curvatures_read_back(tmp_path, shape):
    plan = plan_of(write_two(tmp_path, shape=shape))
    wanted, half = plan.drawn.wanted, np.pi / 80
    # An LED at the corner: along x the first map has its cosine along y, the second along x.
    assert wanted[:, 0, 0] == pytest.approx(np.full(80, 20 + 3 * np.cos(half)))
    assert wanted[0, :, 1] == pytest.approx(np.full(80, 12 + 2 * np.cos(half)))
    assert len(np.unique(plan.drawn.chosen)) > 12
    files = ("3mf", "step", "stl", "csv") if shape == "paraboloid" else ("3mf", "stl", "csv")
    write_cad(plan, tmp_path, files, SILENT)
    checks = check_cad(plan, tmp_path, files, SILENT)
    assert {gate.outcome for check in checks for gate in check.gates} <= {"PASS"}
    solid = examine_files(tmp_path, plan, None, SILENT).solid
    assert solid.curvature.shape == (80, 80, 2)
    assert compare_curvature(plan, {}, solid, None) < 0.1
    found = kind_of(plan.drawn, plan.job.cad)
    assert found.curvature_difference(solid.curvature + np.array([0.0, 0.3]), None, None) > 0.2
    write_curvature(plan, tmp_path)
    again = restore_plan(tmp_path, stored_job(plan))
    assert np.array_equal(plan.drawn.wanted, again.drawn.wanted)


def test_a_file_and_constants_hold_two_curvatures(tmp_path):
    path = write_two(tmp_path, "[map]\ncurvature_per_mm = 20.0\ncurvature_along_per_mm = 9.0\n")
    plan = plan_of(path)
    assert plan.drawn.curvature.tolist() == [[20.0, 9.0]]
    place = np.linspace(0.0, 4.0, 9)
    along = 10 + place[:, None] / 8 + np.zeros(9)
    np.savez(
        tmp_path / "map.npz", position_across_mm=place, position_along_mm=place,
        curvature_per_mm=np.full((9, 9), 20.0), curvature_along_per_mm=along,
    )  # fmt: skip
    table = '[map]\nfile = "map.npz"\nextent = "cell"\n'
    plan = plan_of(write_two(tmp_path, table))
    assert np.ptp(plan.drawn.wanted[..., 0]) == 0 and np.ptp(plan.drawn.wanted[0, :, 1]) > 0.3


@pytest.mark.parametrize(
    ("table", "shape", "profile", "words"),
    [
        (TWO, "pyramid", "filled", "a mould's"),
        (TWO, "groove", "filled", "a mould's"),
        (TWO.replace("[[20.0, 3.0]]", "[[20.0]]\ncurvature_per_mm = 3.0"), "paraboloid", "ideal",
         "exactly one"),
        ("[map]\nseries_along_per_mm = [[2.0]]\ncurvature_per_mm = 3.0\n", "paraboloid", "ideal",
         "both constants, or both series"),
        (TWO.replace("12.0", "-9.0"), "paraboloid", "ideal", "over the cell: expected 0"),
        (TWO.replace("12.0", "900.0"), "paraboloid", "ideal", "through the underside"),
    ],
)  # fmt: skip
def test_two_curvatures_that_cannot_be_are_refused(tmp_path, table, shape, profile, words):
    with pytest.raises(InputError, match=words):
        plan_of(write_two(tmp_path, table, shape, profile))


@pytest.mark.slow
def test_a_run_of_patterned_pyramids_is_verified(tmp_path, quick):  # noqa: F811
    path = write(tmp_path, more='[mask]\nperiod_um = 500.0\nformats = ["oas"]\n')
    record = run_job(read_job(path), path, tmp_path / "out", effort="quick")
    outcome = {gate["name"]: gate["outcome"] for gate in record["gates"]}
    assert outcome["library_as_written"] == "PASS" and outcome["mask_file_as_written"] == "PASS"
    assert record["accelerator"].endswith("cells") and record["resin"] is not None
    assert verify_export(tmp_path / "out") == record


@pytest.mark.slow
def test_a_run_of_dishes_of_two_curvatures_is_verified(tmp_path, quick):  # noqa: F811
    path = write_two(tmp_path)
    record = run_job(read_job(path), path, tmp_path / "out", effort="quick")
    outcome = {gate["name"]: gate["outcome"] for gate in record["gates"]}
    assert outcome["library_as_written"] == "PASS" and outcome["energy_lost"] == "PASS"
    assert outcome["mask_mesh_curvature_difference_per_mm"] == "PASS"
    assert record["accelerator"].endswith("cells") and record["mask"] is None
    assert "along y" in (tmp_path / "out" / "report.html").read_text()
    assert verify_export(tmp_path / "out") == record
