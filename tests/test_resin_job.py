"""The `[resin]` table of a job, and where a stack's meshes go in an export."""

import pytest
from harness import BARE, film_file

from mpfcad.backlight import PRISM_FILE, stack_file
from mpfcad.errors import InputError
from mpfcad.job import build_job
from mpfcad.pipeline.plan import describe_stack, read_plan, restore_stack
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.stack_mesh import write_stack_meshes

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
    ],
)
def test_a_resin_is_given_in_one_way(table, words):
    with pytest.raises(InputError, match=words):
        build_job(job(resin=table), "a.toml")


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


def test_an_ideal_film_has_no_resin(tmp_path):
    given = job(film={"profile": "ideal"}, resin={"scattering_per_mm": 3.0})
    plan = read_plan(build_job(given, "a.toml"), tmp_path / "a.toml")
    with pytest.raises(InputError, match="ideal"):
        write_stack_meshes(plan, tmp_path, SILENT)
