"""Designs of pyramids and dishes under LEDs: refusals, the measured response, films, a run."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.film import CellLibrary, CurvatureSeries, PyramidGroove
from mpfcad.job import read_job
from mpfcad.job.led_design import read_led_design
from mpfcad.optics.library.file import read_library
from mpfcad.pipeline.led.design import read_led_stack
from mpfcad.pipeline.led.film import FILM, films_of, write_films
from mpfcad.pipeline.led.job import job_tables, write_job
from mpfcad.pipeline.led.pilot import pilot_pattern
from mpfcad.pipeline.led.search import LedSearch
from mpfcad.pipeline.led.tolerance import departures
from mpfcad.pipeline.led.tried import Tried
from mpfcad.pipeline.plan.departure import Departure, PrintError
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad
from mpfcad.report.page.led_page import pilot_lines

PRINTED = '[film]\ncell = "pyramid"\n'
DISH = '[film]\ncell = "paraboloid"\nprofile = "ideal"\n'


def design(tmp_path, text="", film=PRINTED, films=1):
    path = tmp_path / "design.toml"
    path.write_text(
        f'schema = 1\nkind = "leds"\nname = "d"\nfilms = {films}\n'
        f'[stack]\npreset = "mini-led-4mm"\n{film}{text}'
    )
    return read_led_design(path)


@pytest.mark.parametrize(
    ("film", "text", "films", "words"),
    [
        (PRINTED, "", 2, "films = 2: .*expected 1: cells are patterned both ways"),
        ('[film]\ncell = "paraboloid"\n', "", 1, "expected 'ideal', a mould's"),
        (PRINTED, "[constraint]\npiece_mm = 0.2\n", 1, "piece_mm: .*left out for cells"),
        (DISH, "[constraint]\nsolids_fraction_min = 0.2\n", 1, "no print makes it"),
        (PRINTED, "[search]\nuniform_per_mm = [80.0]\n", 1, "within the limits of C, 40 … 80"),
        (PRINTED, "[constraint]\ncurvature_max_per_mm = 30.0\n", 1, "= 30: expected above 40"),
        ("", "[search]\nuniform_per_mm = [66.0, 79.0]\n", 1, "79: expected within .* 55 … 78"),
    ],
)
def test_designs_of_cells_that_cannot_be(tmp_path, film, text, films, words):
    with pytest.raises(InputError, match=words) as caught:
        design(tmp_path, text, film, films)
    assert "\n" not in str(caught.value) and len(str(caught.value)) <= 300


@pytest.mark.parametrize(
    ("film", "words"),
    [
        (PRINTED + "tip_radius_um = 2.0\n", "without imperfections"),
        ('[film]\nprofile = "ideal"\n', "expected profile 'filled'"),
    ],
)
def test_what_no_job_makes_is_refused_before_a_trace(tmp_path, film, words):
    from mpfcad.pipeline.led.design import run_led_design

    with pytest.raises(InputError, match=words):
        run_led_design(design(tmp_path, film=film), tmp_path / "design.toml", tmp_path / "out")


def test_limits_follow_from_the_kind_of_film(tmp_path):
    printed, dish = design(tmp_path), design(tmp_path, film=DISH)
    found = [
        (one.constraint.curvature_min_per_mm, one.constraint.curvature_max_per_mm)
        for one in (printed, dish, design(tmp_path, film=""))
    ]
    assert found == [(40.0, 80.0), (20.0, 100.0), (55.0, 78.0)]
    assert dish.search.uniform_per_mm == [30.0, 50.0, 70.0]
    narrow = design(tmp_path, "[constraint]\ncurvature_max_per_mm = 60.0\n", film="")
    assert narrow.search.uniform_per_mm == [58.0]
    # A board of a range is the design read again: it says no more than the file.
    again = dish.model_dump(mode="json", by_alias=True, exclude_unset=True)
    assert "constraint" not in again and "search" not in again


@pytest.mark.parametrize("film", [PRINTED, DISH])
def test_the_film_of_a_design_is_that_of_its_job_bit_for_bit(tmp_path, film):
    one = design(tmp_path, "[constraint]\nlevels = 6\nangle_tolerance_deg = 4.0\n", film)
    found = CurvatureSeries(np.array([[62.0, 3.0 / 7], [-1.0 / 3, 0.1]]))
    folder, out = tmp_path / "design", tmp_path / "job"
    folder.mkdir()
    out.mkdir()
    (kind,) = write_films(one, read_stack("mini-led-4mm"), "mini-led-4mm", found, folder)
    assert isinstance(kind.film, CellLibrary) and kind.film.shape in film
    write_job(out / "d.toml", one, tmp_path / "design.toml", "mini-led-4mm", job_tables(one, found))
    plan = read_plan(read_job(out / "d.toml"), out / "d.toml")
    assert isinstance(plan.job.film.groove, PyramidGroove) == (film == PRINTED)
    write_cad(plan, out, ("3mf",), SILENT)
    assert (out / FILM).read_bytes() == (folder / FILM).read_bytes()
    # Where C of the map is most, the cells' valleys are lowest.
    low = read_library(folder / FILM)
    assert low.chosen.shape == (80, 80)
    assert kind.shown.max() == pytest.approx(found.at(*[np.array([0.5, 0.0])] * 2).max(), abs=0.05)


@pytest.mark.parametrize("harmonics", [1, 2, 3, 4])
def test_the_pilots_pattern_keeps_within_half_the_room(harmonics):
    pattern = pilot_pattern(harmonics + 1, 12.0)
    place = np.arange(200) / 200
    reach = np.abs(CurvatureSeries(pattern).at(place, place)).max()
    assert reach == pytest.approx(6.0, rel=0.01)
    moved = np.abs(pattern).ravel()[1:]
    # Of equal signs all of them would add up at the LED.
    assert np.all(moved == moved[0])
    assert moved[0] >= (1.8 if harmonics > 1 else 1.0) * 6.0 / ((harmonics + 1) ** 2 - 1) - 1e-9


class Lit:
    """Light over cells: what the LEDs leave, what the map does, a square of it, and noise."""

    def __init__(self, response, noise=1e-3, seed=1):
        self.response, self.noise = response, noise
        self.rng = np.random.Generator(np.random.Philox(seed))

    def __call__(self, chosen):
        pattern = chosen.coefficient.copy()
        mean, pattern[0, 0] = pattern[0, 0], 0.0
        bare = np.array([[0.0, 0.04, -0.01], [0.03, 0.01, 0.0], [0.0, 0.0, 0.0]])
        harmonic = bare * (1 + (mean - 60) ** 2 / 200) + self.response * pattern + 1e-4 * pattern**2
        harmonic = harmonic + self.noise * self.rng.standard_normal(harmonic.shape)
        harmonic[0, 0] = 0.0
        value = float(np.abs(harmonic).sum())

        class Found:
            class contrast:
                pass

        Found.contrast.value = value
        return Tried(chosen, Found(), harmonic, np.full(harmonic.shape, self.noise))


def searched(one, lit, monkeypatch):
    search = LedSearch(one, None)

    def attempt(coefficient):
        search.tried.append(lit(CurvatureSeries(coefficient)))
        return search.tried[-1]

    monkeypatch.setattr(search, "_try", attempt)
    search.run()
    return search


@pytest.mark.parametrize("response", [-0.004, 0.005, 0.012])
def test_a_search_measures_the_response_of_cells(tmp_path, monkeypatch, response):
    """Of either sign: the map is found with no experience of it."""
    text = "[search]\nuniform_per_mm = [50.0, 60.0, 70.0]\niterations = 4\n"
    one = design(tmp_path, text + "[goal]\ncontrast_target = 0.001\n")
    search = searched(one, Lit(response), monkeypatch)
    means = [50.0, 60.0, 70.0, 50.0, 50.0, 60.0, 60.0, 70.0, 70.0]  # even films, then pilots
    assert [tried.mean for tried in search.tried[:9]] == means
    pilot = search.pilot
    assert pilot.is_told and abs(pilot.value - response) < 4 * pilot.standard_error
    assert pilot.standard_error < 0.1 * abs(response)
    assert search.tried[1].found.contrast.value > 0.08 and search.best.found.contrast.value < 0.03
    (line,) = pilot_lines(json.loads(json.dumps(pilot.document())))
    assert line.startswith("response of ln L to C")


def test_a_search_goes_on_about_the_mean_whose_pattern_has_room(tmp_path, monkeypatch):
    """C = 75 /mm is the better even film, but no pattern fits there."""
    text = "[search]\nuniform_per_mm = [62.0, 75.0]\niterations = 2\n"
    text += "[constraint]\ncurvature_max_per_mm = 76.0\n[goal]\ncontrast_target = 0.001\n"
    lit = Lit(-0.004)

    def at(chosen):
        found = lit(chosen)
        if found.mean == 75.0:
            found = replace(found, harmonic=0.9 * lit(flat).harmonic)
            type(found.found).contrast.value = 0.05
        return found

    flat = CurvatureSeries(np.array([[60.0, 0.0, 0.0], [0.0] * 3, [0.0] * 3]))
    search = searched(design(tmp_path, text), at, monkeypatch)
    assert [tried.mean for tried in search.tried[:2]] == [62.0, 75.0]
    assert search.tried[1].found.contrast.value < search.tried[0].found.contrast.value
    assert [tried.mean for tried in search.tried[2:6]] == [62.0, 62.0, 75.0, 75.0]
    assert {tried.mean for tried in search.tried[6:]} == {62.0} and search.best.mean == 62.0


def test_a_response_in_the_noise_ends_the_search_with_its_bound(tmp_path, monkeypatch):
    one = design(tmp_path, "[search]\nuniform_per_mm = [60.0]\niterations = 4\n")
    search = searched(one, Lit(0.0, noise=2e-3), monkeypatch)
    assert len(search.tried) == 3 and not search.pilot.is_told
    most = abs(search.pilot.value) + 3 * search.pilot.standard_error
    assert np.abs(search.response) == pytest.approx(most)
    (line,) = pilot_lines(search.pilot.document())
    assert "in the noise, so no map was tried" in line


def test_pilots_say_how_sure_they_are(tmp_path, monkeypatch):
    """Of 400 pilots the true response lies within 1.96 standard errors in 95 %."""
    one = design(tmp_path, "[search]\nuniform_per_mm = [60.0]\niterations = 0\n")
    off = []
    for seed in range(400):
        pilot = searched(one, Lit(-0.003, seed=seed), monkeypatch).pilot
        off.append((pilot.value + 0.003) / pilot.standard_error)
    assert 0.92 <= np.mean(np.abs(off) < 1.96) <= 0.98  # 95 % ± 2.7 standard errors
    assert abs(np.mean(off)) < 4 / np.sqrt(400)


def test_a_mould_bears_an_error_of_curvature(tmp_path):
    stack = read_stack("mini-led-4mm")
    moulded = departures(design(tmp_path, film=DISH), stack)
    assert moulded[2:4] == [{"curvature_error_per_mm": 1.0}, {"curvature_error_per_mm": -1.0}]
    assert {"resin_percent": 10.0} in departures(design(tmp_path), stack)


def test_a_mould_out_of_place_keeps_its_curvature(tmp_path):
    """C above that of bare prisms is a mould's to have, wherever its film lies."""
    one = design(tmp_path, film=DISH)
    path = tmp_path / "d.toml"
    map_ = CurvatureSeries(np.array([[85.0, 4.0], [3.0, 0.0]]))
    write_job(path, one, tmp_path / "design.toml", "mini-led-4mm", job_tables(one, map_))
    job = read_job(path)
    shifted = read_plan(job, path, Departure((PrintError(shift=(0.05, 0.0)),))).drawn.wanted
    assert shifted.max() > 91 and np.allclose(
        np.roll(read_plan(job, path).drawn.wanted, 1, axis=0), shifted
    )
    off = read_plan(job, path, Departure((PrintError(curvature=1.0),))).drawn.wanted
    assert np.allclose(off, read_plan(job, path).drawn.wanted + 1)
    with pytest.raises(InputError, match="a mould makes the film: expected curvature_error_per_mm"):
        read_plan(job, path, Departure((PrintError(resin=0.1),)))


