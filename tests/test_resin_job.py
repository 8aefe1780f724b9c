"""The `[resin]` table of a job, and where a stack's meshes go in an export."""

import json
import shutil

import pytest
from few_paths import few_paths
from harness import BARE, film_file

from mpfcad.backlight import PRISM_FILE, stack_file
from mpfcad.backlight.stored import describe_stack, restore_stack
from mpfcad.errors import ExportError, InputError
from mpfcad.job import build_job, read_job
from mpfcad.pipeline import run_job, verify_export
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.stack_mesh import write_stack_meshes
from mpfcad.pipeline.run.verify import made_files

PARTICLES = {
    "particle_radius_um": 5.0,
    "particle_index": 1.45,
    "particle_density_per_mm3": 1e5,
}


def job(**tables):
    return {"name": "a", "map": {"curvature_per_mm": 50.0}, **tables}


def test_particles_of_the_job_are_inputs_of_the_stack(tmp_path):
    plan = read_plan(build_job(job(resin=PARTICLES), "a.toml"), tmp_path / "a.toml")
    assert plan.stack.resin_scatters
    entries = {e["name"]: e for e in plan.stack.inputs()}
    for key, value in PARTICLES.items():
        entry = entries[f"resin_{key}"]
        assert (entry["value"], entry["tag"]) == (value, "given")
    assert "Mie" in entries["resin_scattering_per_mm"]["source"]


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, "scattering_per_mm"),
        ({**PARTICLES, "scattering_per_mm": 1.0}, "either"),
        ({**PARTICLES, "asymmetry": 0.5}, "asymmetry"),
        ({"particle_radius_um": 5.0}, "either"),
        ({"scattering_per_mm": -1.0}, "scattering_per_mm"),
        ({"index": 0.99}, "index"),
        ({"absorption_per_mm": -0.1}, "absorption_per_mm"),
        ({"index": 1.5, "particle_radius_um": 5.0}, "either"),
    ],
)
def test_a_resin_is_given_in_one_way(table, words):
    with pytest.raises(InputError, match=words):
        build_job(job(resin=table), "a.toml")


def test_a_resin_of_its_own_index_needs_the_prisms(tmp_path):
    plan = read_plan(build_job(job(resin={"index": 1.49}), "a.toml"), tmp_path / "a.toml")
    assert plan.stack.resin_differs and plan.stack.needs_prism and not plan.stack.resin_scatters
    write_stack_meshes(plan, tmp_path, SILENT)
    assert (tmp_path / PRISM_FILE).is_file()
    index = plan.stack["film_index"]
    same = read_plan(build_job(job(resin={"index": index}), "a.toml"), tmp_path / "a.toml")
    assert not same.stack.needs_prism


def test_meshes_of_the_stack_are_in_the_export(tmp_path):
    film_file(tmp_path / "bef.stl", [BARE])
    layers = '["film", { kind = "film", name = "upper", file = "bef.stl", rotation_deg = 90 }]'
    text = f'extends = "thesis-32in-mpf"\nlayers = {layers}\n'
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    given = job(stack={"file": "own.toml"}, resin={"scattering_per_mm": 3.0})
    plan = read_plan(build_job(given, "a.toml"), tmp_path / "a.toml")
    out = tmp_path / "out"
    out.mkdir()
    write_stack_meshes(plan, out, SILENT)
    assert {p.name for p in out.iterdir()} == {PRISM_FILE, stack_file("upper")}
    assert (out / stack_file("upper")).read_bytes() == (tmp_path / "bef.stl").read_bytes()
    described = describe_stack(plan.stack)
    restored = restore_stack(described)
    assert describe_stack(restored) == described
    assert restored.with_files_in(out) == plan.stack.with_files_in(out)
    assert str(tmp_path) not in str(described)


@pytest.mark.parametrize(
    ("film", "words"), [({"profile": "ideal"}, "ideal"), ({"tip_radius_um": 1.0}, "as designed")]
)
def test_a_film_without_known_prisms_has_no_resin(tmp_path, film, words):
    given = job(film=film, resin={"scattering_per_mm": 3.0})
    with pytest.raises(InputError, match=words):
        read_plan(build_job(given, "a.toml"), tmp_path / "a.toml")


SMALL = """
extends = "thesis-32in-mpf"
extent = "panel"
layers = [
    "clear_plate", "film",
    { kind = "film", name = "upper", file = "bef.stl", rotation_deg = 90 },
    { kind = "bef", flipped = true }, "top_sheet",
]
[value]
panel_width_mm = 40.0
panel_length_mm = 50.0
lamp_count = 5
lamp_pitch_mm = 8.0
lamp_2_luminance_factor = 0.5
"""
JOB = """
name = "small"
[map]
curvature_per_mm = 40.0
[stack]
file = "own.toml"
[stack.override]
"upper.rotation_deg" = 85.0
[resin]
particle_radius_um = 5.0
particle_index = 1.45
particle_density_per_mm3 = 1e5
"""


@pytest.fixture
def _few_paths():
    with few_paths():
        yield


@pytest.mark.usefixtures("_few_paths")
def test_such_a_job_runs_and_is_verified_from_its_export_alone(tmp_path):
    given = tmp_path / "given"
    given.mkdir()
    film_file(given / "bef.stl", [BARE])
    (given / "own.toml").write_text(SMALL, encoding="utf-8")
    (given / "small.toml").write_text(JOB, encoding="utf-8")
    out = tmp_path / "out"
    record = run_job(read_job(given / "small.toml"), given / "small.toml", out, effort="quick")
    assert {PRISM_FILE, stack_file("upper")} <= set(record["provenance"]["sha256"])
    inputs = {e["name"]: e["value"] for e in record["inputs"]}
    assert inputs["stack.resin_particle_radius_um"] == 5.0
    assert inputs["stack.upper.rotation_deg"] == 85.0
    assert inputs["stack.lamp_2_luminance_factor"] == 0.5
    energy = record["energy"]
    assert energy["lost"] == 0 and {"walls", "rim"} <= set(energy["absorbed_by"])
    report = (out / "report.html").read_text("utf-8")
    assert "resin scatters" in report and "turned 85°" in report
    shutil.rmtree(given)
    assert verify_export(out) == json.loads((out / "verification.json").read_text("utf-8"))
    (out / PRISM_FILE).write_bytes(b"x")
    with pytest.raises(ExportError, match=PRISM_FILE):
        verify_export(out)


@pytest.mark.parametrize(
    ("tables", "seen"),
    [
        ({}, False),
        ({"resin": PARTICLES}, True),
        ({"resin": {"index": 1.49}}, True),
        ({"resin": {"absorption_per_mm": 0.3}}, True),
        ({"stack": {"override": {"film_roughness": 0.05}}}, True),
    ],
)
def test_verify_expects_the_prisms_where_a_run_writes_them(tmp_path, tables, seen):
    plan = read_plan(build_job(job(**tables), "a.toml"), tmp_path / "a.toml")
    write_stack_meshes(plan, tmp_path, SILENT)
    assert (tmp_path / PRISM_FILE).exists() == (PRISM_FILE in made_files(plan)) == seen
