import tomllib

import pytest
from pydantic import ValidationError

from mpfcad.errors import InputError
from mpfcad.job import TEMPLATE, build_job, read_job

MINIMAL = {"name": "a", "map": {"curvature_per_mm": 60}}


def refusal(**change):
    with pytest.raises(InputError) as error:
        build_job({**MINIMAL, **change}, "x.toml")
    line = str(error.value)
    assert "\n" not in line
    return line


def test_minimal_job_is_the_thesis_film_in_its_stack():
    job = build_job(MINIMAL, "x.toml")
    assert (job.film.pitch, job.film.depth, job.film.base) == (0.05, 0.025, 0.2)
    assert job.film.profile == "filled"
    assert job.stack.preset == "thesis-32in-mpf"
    assert (job.gates.contrast_pass, job.gates.contrast_marginal) == (0.012, 0.018)
    assert job.cad.angle_tolerance == pytest.approx(0.0087266, abs=1e-6)
    assert job.mask.period == pytest.approx(0.4)
    assert (job.seed, job.trace.effort, job.stack.thickness) == (1, "standard", None)


def test_job_is_frozen():
    job = build_job(MINIMAL, "x.toml")
    with pytest.raises(ValidationError):
        job.seed = 2
    with pytest.raises(ValidationError):
        job.film.pitch_um = 2


@pytest.mark.parametrize(
    ("change", "line"),
    [
        (
            {"film": {"pitch_um": -3}},
            "x.toml: film.pitch_um: -3: expected greater than or equal to 1",
        ),
        ({"film": {"pitch_um": float("nan")}}, "x.toml: film.pitch_um: nan: expected "),
        ({"film": {"pitch_um": True}}, "x.toml: film.pitch_um: True: expected a valid number"),
        ({"film": {"pitch_um": "50"}}, "x.toml: film.pitch_um: '50': expected a valid number"),
        ({"film": {"pitch": 0.05}}, "x.toml: film.pitch: 0.05: unknown key; known: profile, "),
        ({"colour": 1}, "x.toml: colour: 1: unknown key; known: schema, name, seed, map, "),
        ({"film": {"profile": "flat"}}, "x.toml: film.profile: flat: expected 'filled' or 'ideal'"),
        ({"map": {}}, "x.toml: map: {}: expected exactly one of file, curvature_per_mm, rows"),
        ({"map": {"file": "a", "curvature_per_mm": 1}}, "x.toml: map: {file, curvature_per_mm}: "),
        ({"stack": {"preset": "a", "file": "b"}}, "x.toml: stack: {preset, file}: give either"),
        ({"gates": {"contrast_pass": 0.5}}, "x.toml: gates: {contrast_pass}: contrast_pass = 0.5"),
        ({"mask": {"period_um": 20}}, "x.toml: mask: {period_um}: min_aperture_um + min_web_um"),
        ({"name": "../evil"}, "x.toml: name: ../evil: expected 1 to 64 letters"),
        ({"schema": 2}, "x.toml: schema: 2: expected 1"),
        ({"seed": -1}, "x.toml: seed: -1: expected greater than or equal to 0"),
        ({"trace": {"effort": "slow"}}, "x.toml: trace.effort: slow: expected 'quick', "),
    ],
)
def test_refusal_names_file_field_value_and_range(change, line):
    assert refusal(**change).startswith(line)


def test_missing_field_is_named():
    with pytest.raises(InputError, match=r"^x.toml: map: missing: expected a value$"):
        build_job({"name": "a"}, "x.toml")


def test_further_errors_are_counted_on_the_same_line():
    assert refusal(film={"pitch_um": -1, "depth_um": -1, "x": 1}).endswith("(and 2 more errors)")


def test_unreadable_file_is_one_line(tmp_path):
    path = tmp_path / "job.toml"
    with pytest.raises(InputError, match=r"job\.toml: no such file"):
        read_job(path)
    path.write_text('name = "a"\nseed = = 1\n')
    with pytest.raises(InputError, match=r"job\.toml: not TOML: .*line 2"):
        read_job(path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"job\.toml: byte 0: not UTF-8"):
        read_job(path)


def test_template_is_a_job_and_states_the_defaults(tmp_path):
    stated = build_job(tomllib.loads(TEMPLATE), "template")
    bare = build_job(
        {
            "name": "my-film",
            "map": {"curvature_per_mm": 60.0},
            # A new job prints through a screen; without one it would be a phototool only.
            "mask": {"mesh": "150-31"},
            "process": {"solids_fraction": 0.5},
        },
        "bare",
    )
    assert stated.document() == bare.document()


def test_given_makes_the_same_job_again():
    job = build_job({**MINIMAL, "film": {"base_um": 150.0}, "stack": {"thickness_mm": 16}}, "x")
    given = job.given()
    assert given["film"] == {"base_um": 150.0}
    assert build_job(given, "y") == job


@pytest.mark.parametrize(
    ("film", "size"),
    [
        ({"pitch_um": 100.0, "prism_angle_deg": 90.0}, (100, 50, 90)),
        ({"pitch_um": 100.0, "depth_um": 50.0}, (100, 50, 90)),
        ({"depth_um": 50.0, "prism_angle_deg": 90.0}, (100, 50, 90)),
        ({"pitch_um": 24.0, "depth_um": 12.0, "prism_angle_deg": 90.0}, (24, 12, 90)),
        ({"prism_angle_deg": 60.0}, (50, 25 * 3**0.5, 60)),
        ({}, (50, 25, 90)),
    ],
)
def test_two_of_pitch_depth_and_angle_give_the_third(film, size):
    job = build_job({**MINIMAL, "film": film}, "x.toml")
    table = job.film
    assert (table.pitch_um, table.depth_um, table.prism_angle_deg) == pytest.approx(size, rel=1e-11)
    assert (table.groove.pitch, table.groove.depth) == pytest.approx((size[0] / 1e3, size[1] / 1e3))
    assert table.is_plain
    # Only what is stated is given on, and it makes the same job again.
    assert job.given()["film"] == film
    assert build_job(job.given(), "y").document() == job.document()


@pytest.mark.parametrize(
    ("film", "words"),
    [
        (
            {"pitch_um": 50.0, "depth_um": 25.0, "prism_angle_deg": 89.0},
            "pitch_um = 50 and depth_um = 25 give prism_angle_deg = 90, found 89: expected two",
        ),
        ({"pitch_um": 2000.0, "prism_angle_deg": 20.0}, "depth_um = 5671.28 follows from"),
        ({"depth_um": 2000.0, "prism_angle_deg": 120.0}, "pitch_um = 6928.2 follows from"),
    ],
)
def test_pitch_depth_and_angle_that_disagree_are_refused(film, words):
    assert words in refusal(film=film)


def test_errors_of_the_tool_keep_the_prism_angle():
    film = build_job({**MINIMAL, "film": {"pitch_error_um": 1.0}}, "x").film
    assert film.groove.pitch == 0.05
    assert film.groove_as_made.pitch == pytest.approx(0.051)
    assert film.groove_as_made.depth == pytest.approx(0.0255)
    film = build_job({**MINIMAL, "film": {"prism_angle_error_deg": -30.0}}, "x").film
    assert film.groove_as_made.depth == pytest.approx(0.025 * 3**0.5)


def test_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "job.toml"
    path.write_bytes(b'\xef\xbb\xbfname = "a"\n[map]\ncurvature_per_mm = 60\n')
    assert read_job(path).name == "a"
