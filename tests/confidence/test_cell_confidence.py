"""The confidence of a job under LEDs: its inputs, prints that move, what each may move, a run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from harness import film_file, groove
from led_job import ORDER, flat, plan_of

from mpfcad.backlight import Quantity
from mpfcad.errors import InputError
from mpfcad.job import read_job
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting
from mpfcad.pipeline.confidence import cell_runs
from mpfcad.pipeline.confidence.asked import refuse_unlikely
from mpfcad.pipeline.confidence.cell_runs import CellRuns
from mpfcad.pipeline.confidence.cell_variant import MOVES, CellVariants, cell_variants_of
from mpfcad.pipeline.confidence.find import find_confidence
from mpfcad.pipeline.plan.departure import Departure, PrintError
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad
from mpfcad.pipeline.run.run import run_job
from mpfcad.pipeline.run.stack_mesh import write_stack_meshes
from mpfcad.pipeline.run.verify import verify_export


@pytest.fixture
def made(tmp_path):
    """Give the scenes of a job whose films are written."""

    def make(deviation=0.1, **tables):
        plan = plan_of(tmp_path, deviation, **tables)
        write_cad(plan, tmp_path, ("3mf",), SILENT)
        with cell_variants_of(plan, tmp_path) as variants:
            return variants

    return make


def names(variants):
    return {factor.name for factor in variants.factors()}


def test_inputs_are_what_changes_the_scene(made):
    found = names(made())
    assert {"led_half_angle_deg", "led_width_mm", "led_reflectance", "thickness_mm"} <= found
    assert {"resin_percent", *MOVES, "crossed_film.index", "top_sheet_sigma"} <= found
    # There is no hole, no cup, no lens, and the plate is clear.
    wrong = ("led_hole_", "led_cup_", "led_peak_", "plate_scattering", "led_flux", "led_pitch")
    assert not [name for name in found if name.startswith(wrong)]


def test_what_is_not_carried_is_said(made):
    variants = made(stack={
        "preset": "mini-led-4mm", "override": {"led_flux_spread": 0.05},
    })  # fmt: skip
    assert [text.split(":")[0] for text in variants.left_out()] == [
        "depth_um", "base_um", "led_flux_spread",
    ]  # fmt: skip


def test_a_print_without_a_pattern_along_an_axis_is_not_moved_along_it(made):
    found = names(made(map={"rows": [[0.0, 60.0], [2.0, 58.0], [4.0, 60.0]]}, crossed={}))
    assert {"registration_x_mm", "crossed_registration_x_mm"} <= found
    assert not {"registration_y_mm", "crossed_registration_y_mm"} & found
    assert not set(MOVES) & names(made(map={"curvature_per_mm": 60.0}))


def test_resin_of_a_process_without_width_is_assumed(made):
    variants = made(None, confidence={"resin_percent": 4.0})
    (factor,) = [f for f in variants.factors() if f.name == "resin_percent"]
    assert factor.sigma == 4.0 and factor.low == -100 and "assumed" in factor.source
    (library, _) = variants.resin.films
    more = variants.resin.changed(library, {"resin_percent": 4.0})
    assert more.fill_fraction == pytest.approx(1.04 * library.fill_fraction, rel=2e-3)


@pytest.mark.parametrize("name", MOVES)
def test_a_moved_print_is_that_of_a_moved_map(made, tmp_path, name):
    """By a whole piece: the pieces that are traced stand where those of a moved map do."""
    lopsided(tmp_path)
    tables = {"map": {"file": "cell.npz", "extent": "cell"}, "crossed": {}}
    variants, move = made(**tables), MOVES[name]
    own = variants.plan.films[move.film].drawn
    by = own.size[move.along] / own.chosen.shape[move.along]
    errors = [PrintError(), PrintError()]
    errors[move.film] = PrintError(shift=(by, 0.0) if move.axis == 0 else (0.0, by))
    moved = plan_of(tmp_path, 0.1, Departure(tuple(errors)), **tables).films[move.film].drawn
    assert np.allclose(np.roll(own.wanted, move.sign, move.along), moved.wanted, atol=1e-9)
    assert np.ptp(own.wanted) > 1

    (factor,) = [f for f in variants.factors() if f.name == name]
    still, lit = (
        [one.library for one in variants.light({factor: z}).elements if hasattr(one, "library")]
        for z in (0.0, by / factor.sigma)
    )
    rolled = np.roll(still[move.film].chosen, move.sign, move.along)
    assert np.array_equal(lit[move.film].chosen, rolled)
    assert lit[1 - move.film] is still[1 - move.film]
    # A run moves it by whole pieces, about one and a half sigma.
    pieces = variants.reach(factor) * factor.sigma / by
    assert pieces == pytest.approx(max(1, round(1.5 * 0.3 / by)))


def lopsided(folder):
    """Write a map that is no mirror image of itself."""
    x, y = np.linspace(0, 4, 41)[:-1], np.linspace(0, 4, 33)[:-1]
    wave = np.sin(2 * np.pi * x / 4)[None] + 0.5 * np.cos(2 * np.pi * (y[:, None] - 0.7) / 4)
    np.savez(
        folder / "cell.npz", position_across_mm=x, position_along_mm=y,
        curvature_per_mm=60 + 2 * wave,
    )  # fmt: skip


@pytest.fixture
def told(monkeypatch):
    """Have the terms of a run told: each follows inputs as it likes, sines among them."""
    rng = np.random.default_rng(4)
    slope, bend = {}, {}

    def trace(lit, order, paths, seed, threads, estimator):
        value = np.zeros(len(order))
        for factor, z in lit.items():
            if factor.name not in slope:
                slope[factor.name] = rng.normal(size=(6, 6))
                bend[factor.name] = factor.is_curved * rng.normal(size=(6, 6))
            part = z * slope[factor.name] + z * z * bend[factor.name]
            value += part[tuple(np.asarray(order).T)]
        value = 0.1 * value
        value[0] = 100.0
        return value, np.eye(len(order)) * 1e-10, 1000

    monkeypatch.setattr(cell_runs, "trace_terms", trace)
    monkeypatch.setattr(CellVariants, "light", lambda variants, steps: dict(steps))
    return slope, bend


def test_a_mirrored_cell_moves_cosines_alone_but_for_prints_that_move(made, told):
    variants = made()
    factors = variants.factors()
    runs = CellRuns(variants, factors, flat(), 1, 1, SILENT)
    assert np.array_equal(runs.order[: len(ORDER)], ORDER) and len(runs.order) == 9 + 12
    response = runs.respond(0.1)
    slope, bend = told
    order = runs.order[1:]
    even = (order % 2 == 1) | (order == 0)
    for number, factor in enumerate(factors):
        expected = 1e-3 * slope[factor.name][tuple(order.T)]
        kept = even.all(axis=1)
        if factor.name in MOVES:
            axis = MOVES[factor.name].axis
            kept = ~even[:, axis] & even[:, 1 - axis]
            assert kept.sum() == 6
        assert np.allclose(response.slope[number], np.where(kept, expected, 0), atol=2e-7)
        if factor.is_curved:
            expected = 1e-3 * bend[factor.name][tuple(order.T)]
            kept = even.all(axis=1)
            assert np.allclose(response.bend[number], np.where(kept, expected, 0), atol=2e-7)
        else:
            assert not response.bend[number].any()


def test_a_cell_that_is_not_mirrored_moves_all_its_terms(made, told):
    variants = made()
    factors = [f for f in variants.factors() if f.name in ("thickness_mm", "registration_x_mm")]
    found = replace(flat(), is_mirrored=False)
    runs = CellRuns(variants, factors, found, 1, 1, SILENT)
    assert np.array_equal(runs.order, ORDER)
    assert (runs.respond(0.1).slope != 0).all()


def test_the_record_is_that_of_tubes(made, told, tmp_path):
    variants = made(confidence={"paths_million": 0.1})
    found = find_confidence(tmp_path, variants.plan, flat(), 1, SILENT)
    assert {"probability", "contrast", "inputs", "measure_next", "left_out"} <= set(found)
    assert sum(one["share_of_variance"] for one in found["inputs"]) == pytest.approx(1)
    low, high = found["probability"]["marginal"]["ci95"]
    assert 0 <= low <= found["probability"]["marginal"]["value"] <= high <= 1
    named = {name for row in found["measure_next"] for name in row["inputs"]}
    assert {"registration_x_mm", "led_half_angle_deg", "led_reflectance"} <= named


def test_cups_that_touch_are_left_out(made, tmp_path):
    (tmp_path / "cups.toml").write_text(
        'extends = "mini-led-4mm"\n[source]\nkind = "leds"\ncup = "square"\n[value]\n'
        "led_cup_height_mm = 0.5\nled_cup_radius_mm = 1.0\nled_cup_rim_radius_mm = 2.0\n"
    )
    variants = made(stack={"file": "cups.toml"})
    assert {"led_cup_radius_mm", "led_cup_height_mm", "led_cup_reflectance"} <= names(variants)
    assert "led_cup_rim_radius_mm" not in names(variants)
    assert "led_cup_rim_radius_mm: changed so far, it would meet what is next to it" in (
        variants.left_out()
    )


def test_films_with_other_resin_stand_among_the_stacks_own_meshes(made, tmp_path):
    film_file(tmp_path / "lid.stl", [groove(60.0)] * 4, base=0.2)
    (tmp_path / "own.toml").write_text(
        'extends = "mini-led-4mm"\nlayers = ["clear_plate", "bottom_sheet", '
        '{kind = "film", name = "lid", file = "lid.stl"}, "film", '
        '{kind = "bef", name = "crossed_film", rotation_deg = 90}, "top_sheet"]\n'
    )
    plan = plan_of(tmp_path, 0.1, stack={"file": "own.toml"})
    export = tmp_path / "export"
    export.mkdir()
    write_stack_meshes(plan, export, SILENT)
    write_cad(plan, export, ("3mf",), SILENT)
    with cell_variants_of(plan, export) as variants:
        (factor,) = variants.print_factors()
        stated, more = (variants.light({factor: z}).stack.own for z in (0.0, 1.0))
        assert Path(more["lid"].file) == Path(stated["lid"].file) == export / "stack-lid.stl"
        assert Path(stated["crossed_film"].file) == export / "film-crossed.3mf"
        assert Path(more["crossed_film"].file).is_file() and more != stated


def test_a_confidence_that_is_not_found_is_refused_before_work(tmp_path):
    wide = plan_of(tmp_path, confidence={"registration_mm": 0.6})
    with pytest.raises(InputError, match=r"j.toml: .*registration_mm: 0.6: expected at most an ei"):
        refuse_unlikely("j.toml", wide)
    plan = plan_of(tmp_path, confidence={"names": ["registration_mm"], "matrix": [[1.0]]})
    with pytest.raises(InputError, match=r"covariance: registration_mm: .*registration_x_mm"):
        refuse_unlikely("j.toml", plan)
    with pytest.raises(
        InputError, match=r"confidence: film\.cell pyramid: under LEDs is for films"
    ):
        plan_of(
            tmp_path, confidence={}, film={"cell": "pyramid"}, map={"curvature_per_mm": 40.0},
            crossed=None,
        )  # fmt: skip
    stack = replace(plan.stack, quantity={
        **plan.stack.quantity, "thickness_mm": Quantity(1.4, "given", "x", 0.1)
    })  # fmt: skip
    refuse_unlikely("j.toml", replace(plan_of(tmp_path, confidence={}), stack=stack))


@pytest.mark.slow
def test_a_run_says_how_likely_it_holds_and_is_verified(tmp_path, monkeypatch):
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(0.02, 200_000))
    path = tmp_path / "job.toml"
    path.write_text(
        'name = "led"\n[map]\nseries_per_mm = [[60.0, 1.0], [1.5, 0.0]]\n[crossed]\n'
        '[stack]\npreset = "mini-led-4mm"\n[stack.override]\npanel_width_mm = 9.0\n'
        "panel_length_mm = 13.0\n[mask]\nperiod_um = 500.0\nformats = ['oas']\n"
        "[confidence]\npaths_million = 0.1\n[gates]\nconfidence_min = 0.9\n"
    )
    record = run_job(read_job(path), path, tmp_path / "out", effort="quick")
    found = record["confidence"]
    assert "printed" not in record and found["paths"] > 1e5
    assert {*MOVES, "resin_percent", "led_half_angle_deg"} <= {i["name"] for i in found["inputs"]}
    gates = {gate["name"]: gate for gate in record["gates"]}
    assert gates["confidence"]["value"] == found["probability"]["marginal"]["value"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "crossed_registration_y_mm" in page and "Not asked for" not in page
    assert verify_export(tmp_path / "out", threads=2) == record
