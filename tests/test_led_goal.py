"""The thinnest, sparsest or fewest-LED board: ranges, proposals, and whether a screen prints it."""

import json

import numpy as np
import pytest
from test_led_design import Model

from mpfcad.errors import InputError
from mpfcad.export import canonical_json
from mpfcad.film import CurvatureSeries
from mpfcad.job.led_design import read_led_design
from mpfcad.pipeline.led.design import read_led_stack, run_led_design
from mpfcad.pipeline.led.goal import GoalSearch, boards_of
from mpfcad.pipeline.led.job import job_tables
from mpfcad.pipeline.led.screen import describe_screen, find_screen, printed_tables
from mpfcad.pipeline.led.search import LedSearch
from mpfcad.pipeline.led.tried import Tried
from mpfcad.report.page.led_page import range_lines, write_led_page


def design(tmp_path, text="", aim="thinnest", ends="min = 3.0\nmax = 6.0\nstep = 0.5\n"):
    path = tmp_path / "design.toml"
    path.write_text(
        'schema = 1\nkind = "leds"\nname = "d"\n[stack]\npreset = "led-automotive-6mm"\n'
        f'[goal]\naim = "{aim}"\ncontrast_target = 0.018\n[range]\n{ends}{text}'
    )
    return read_led_design(path)


def boards(tmp_path, **options):
    return boards_of(design(tmp_path, **options), "design.toml", (109.5, 292.0))


def test_the_boards_of_a_range_come_easiest_first(tmp_path):
    found = boards(tmp_path)
    assert [board.value for board in found] == [6.0, 5.5, 5.0, 4.5, 4.0, 3.5, 3.0]
    file = tmp_path / "design.toml"
    assert [read_led_stack(b.design, file).thickness for b in found][-1] == 3.0
    found = boards(tmp_path, aim="sparsest", ends="min = 10.0\nmax = 20.0\nstep = 4.0\n")
    assert [board.value for board in found] == [10.0, 14.0, 18.0, 20.0]
    assert tuple(read_led_stack(found[-1].design, file).source.cell) == (20.0, 20.0)
    found = boards(tmp_path, aim="fewest", ends="min = 5\nmax = 9\nstep = 2\n")
    assert [board.value for board in found] == [9.0, 7.0, 5.0]
    source = read_led_stack(found[-1].design, file).source
    assert source.cells == (5, 13) and source.cell.across == pytest.approx(21.9)
    with pytest.raises(InputError, match="whole grooves"):
        boards(tmp_path, aim="sparsest", ends="min = 10.03\nmax = 20.0\nstep = 4.0\n")


@pytest.mark.parametrize(
    ("aim", "ends", "words"),
    [
        ("contrast", "min = 3\nmax = 4\n", "expected .range. with min"),
        ("fewest", "min = 3\nmax = 4.5\n", "expected whole numbers"),
        ("thinnest", "min = 5\nmax = 4\n", "expected above 5"),
        ("thinnest", "min = 1\nmax = 900\n", "at most 100 steps"),
    ],
)
def test_ranges_that_cannot_be_are_refused(tmp_path, aim, ends, words):
    with pytest.raises(InputError, match=words):
        design(tmp_path, aim=aim, ends=ends)


@pytest.mark.parametrize("limit", [3.0, 3.9, 4.6, 6.4])
def test_the_hardest_board_that_serves_is_found_with_few_searches(tmp_path, monkeypatch, limit):
    """Boards whose light no film levels below the limit's thickness."""
    found = boards(tmp_path, ends="min = 3.0\nmax = 6.0\nstep = 0.25\n")

    def search_of(board):
        thickness = read_led_stack(board.design, tmp_path / "design.toml").thickness
        bare = np.array([[0.0, 0.1, 0.0], [0.1, 0.0, 0.0], [0.0, 0.0, 0.0]]) * (limit / thickness)
        answer, search = Model(bare), LedSearch(board.design, None)

        def attempt(coefficient):
            chosen = CurvatureSeries(coefficient)

            class Found:
                class contrast:
                    value = 0.017 if thickness >= limit and coefficient[1:].any() else 0.05
                    low, high = value - 0.004, value + 0.004

            harmonic = answer(chosen)
            search.tried.append(Tried(chosen, Found(), harmonic, 0 * harmonic))
            return search.tried[-1]

        monkeypatch.setattr(search, "_try", attempt)
        return search

    goal = GoalSearch(found, search_of, 0.018)
    chosen = goal.run()
    values = [board.value for board in found]
    serving = [value for value in values if value >= limit]
    assert goal.serves == bool(serving)
    assert values[chosen] == (min(serving) if serving else 6.0)
    assert len(goal.searched) <= 6
    record = goal.describe(chosen, "thinnest")
    (line,) = range_lines(record)
    assert ("no thickness" in line) == (not serving)