@pytest.mark.parametrize("name", ["pyramid", "pyramid-mould", "batwing-one"])
def test_designs_that_come_with_the_program_have_films(name):
    file = Path(__file__).parents[1] / "masks" / f"design-led-{name}.toml"
    one = read_led_design(file)
    even = CurvatureSeries(np.array([[one.search.uniform_per_mm[0]]]))
    (kind,) = films_of(one, read_led_stack(one, file), even)
    assert kind.film.size == pytest.approx((12.15, 12.15)) and one.films == 1


def test_films_of_cells_need_whole_cells(tmp_path):
    one = design(tmp_path, film=PRINTED + "pitch_um = 47.0\ndepth_um = 23.5\n")
    with pytest.raises(InputError, match="whole number of grooves"):
        films_of(one, read_stack("mini-led-4mm"), CurvatureSeries(np.array([[60.0]])))


@pytest.mark.slow
@pytest.mark.parametrize("film", [PRINTED, DISH])
def test_a_design_of_cells_from_file_to_record_and_run(tmp_path, film):
    from mpfcad.pipeline.led.design import run_led_design
    from mpfcad.pipeline.run.run import run_job
    from mpfcad.pipeline.run.verify import verify_export

    text = "[constraint]\nlevels = 8\nangle_tolerance_deg = 4.0\n"
    text += "[search]\npaths_million = 0.3\niterations = 1\nuniform_per_mm = [60.0]\n"
    text += "[tolerance]\npaths_million = 0.2\nflux_percent = 0\n"
    one, out = design(tmp_path, text, film), tmp_path / "out"
    record = run_led_design(one, tmp_path / "design.toml", out, effort="quick")
    assert json.loads((out / "design.json").read_text()) == record
    low, high = record["found"]["lamp_mura_contrast"]["ci95"]
    assert 0 <= low < high < 0.3 and 3 <= len(record["tried"]) <= 4
    assert record["pilot"]["standard_error_mm"] > 0
    assert (record["films"][0]["fill_min"] is None) == (film == DISH)
    assert pilot_lines(record["pilot"])[0] in (out / "design.html").read_text()
    borne = [next(iter(one["departure"])) for one in record["bears"]]
    error = "curvature_error_per_mm" if film == DISH else "resin_percent"
    assert borne == ["shift_x_mm", "shift_y_mm", error, error]
    run = run_job(read_job(out / "d.toml"), out / "d.toml", tmp_path / "run", effort="quick")
    # The same film, another run of the same seed.
    assert run["accelerator"].endswith("cells")
    assert (tmp_path / "run" / FILM).read_bytes() == (out / FILM).read_bytes()
    assert verify_export(tmp_path / "run") == run
