"""A design for LEDs: its maps, its search on a model, its files, and one whole run."""

import json
import math

import numpy as np
import pytest

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError
from mpfcad.film import CurvatureSeries
from mpfcad.job.led_design import is_led_design, read_led_design
from mpfcad.optics.library.file import read_library
from mpfcad.pipeline.led.bound import least_contrast
from mpfcad.pipeline.led.film import CROSSED, FILM, STACK, write_films
from mpfcad.pipeline.led.job import job_tables, write_job
from mpfcad.pipeline.led.search import TWO, LedSearch
from mpfcad.pipeline.led.tolerance import departures
from mpfcad.pipeline.led.tried import Tried


def design(tmp_path, text="", films=2):
    path = tmp_path / "design.toml"
    path.write_text(
        f'schema = 1\nkind = "leds"\nname = "d"\nfilms = {films}\n'
        '[stack]\npreset = "mini-led-4mm"\n' + text
    )
    return read_led_design(path)


def test_a_map_is_held_by_both_films_at_the_same_place(tmp_path):
    coefficient = np.zeros((3, 3))
    coefficient[0, 0], coefficient[1, 0], coefficient[0, 2] = 66.0, 3.0, 1.0
    stack = read_stack("mini-led-4mm")
    write_films(
        design(tmp_path, "[constraint]\npiece_mm = 0.2\nlevels = 256\n"),
        stack, "mini-led-4mm", CurvatureSeries(coefficient), tmp_path,
    )  # fmt: skip
    shipped = read_stack(tmp_path / STACK)
    assert shipped.files() == {"crossed_film": tmp_path / CROSSED}
    assert shipped["crossed_film.rotation_deg"] == 90 and shipped.layers == stack.layers
    for name, turned in ((FILM, False), (CROSSED, True)):
        film = read_library(tmp_path / name)
        assert film.size == pytest.approx((4.0, 4.0)) and film.chosen.shape == (80, 20)
        # C of a piece from its volume under the tips: resin is lowest in the middle.
        middle = np.array([np.interp(0.025, *section.T) for section in film.section])
        found = 2 * (film.high - middle[film.chosen]) / 0.025**2
        u, v = (np.arange(80) + 0.5) / 80, (np.arange(20) + 0.5) / 20
        expected = CurvatureSeries(coefficient.T if turned else coefficient).at(u, v)
        means = [part.reshape(8, 10, 5, 4).mean(axis=(1, 3)) for part in (found, expected)]
        assert np.abs(means[0] - means[1]).max() < 0.02


class Model:
    """Luminance that answers to the map as two films do, on top of what the LEDs leave."""

    def __init__(self, bare):
        self.bare = bare

    def __call__(self, chosen):
        response = 1.3 * TWO * 2 ** ((chosen.coefficient[0, 0] - 74) / 10)
        harmonic = self.bare + response * chosen.coefficient
        harmonic[0, 0] = 0.0
        return harmonic


@pytest.fixture
def model(monkeypatch):
    bare = np.array([[0.0, 0.03, -0.01], [0.02, 0.01, 0.0], [0.004, 0.0, 0.0]])
    answer = Model(bare)

    def attempt(self, coefficient):
        chosen = CurvatureSeries(coefficient)
        harmonic = answer(chosen)

        class Found:
            class contrast:
                value = float(np.abs(harmonic).sum())

        self.tried.append(Tried(chosen, Found(), harmonic, np.zeros_like(harmonic)))
        return self.tried[-1]

    monkeypatch.setattr(LedSearch, "_try", attempt)


def test_each_harmonic_is_corrected_by_its_own(tmp_path, model):
    text = "[constraint]\ncurvature_min_per_mm = 20.0\ncurvature_max_per_mm = 79.0\n"
    text += "[search]\niterations = 6\nuniform_per_mm = [60.0]\n[goal]\ncontrast_target = 1e-4\n"
    search = LedSearch(design(tmp_path, text), None)
    first = 0.074
    best = search.run()
    assert search.tried[0].found.contrast.value == pytest.approx(first)
    assert best.found.contrast.value < 0.02 * first


def test_a_pattern_is_held_within_its_limits(tmp_path, model):
    text = "[constraint]\ncurvature_min_per_mm = 64.0\ncurvature_max_per_mm = 68.0\n"
    search = LedSearch(design(tmp_path, text + "[search]\nuniform_per_mm = [66.0]\n"), None)
    best = search.run()
    place = np.arange(64) / 64
    value = best.map.at(place, place)
    assert value.min() >= 64 - 1e-9 and value.max() <= 68 + 1e-9
    assert 0.4 * 0.074 < best.found.contrast.value < 0.074