def test_a_screen_is_found_by_its_solids(tmp_path):
    limits = "[constraint]\nsolids_fraction_min = 0.02\nsolids_fraction_max = 0.3\n"
    one = design(tmp_path, limits + '[mask]\nmesh = "150-31"\n')
    file = tmp_path / "design.toml"
    tables = job_tables(one, CurvatureSeries(np.array([[73.0, 2.0], [1.0, 0.0]])))
    best = find_screen(one, file, tables, np.array([70.0, 76.0]))
    assert best is not None and best.margin >= 1 and 0.02 <= best.solids_fraction <= 0.3
    assert describe_screen(one, best)["prints"]
    canonical_json(describe_screen(one, best))  # every number is one
    printed = printed_tables(one, tables, best)
    assert printed["process"]["solids_fraction"] == best.solids_fraction
    assert printed["mask"]["mesh"] == {"name": "150-31"}
    # From 0.1 to 16 % of the groove is more than a screen's ratios span.
    wide = find_screen(one, file, tables, np.array([50.0, 78.0]))
    assert wide is None or not describe_screen(one, wide)["prints"]
    neat = design(tmp_path, '[process]\nsolids_fraction = 1.0\n[mask]\nmesh = "150-31"\n')
    thin = find_screen(neat, file, tables, np.array([72.0, 77.0]))
    assert not describe_screen(neat, thin)["prints"]


@pytest.mark.parametrize("aim", ["thinnest", "contrast"])
def test_the_page_of_a_design_shows_its_range(tmp_path, aim):
    estimate = {"value": 0.01, "ci95": [0.008, 0.012], "standard_error": 0.001}
    found = {
        "lamp_mura_contrast": estimate, "mean_luminance_cd_m2": estimate, "paths": 1000,
        "sigma_over_mean": estimate,
        "cell": {"across_mm": 4.0, "along_mm": 4.0, "luminance_cd_m2": [[1.0, 1.1], [1.1, 1.0]]},
    }  # fmt: skip
    searched = {**estimate, "serves": True, "traces": 2}
    boards = [
        {"value": 4.0, "model_least": 0.01, "searched": searched},
        {"value": 3.0, "model_least": None, "searched": {**searched, "serves": False}},
    ]
    ranged = {
        "aim": "thinnest", "of": "thickness", "unit": "mm", "contrast_target": 0.018,
        "chosen": 4.0, "serves": True, "boards": boards,
    }  # fmt: skip
    least = {"lamp_mura_contrast": 0.002}
    record = {
        "name": "d", "screen": "phototool only", "found": found, "bears": [], "mould": least,
        "optical_distance_mm": 5.0, "height_over_pitch": 0.4, "model_least": least,
        "printing": describe_screen(design(tmp_path), None), "pilot": None,
        "range": ranged if aim == "thinnest" else None,
        "tried": [{"series_per_mm": [[70.0, 1.0]], "lamp_mura_contrast": estimate, "paths": 9}],
        "design": {"goal": {"contrast_target": 0.018}},
    }  # fmt: skip
    write_led_page(tmp_path / "design.html", record, [])
    text = (tmp_path / "design.html").read_text()
    assert "no mesh and solids fraction" in text
    line = "thinnest that serves contrast 0.018 in the search: thickness 4 mm; 3 mm does not"
    assert (line in text) == (aim == "thinnest")


@pytest.mark.slow
def test_the_thinnest_board_from_file_to_record(tmp_path):
    text = "[search]\npaths_million = 0.3\niterations = 1\nuniform_per_mm = [70.0]\n"
    text += "[tolerance]\npaths_million = 0.2\nflux_percent = 0\nresin_percent = 0\nshift_mm = 0\n"
    one = design(tmp_path, text, ends="min = 4.0\nmax = 7.0\nstep = 1.5\n")
    record = run_led_design(one, tmp_path / "design.toml", tmp_path / "out", effort="quick")
    assert json.loads((tmp_path / "out" / "design.json").read_text()) == record
    chosen = record["range"]["chosen"]
    assert chosen in (4.0, 5.5, 7.0)
    assert record["optical_distance_mm"] == pytest.approx(chosen + 1.5 / 1.49)
    assert f"thickness_mm = {chosen}" in (tmp_path / "out" / "d.toml").read_text()
    assert range_lines(record["range"])[0] in (tmp_path / "out" / "design.html").read_text()
