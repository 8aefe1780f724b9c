"""Runs of films that are no plain grooves: through CAD, mesh, trace and verdict, and verified."""

import json
from html import unescape

import numpy as np
import pytest
from few_paths import few_paths

from mpfcad.job import read_job
from mpfcad.pipeline import run_job, verify_export

STACK = (
    'extends = "thesis-32in-mpf"\n[value]\npanel_width_mm = 12.0\npanel_length_mm = 10.0\n'
    "lamp_count = 3\nlamp_pitch_mm = 4.0\n"
)
KINDS = {
    "rounded": (
        "tip_radius_um = 1.5\nvalley_radius_um = 1.0\nprism_angle_error_deg = -1.0\n"
        "pitch_error_um = 0.1",
        "filled",
    ),
    "measured": ('measured_file = "trace.csv"', "filled"),
    "pyramid": ('cell = "pyramid"', "filled"),
    "paraboloid": ('cell = "paraboloid"', "ideal"),
    "spots": ("", "filled"),
}
MAPS = {"spots": 'file = "field.npz"\nextent = "panel"\n[mask]\nmin_aperture_um = 9.0'}
UNIFORM = "curvature_per_mm = 58.0"


@pytest.fixture
def job_file(tmp_path):
    (tmp_path / "small.toml").write_text(STACK)
    x = np.arange(0.0, 0.2, 0.0005)
    local = (x + 0.025) % 0.05 - 0.025
    surface = np.maximum(0.0075 + 28 * local**2, np.abs(local))
    table = np.stack([x, surface + 1e-2 * x], axis=1) * 1000
    np.savetxt(tmp_path / "trace.csv", table, "%.6f", ",", header="x_um,z_um", comments="")

    x, y = np.linspace(0, 12, 7), np.linspace(0, 10, 401)
    curvature = 58 + 0.5 * np.cos(40 * np.pi * y)[:, None] * np.ones(7)
    names = ("position_across_mm", "position_along_mm", "curvature_per_mm")
    np.savez(tmp_path / "field.npz", **dict(zip(names, (x, y, curvature), strict=True)))

    def write(kind):
        film, profile = KINDS[kind]
        path = tmp_path / "job.toml"
        made = f'profile = "{profile}"\n{film}\n'
        path.write_text(
            f'name = "kind"\n[map]\n{MAPS.get(kind, UNIFORM)}\n[film]\n{made}'
            '[stack]\nfile = "small.toml"\n[cad]\nlength_mm = 0.05\nangle_tolerance_deg = 4.0\n'
        )
        return path

    with few_paths():
        yield write


@pytest.mark.parametrize(
    "kind", ["rounded", *(pytest.param(kind, marks=pytest.mark.slow) for kind in list(KINDS)[1:])]
)
def test_run_and_verify(job_file, tmp_path, kind):
    path, out = job_file(kind), tmp_path / "out"
    record = run_job(read_job(path), path, out, effort="quick", threads=1)
    gates = {gate["name"]: gate for gate in record["gates"]}
    assert all(gate["outcome"] == "PASS" for gate in record["gates"][1:])
    assert ("mask_mesh_curvature_difference_per_mm" in gates) == (kind != "measured")
    assert (record["mask"] is None) == (kind in ("pyramid", "paraboloid"))
    assert ("resin_volume_difference" in gates) == (record["mask"] is not None)
    # From the export alone: neither job nor trace is read again.
    (tmp_path / "trace.csv").unlink()
    (tmp_path / "field.npz").unlink()
    assert verify_export(out, threads=1) == record
    assert json.loads((out / "verification.json").read_text()) == record
    page = unescape((out / "report.html").read_text())
    words = {"rounded": "tip radius 1.5 µm, valley radius 1 µm", "measured": "measured profile"}
    words["spots"] = "varies across and along the grooves"
    assert words.get(kind, "A section through the cells' tips") in page
