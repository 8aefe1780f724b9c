"""Films of every kind printed again: their resin, and how the contrast comes out."""

import numpy as np
import pytest
import trimesh
from harness import single_paths

from mpfcad.job import build_job
from mpfcad.measure import TraceRun, light_film, luminance_over_pitch
from mpfcad.measure.meter import pitch_positions
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.engine import flow_count
from mpfcad.optics.source import EYE, Source
from mpfcad.pipeline.confidence.find import variants_of
from mpfcad.pipeline.confidence.printed import find_printed
from mpfcad.pipeline.confidence.reprint import Reprints
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad

OVERRIDE = {"lamp_pitch_mm": 8.0, "panel_width_mm": 16.0, "panel_length_mm": 6.0, "lamp_count": 2}
STACK = {"preset": "thesis-32in-mpf", "override": OVERRIDE}
ROWS = {"rows": [[0.0, 60.0], [4.0, 48.0], [8.0, 60.0]]}
MESH = {"mask": {"mesh": "150-31"}, "process": {"solids_fraction": 0.5}}
ARC = {"solids_fraction": 0.5, "contact_angle_deg": 20.0}
KINDS = {
    "designed": {"map": ROWS},
    "rounded": {"map": ROWS, "film": {"tip_radius_um": 1.0, "valley_radius_um": 1.0}},
    "uneven": {"map": ROWS, "film": {"resin_spread_percent": 5.0}},
    "arc": {"map": ROWS, "film": {"surface": "arc"}, "process": ARC},
    "field": {
        "map": {"file": "field.npz", "extent": "panel"},
        "cad": {"length_mm": 0.1, "angle_tolerance_deg": 2.0},
    },
}


def plan_of(folder, kind):
    x, y = np.linspace(0, 16, 33), np.linspace(0, 6, 13)
    names = ("position_across_mm", "position_along_mm", "curvature_per_mm")
    curvature = 54 + 5 * np.cos(x * np.pi / 4) + np.cos(y[:, None] * np.pi * 2)
    np.savez(folder / "field.npz", **dict(zip(names, (x, y, curvature), strict=True)))
    document = {"schema": 1, "name": "p", "stack": STACK, **MESH, **KINDS[kind]}
    return read_plan(build_job(document, "job.toml"), folder / "job.toml")


@pytest.mark.parametrize("kind", KINDS)
def test_a_film_of_any_kind_is_printed_with_so_much_more_resin(tmp_path, kind):
    plan = plan_of(tmp_path, kind)
    write_cad(plan, tmp_path, ("stl",), SILENT)
    with variants_of(plan, tmp_path) as shipped:
        variants = Reprints.of(shipped)
        factors = variants.print_factors()
        assert factors and factors[0].sigma > 20
        volume = {}
        for step in (-1.0, 0.0, 1.0):
            change = {f.name: (step if i == 0 else 0.0) * f.sigma for i, f in enumerate(factors)}
            volume[step] = trimesh.load(variants._film(change)).volume
            factor = variants.resin_factor(change)
        assert volume[0.0] == pytest.approx(trimesh.load(tmp_path / "film.stl").volume, rel=1e-5)
    # Each place gets so much more than it was printed with, over the area that it takes.
    groove, size = plan.piece.groove, plan.drawn.size
    fill = groove.fill_fraction(variants._reprint.places) * (
        factor.reshape(variants._reprint.places.shape) - 1
    )
    more = float(np.mean(fill)) * groove.depth / 2 * size[0] * size[1]
    assert volume[1.0] - volume[0.0] == pytest.approx(more, rel=0.02)
    assert volume[0.0] - volume[-1.0] == pytest.approx(more / np.mean(factor), rel=0.1)


def test_light_that_is_guided_along_the_grooves_for_metres_leaves_in_the_end(tmp_path):
    """Path 127,250 of seed 1: oracle and tree follow it alike, on and on."""
    plan = plan_of(tmp_path, "field")
    write_cad(plan, tmp_path, ("stl",), SILENT)
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    meter = Source(
        EYE, pitch_positions(lit.stack) * lit.stack.period.across, lit.spot.width,
        acceptance=lit.stack.acceptance,
    )  # fmt: skip
    found, flow = np.zeros(1), np.zeros(flow_count(lit.scene, len(meter.position)))
    single_paths(lit.scene, meter, 1, 127_250, found, flow)
    assert lit.accelerator == "bvh" and found[0] > 0
    assert flow[FLOWS.index("lost")] == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["rounded", "field"])
def test_the_verdict_has_what_the_print_makes_of_a_film_as_made_or_along(tmp_path, kind):
    plan = plan_of(tmp_path, kind)
    write_cad(plan, tmp_path, ("stl",), SILENT)
    lit = light_film(plan.stack, tmp_path / "film.stl", plan.offset)
    found = luminance_over_pitch(lit, TraceRun(seed=1), half_width_goal=1.0)
    printed = find_printed(tmp_path, plan, found, 2, SILENT)
    assert printed["inputs"][0]["name"] == "resin_percent"
    low, high = printed["contrast"]["ci95"]
    assert 0 < low <= high < 1 and 0 <= printed["probability"]["marginal"]["value"] <= 1


def test_a_film_that_no_print_makes_is_not(tmp_path):
    ideal = {"map": ROWS, "film": {"profile": "ideal"}, "mask": {}, "process": {}}
    document = {"schema": 1, "name": "p", "stack": STACK, **ideal}
    plan = read_plan(build_job(document, "job.toml"), tmp_path / "job.toml")
    with variants_of(plan, tmp_path) as shipped:
        assert Reprints.of(shipped).print_factors() == []
