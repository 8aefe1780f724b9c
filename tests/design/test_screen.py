"""A design through a mesh: the map is limited to what that mesh prints, and says so."""

import pytest

from mpfcad.errors import InputError
from mpfcad.job import build_job
from mpfcad.job.design import Design
from mpfcad.mask.fabric import find_mesh
from mpfcad.pipeline.design.aim import design_constraint
from mpfcad.pipeline.design.screen import with_design_screen
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.plan.printed.printable import printable_range
from mpfcad.pipeline.plan.printed.process import read_job_process
from mpfcad.pipeline.plan.printed.screen import mask_rules
from mpfcad.pipeline.point.trace import describe_point_screen
from mpfcad.pipeline.run.mask_plan import read_mask_plan

MESH = {"mask": {"mesh": "150-31", "period_um": 560.0}, "process": {"solids_fraction": 0.5}}
STACK = {"override": {"panel_width_mm": 8.5, "panel_length_mm": 30.0, "lamp_count": 1}}


def limits_of(tmp_path, **tables):
    design = Design.model_validate({"name": "d", **tables})
    design, job = with_design_screen(design, tmp_path / "d.toml")
    process = read_job_process(job, None, design.film.groove, "d.toml")
    return design, job, design_constraint(design, job, process, tmp_path / "d.toml")


def job_of(curvature, **tables):
    rows = [[0.0, float(curvature)], [8.5, float(curvature)]]
    document = {"schema": 1, "name": "j", "map": {"rows": rows, "extent": "panel"},
                "stack": STACK, **tables}  # fmt: skip
    return build_job(document, "j.toml")


def test_every_map_within_the_limits_passes_the_screen_s_gates(tmp_path):
    from mpfcad.pipeline.plan.printed.printing import plan_printing

    _, _, limits = limits_of(tmp_path, **MESH)
    assert 20.0 < limits.curvature_min < limits.curvature_max < 70.0
    # A shift by 200 µm may change no groove by more than 1 /mm.
    assert limits.change_max == pytest.approx(5.0)
    for curvature in (limits.curvature_min, limits.curvature_max):
        planned = read_mask_plan(job_of(curvature, **MESH), tmp_path / "j.toml")
        printing = plan_printing(planned.job, planned.mask, planned.process)
        gates = planned.job.gates
        assert gates.ratio_min <= printing.ratio_min <= printing.ratio_max <= gates.ratio_max
        assert printing.ripple <= gates.ripple_curvature_per_mm


def test_without_a_mesh_the_map_is_limited_by_the_phototool_alone(tmp_path):
    _, _, limits = limits_of(tmp_path, mask={"period_um": 640.0})
    assert limits.change_max == 10.0
    assert limits.curvature_max > 66.5


def test_a_period_that_does_not_level_is_refused(tmp_path):
    table = {**MESH, "mask": {"mesh": "150-31", "period_um": 5000.0}}
    _, job = with_design_screen(Design.model_validate({"name": "d", **table}), tmp_path / "d.toml")
    process = read_job_process(job, None, job.film.groove, "d.toml")
    rules = mask_rules(job.mask, "d.toml", 0.3)
    with pytest.raises(InputError, match=r"period_um: 5000: leaves a ripple of .* expected a sho"):
        printable_range(process, rules, job.gates, "d.toml")


def test_a_design_may_leave_the_mesh_to_the_program(tmp_path):
    constraint = {"curvature_min_per_mm": 52.0, "curvature_max_per_mm": 62.0}
    design, job, limits = limits_of(tmp_path, constraint=constraint, mask={"mesh": "auto"})
    chosen = job.mask.mesh.name
    assert find_mesh(chosen).count > 0
    assert (limits.curvature_min, limits.curvature_max) == (52.0, 62.0)
    # The job that is written names the mesh that was chosen.
    assert design.job_document("m.csv")["mask"]["mesh"]["name"] == chosen
    with pytest.raises(InputError, match=r"no mesh of the catalogue prints it .*nearest map"):
        limits_of(tmp_path, mask={"mesh": "auto"})


def test_a_point_of_a_sweep_says_whether_its_screen_prints_it(tmp_path):
    said = [
        describe_point_screen(read_plan(job_of(curvature, **tables), tmp_path / "j.toml"))
        for curvature, tables in ((58, MESH), (74, MESH), (74, {}))
    ]
    assert said[0] == "150-31" and said[2] == "phototool only"
    assert said[1].startswith("not printed by 150-31: C 74 … 74 /mm: expected ")
    ideal = job_of(58, film={"profile": "ideal"})
    assert describe_point_screen(read_plan(ideal, tmp_path / "j.toml")) is None
