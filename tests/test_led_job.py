"""Jobs under LEDs: maps over a cell, on the panel and in files; masks; a run end to end."""

import json
from pathlib import Path

import numpy as np
import pytest

from mpfcad.errors import ExportError, InputError
from mpfcad.film import RepeatedField
from mpfcad.job import read_job
from mpfcad.optics.library.file import read_library
from mpfcad.pipeline import TRACE_SETTINGS, TraceSetting
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.file_check import examine_files
from mpfcad.pipeline.run.make import plan_mask, write_cad, write_curvature
from mpfcad.pipeline.run.run import make_mask, run_job
from mpfcad.pipeline.run.verify import verify_export

SERIES = "[map]\nseries_per_mm = [[60.0, 1.0], [1.5, 0.0]]\n"
STACK = (
    '[stack]\npreset = "mini-led-4mm"\n'
    "[stack.override]\npanel_width_mm = 9.0\npanel_length_mm = 13.0\n"
)


def write(folder: Path, body: str = SERIES + "[crossed]\n", more: str = "") -> Path:
    path = folder / "job.toml"
    path.write_text(f'name = "led"\n{body}{STACK}[cad]\npiece_mm = 0.25\n{more}')
    return path


def plan_of(path: Path):
    return read_plan(read_job(path), path)


def lopsided(folder: Path) -> str:
    """Write a map that is no mirror image of itself; return the job's tables."""
    x, y = np.linspace(0, 4, 41)[:-1], np.linspace(0, 4, 33)[:-1]
    wave = np.sin(2 * np.pi * x / 4)[None] + 0.5 * np.cos(2 * np.pi * (y[:, None] - 0.7) / 4)
    np.savez(
        folder / "cell.npz", position_across_mm=x, position_along_mm=y,
        curvature_per_mm=60 + 2 * wave,
    )  # fmt: skip
    return '[map]\nfile = "cell.npz"\nextent = "cell"\n[crossed]\n'


def test_a_cell_repeats_over_the_panel_bit_for_bit():
    rng = np.random.Generator(np.random.Philox(7))
    cell = 60 + rng.random((6, 4))
    field = RepeatedField(cell, 0.05, 0.5, 4, 1.3, 17, 9.7)
    rows = field.on_grooves(field.across)
    for groove in range(17):
        expected = cell[(groove - 4) % 6]
        assert set(rows[groove]) == set(expected)
    # A groove's piece begins at `start`; its middle is a node.
    assert np.array_equal(field.at(field.across[[4, 10]], 1.3 + 0.25), cell[[0, 0], 0])
    assert field.along[0] <= 0 and field.along[-1] >= 9.7
    low, high = field.extremes(field.across)
    assert np.array_equal(low, rows.min(axis=1)) and np.array_equal(high, rows.max(axis=1))


def test_the_panel_has_the_map_at_its_leds_and_the_crossed_film_at_the_same_place(tmp_path):
    plan = plan_of(write(tmp_path, lopsided(tmp_path)))
    across = plan.crossed
    assert across is not None and across.printed.width >= 13.0
    # The frame of the film across: its x is the panel's y, its y goes against the panel's x.
    x, y = (part.ravel() for part in np.meshgrid(np.linspace(1, 8, 29), np.linspace(1, 12, 37)))
    own = plan.printed.curvature_at(x, y)
    turned = across.printed.curvature_at(y, 9.0 - x)
    assert np.abs(own - turned).max() < 0.25  # a groove of one is a quarter of a piece of the other
    ox, oy = plan.stack.origin
    wave = np.sin(2 * np.pi * (x - ox) / 4) + 0.5 * np.cos(2 * np.pi * (y - oy - 0.7) / 4)
    assert np.abs(own - (60 + 2 * wave)).max() < 0.1


def test_what_is_traced_lies_as_the_panel_does(tmp_path):
    """The libraries, read back and laid as the tracer lays them, hold the map of the cell."""
    plan = plan_of(write(tmp_path, lopsided(tmp_path), "levels = 256\n"))
    write_cad(plan, tmp_path, ("3mf",), SILENT)
    u = (np.arange(16) + 0.5) / 4
    x, y = (part.ravel() for part in np.meshgrid(u, u, indexing="ij"))
    wanted = 60 + 2 * (np.sin(np.pi * x / 2) + 0.5 * np.cos(np.pi * (y - 0.7) / 2))
    for name, turned in (("film.3mf", False), ("film-crossed.3mf", True)):
        film = read_library(tmp_path / name)
        middle = np.array([np.interp(0.025, *section.T) for section in film.section])
        found = 2 * (film.high - middle[film.chosen]) / 0.025**2
        # Into the film's axes by 90° (optics/film/passage): x' = y, y' = -x.
        along = (y, -x) if turned else (x, y)
        i = np.floor(np.mod(along[0], 4) / 0.05).astype(int)
        k = np.floor(np.mod(along[1], 4) / 0.25).astype(int)
        means = [found[np.mod(i + step, 80), k] for step in range(-2, 3)]
        assert np.abs(np.mean(means, axis=0) - wanted).max() < 0.35