def test_the_least_contrast_of_the_linear_model(tmp_path):
    """One harmonic: what its limits let it take away; more room takes all."""
    harmonic = np.array([[0.0, 0.0], [0.05, 0.0]])
    flat = CurvatureSeries(np.array([[70.0, 0.0], [1.0, 0.0]]))
    start = Tried(flat, None, harmonic, 0 * harmonic)
    response = np.full((2, 2), -0.01)
    for room, left in ((2.0, 0.05 - 0.01 * 1.0), (5.0, 0.05 - 0.01 * 4.0), (9.0, 0.0)):
        text = f"[constraint]\ncurvature_min_per_mm = {70 - room}\n"
        limit = design(tmp_path, text + f"curvature_max_per_mm = {70 + room}\n").constraint
        found = least_contrast(limit, start, response)
        assert found.contrast == pytest.approx(left, abs=1e-9)
        assert abs(found.coefficient[1, 0]) == pytest.approx(min(room, 6.0), abs=1e-6)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[constraint]\ncurvature_min_per_mm = 78\ncurvature_max_per_mm = 70\n", "expected above"),
        ("[film]\npitch_um = 47.0\ndepth_um = 23.5\n", "whole number of grooves"),
    ],
)
def test_designs_that_cannot_be(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        one = design(tmp_path, text)
        write_films(one, read_stack("mini-led-4mm"), "mini-led-4mm", _even(60.0), tmp_path)


def _even(curvature):
    coefficient = np.zeros((3, 3))
    coefficient[0, 0] = curvature
    return CurvatureSeries(coefficient)


def test_two_films_need_one_across_in_the_stack(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text('extends = "mini-led-4mm"\nlayers = ["clear_plate", "film", "top_sheet"]\n')
    with pytest.raises(InputError, match="expected a layer of kind bef with rotation_deg 90"):
        write_films(design(tmp_path), read_stack(path), "own.toml", _even(60.0), tmp_path)
    films = write_films(
        design(tmp_path, films=1), read_stack(path), str(path), _even(60.0), tmp_path
    )
    assert len(films) == 1 and not math.isnan(films[0].film.fill_fraction)


def test_what_is_for_tubes_refuses_leds_in_a_line(tmp_path):
    from mpfcad.job.reader import read_job
    from mpfcad.pipeline.measure.case import read_case
    from mpfcad.pipeline.measure.compare import compare_cases
    from mpfcad.pipeline.measure.figures import Measuring
    from mpfcad.pipeline.measure.measure import measure_film
    from mpfcad.pipeline.plan.tube import read_tube_plan

    case = read_case("mini-led-4mm")
    with pytest.raises(InputError, match="expected one kind of light to compare"):
        compare_cases([case, read_case("thesis-32in-bef")], tmp_path / "c", Measuring())
    with pytest.raises(InputError, match="uniformity: not measured under LEDs: expected contrast"):
        measure_film(case, ("uniformity",), tmp_path / "m", Measuring())
    path = tmp_path / "job.toml"
    path.write_text(
        'schema = 1\nname = "j"\n[map]\ncurvature_per_mm = 60\n[stack]\npreset = "mini-led-4mm"\n'
    )
    with pytest.raises(InputError, match="expected a stack of tubes"):
        read_tube_plan(read_job(path), path)


def test_what_is_tried_to_know_what_a_design_bears(tmp_path):
    stack = read_stack("mini-led-4mm")
    one = design(tmp_path, films=1)
    shifts = [{"shift_x_mm": 0.16}, {"shift_y_mm": 0.16}]
    binning = {"stack.override.led_flux_spread": 0.05, "led_repeat": 2.0}
    resin = [{"resin_percent": 10.0}, {"resin_percent": -10.0}]
    assert departures(one, stack) == [*shifts, *resin, binning]
    text = "[tolerance]\nshift_mm = 0.3\nresin_percent = 0.0\nflux_percent = 0.0\n"
    axes = ["crossed_shift_x_mm", "crossed_shift_y_mm", "board_shift_x_mm"]
    assert departures(design(tmp_path, text), stack) == [{axis: 0.3} for axis in axes]


@pytest.mark.slow
def test_a_design_from_file_to_record(tmp_path):
    from mpfcad.pipeline.led.design import run_led_design

    text = "[search]\npaths_million = 0.3\niterations = 1\nuniform_per_mm = [60.0]\n"
    text += "[tolerance]\npaths_million = 0.2\nflux_percent = 0\n"
    one = design(tmp_path, text)
    assert is_led_design(tmp_path / "design.toml")
    record = run_led_design(one, tmp_path / "design.toml", tmp_path / "out", effort="quick")
    assert json.loads((tmp_path / "out" / "design.json").read_text()) == record
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {FILM, CROSSED, STACK, "curvature-cell.npz", "design.html", "manifest.json"} <= names
    low, high = record["found"]["lamp_mura_contrast"]["ci95"]
    assert 0 <= low < high < 0.2 and len(record["tried"]) == 2
    borne = [one["departure"] for one in record["bears"]]
    shifts = ["crossed_shift_x_mm", "crossed_shift_y_mm", "board_shift_x_mm"]
    assert borne[:3] == [{axis: 0.16} for axis in shifts]
    assert borne[3:] == [{"resin_percent": 10.0}, {"resin_percent": -10.0}]
    assert "film across: shift x 0.16 mm" in (tmp_path / "out" / "design.html").read_text()


class Stopped:
    """Progress that notes where each trace began, and stops the work in a trace of a number."""

    def __init__(self, number):
        self.number, self.starts = number, []

    def stage(self, text):
        """Begin a trace, or other work."""
        if text.startswith("tracing"):
            self.starts.append([])

    def note(self, text):
        """Forget it."""

    def trace(self, state):
        self.starts[-1].append(state.start)
        if len(self.starts) == self.number:
            raise KeyboardInterrupt


def test_an_interrupted_design_goes_on(tmp_path, monkeypatch):
    from mpfcad.pipeline.effort import TRACE_SETTINGS, TraceSetting
    from mpfcad.pipeline.led.design import run_led_design

    monkeypatch.setitem(TRACE_SETTINGS, "quick", TraceSetting(1e-9, 300_000))
    text = "[constraint]\npiece_mm = 1.0\nlevels = 8\n"
    text += "[search]\npaths_million = 0.1\niterations = 1\nuniform_per_mm = [60.0]\n"
    text += "[tolerance]\nshift_mm = 0.0\nresin_percent = 0.0\nflux_percent = 0.0\n"
    one, file = design(tmp_path, text), tmp_path / "design.toml"

    def made(name, number, threads):
        monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / f"cache-{name}"))
        seen, out = Stopped(number), tmp_path / name
        run_led_design(one, file, out, effort="quick", threads=threads, progress=seen)
        files = {path.name: path.read_bytes() for path in out.iterdir()}
        return seen, files

    with pytest.raises(KeyboardInterrupt):
        made("stopped", 3, 1)
    kept = list((tmp_path / "cache-stopped" / "trace").iterdir())
    assert len(kept) == 2 and not (tmp_path / "stopped").exists()
    seen, files = made("stopped", None, 2)
    # Both trials are there; what was shipped is traced.
    assert [min(starts) > 0 for starts in seen.starts] == [True, True, False]
    assert files == made("whole", None, 1)[1]
    assert not list((tmp_path / "cache-stopped" / "trace").iterdir())


def test_the_job_of_a_design_makes_its_films_bit_for_bit(tmp_path):
    from mpfcad.job import read_job
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.progress import SILENT
    from mpfcad.pipeline.run.make import write_cad

    coefficient = np.array([[66.0, 3.0 / 7], [1.0 / 3, 0.1]])
    found, folder, out = CurvatureSeries(coefficient), tmp_path / "design", tmp_path / "job"
    folder.mkdir()
    out.mkdir()
    one = design(tmp_path, "[constraint]\npiece_mm = 0.25\n[mask]\nperiod_um = 500.0\n")
    write_films(one, read_stack("mini-led-4mm"), "mini-led-4mm", found, folder)
    tables = job_tables(one, found)
    write_job(out / "d.toml", one, tmp_path / "design.toml", "mini-led-4mm", tables)
    plan = read_plan(read_job(out / "d.toml"), out / "d.toml")
    assert plan.job.mask.period_um == 500
    write_cad(plan, out, ("3mf",), SILENT)
    assert (out / FILM).read_bytes() == (folder / FILM).read_bytes()
    assert (out / CROSSED).read_bytes() == (folder / CROSSED).read_bytes()