def test_masks_print_the_map_and_an_export_gives_the_plan_again(tmp_path):
    path = write(tmp_path, lopsided(tmp_path), "[mask]\nperiod_um = 500.0\n")
    out = tmp_path / "mask"
    screen = make_mask(read_job(path), path, out, ("oas",))
    names = {file.name for file in out.iterdir()}
    assert {"mask.oas", "mask-crossed.oas", "order-crossed.pdf", "curvature-crossed.npz"} <= names
    assert screen["printability"] == "phototool only" and "order" in screen["crossed"]
    plan = plan_of(path)
    for film in plan.films:
        mask = plan_mask(film)
        edge = np.arange(0.0, film.printed.length, 1.0)
        drawn = np.diff(mask.open_length(20, 8, edge), axis=1)
        y = (edge[:-1] + edge[1:]) / 2
        ratio = [
            film.process.aperture_ratio_of_curvature(
                film.printed.curvature_at(film.printed.groove_position[20 + i], y)
            )
            for i in range(8)
        ]
        assert np.abs(drawn - ratio).max() < 0.01
    write_curvature(plan, tmp_path)
    from mpfcad.pipeline.plan.restored import restore_plan, stored_job

    again = restore_plan(tmp_path, json.loads(json.dumps(stored_job(plan))))
    for film, same in zip(plan.films, again.films, strict=True):
        assert np.array_equal(film.drawn.chosen, same.drawn.chosen)
        assert all(map(np.array_equal, film.printed.content, same.printed.content))


def test_a_wrong_piece_in_the_file_fails_its_gate(tmp_path):
    plan = plan_of(write(tmp_path))
    other = plan_of(write(tmp_path, "[map]\ncurvature_per_mm = 61.0\n[crossed]\n"))
    write_cad(plan, tmp_path, ("3mf",), SILENT)
    found = [gate.outcome for gate in examine_files(tmp_path, plan, None, SILENT).gates]
    assert found == ["PASS"]
    found = examine_files(tmp_path, other, None, SILENT)
    (gate,) = found.gates
    assert gate.name == "library_as_written" and gate.outcome == "FAIL" and found.solid is None


BAD = [
    ("[map]\ncurvature_per_mm = 60\nextent = 'cell'\n", "expected map.file, an NPZ"),
    ("[map]\nseries_per_mm = [[60, 1], [1]]\n", "rows of one length"),
    ("[map]\nseries_per_mm = [[70, 20]]\n", "expected 0 … 80 /mm"),
    ("[map]\nrows = [[0, 60], [4, 60]]\nextent = 'panel'\n", "expected 'cell'"),
    (SERIES + "[film]\npitch_um = 47\n", "expected a whole number of grooves"),
    (SERIES + "[film]\nprofile = 'ideal'\n", "expected profile 'filled'"),
    (SERIES + "[crossed]\nrows = [[0, 60], [4, 60]]\ncurvature_per_mm = 60\n", "exactly one of"),
]


@pytest.mark.parametrize(("body", "match"), BAD)
def test_a_wrong_job_is_refused_in_a_line(tmp_path, body, match):
    with pytest.raises(InputError, match=match):
        plan_of(write(tmp_path, body))


def test_what_is_for_leds_is_refused_under_tubes_and_without_a_film_across(tmp_path):
    path = tmp_path / "tube.toml"
    path.write_text(f'name = "t"\n{SERIES}')
    with pytest.raises(InputError, match="tubes light the stack"):
        plan_of(path)
    own = 'extends = "mini-led-4mm"\nlayers = ["clear_plate", "film", "top_sheet"]\n'
    (tmp_path / "own.toml").write_text(own)
    path.write_text(f'name = "t"\n{SERIES}[crossed]\n[stack]\nfile = "own.toml"\n')
    with pytest.raises(InputError, match="expected a layer of kind bef with rotation_deg 90"):
        plan_of(path)
    override = "[stack.override]\npanel_width_mm = 4.0\n"
    path.write_text(f'name = "t"\n{SERIES}[stack]\npreset = "mini-led-4mm"\n{override}')
    with pytest.raises(InputError, match="expected a panel that holds two cells"):
        plan_of(path)


CELLS = "[map]\ncurvature_per_mm = 40.0\n[film]\ncell = '{}'\nprofile = '{}'\n"


@pytest.mark.parametrize(
    ("cell", "profile"),
    [("pyramid", "filled"), ("pyramid", "ideal"), ("paraboloid", "ideal")],
)
def test_equal_cells_are_a_square_that_repeats(tmp_path, cell, profile):
    plan = plan_of(write(tmp_path, CELLS.format(cell, profile)))
    assert plan.drawn.count == (4, 4) and plan.process is None and plan.offset == 0
    write_cad(plan, tmp_path, ("step", "stl"), SILENT)
    found = examine_files(tmp_path, plan, None, SILENT)
    assert {gate.outcome for gate in found.gates} == {"PASS"}
    # 25 µm deep over w = 25 µm: of pyramids 1/3 is left, and what C = 40 /mm fills is z = C t²/2.
    mean = plan.drawn.mean_height - plan.drawn.base
    t = (np.arange(20_000) + 0.5) / 20_000
    if cell == "pyramid":
        profile_height = 20.0 * (t * 0.025) ** 2 + 0.025 - 20.0 * 0.025**2
        if profile == "filled":
            profile_height = np.maximum(profile_height, 0.025 * t)
        assert mean == pytest.approx(np.mean(2 * (1 - t) * profile_height), rel=1e-6)
    else:
        assert mean == pytest.approx(0.025 - 2 / 3 * 40 * 0.025**2, rel=1e-9)


BAD_CELLS = [
    (CELLS.format("pyramid", "filled") + "[crossed]\n", "crossed: film.cell pyramid"),
    (CELLS.format("paraboloid", "filled"), "expected 'ideal', a mould's"),
    (CELLS.format("pyramid", "ideal").replace("40.0", "2000.0"), "C.*2000|curvature.*2000"),
    (SERIES + "[film]\ncell = 'pyramid'\n", "cad.piece_mm: 0.25: expected to be left out"),
]


@pytest.mark.parametrize(("body", "match"), BAD_CELLS)
def test_cells_that_cannot_be_are_refused_in_a_line(tmp_path, body, match):
    with pytest.raises(InputError, match=match):
        plan_of(write(tmp_path, body))


@pytest.mark.slow
def test_a_run_of_pyramids_is_verified(tmp_path, quick):
    path = write(tmp_path, CELLS.format("pyramid", "filled"))
    record = run_job(read_job(path), path, tmp_path / "out", effort="quick")
    assert record["provenance"]["traced"]["file"] == "film.stl" and record["mask"] is None
    assert "crossed" not in record and len(record["cell"]["luminance_cd_m2"]) == 24
    assert verify_export(tmp_path / "out") == record


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(0.004, 20_000))


@pytest.mark.slow
def test_a_run_is_verified_and_a_wrong_piece_is_found(tmp_path, quick):
    path = write(tmp_path, SERIES + "[crossed]\n", '[mask]\nperiod_um = 500.0\nformats = ["oas"]\n')
    out = tmp_path / "out"
    record = run_job(read_job(path), path, out, effort="quick")
    outcome = {gate["name"]: gate["outcome"] for gate in record["gates"]}
    assert {name for name, one in outcome.items() if one != "PASS"} == {"lamp_mura_contrast"}
    assert record["luminance"] is None and len(record["cell"]["luminance_cd_m2"]) == 24
    assert record["visibility"]["over_threshold"]["value"] > 0
    assert record["provenance"]["traced"]["file"] == "film.3mf"
    assert {"film-crossed.3mf", "mask-crossed.oas"} <= set(record["provenance"]["sha256"])
    page = (out / "report.html").read_text()
    assert "Seen from straight above" in page and "mask-crossed.png" in page
    assert verify_export(out) == record
    film = (out / "film-crossed.3mf").read_bytes()
    (out / "film-crossed.3mf").write_bytes(film[:-1] + bytes([film[-1] ^ 1]))
    with pytest.raises(ExportError, match=r"film-crossed\.3mf"):
        verify_export(out)
