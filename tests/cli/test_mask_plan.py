"""`mpfcad mask --plan`, and masks of 2-D maps, through the command line."""

import json

import numpy as np
import pytest
from command import called, refused

UNIFORM = "curvature_per_mm = 55.0"
FIELD = 'file = "field.npz"\nextent = "panel"'
PANEL = "[stack.override]\npanel_width_mm = 34.0\npanel_length_mm = {}\nlamp_count = 1\n"


def job(folder, map_table, mask_table, length=60.0):
    text = f'schema = 1\nname = "job"\n[map]\n{map_table}\n[mask]\n{mask_table}\n'
    text += PANEL.format(length)
    (folder / "job.toml").write_text(text)
    x, y = np.linspace(0, 34, 18), np.linspace(0, length, 31)
    curvature = 59 + 3 * np.cos(x / 5) * np.cos(y[:, None] / 3)
    names = ("position_across_mm", "position_along_mm", "curvature_per_mm")
    np.savez(folder / "field.npz", **dict(zip(names, (x, y, curvature), strict=True)))


def test_the_plan_says_what_screen_is_needed_and_makes_nothing(tmp_path):
    mask = 'period_um = 1000.0\npixel_um = 363.0\n[mask.mesh]\nname = "120-34"\nangle_deg = 0.0'
    job(tmp_path, UNIFORM, mask)
    before = sorted(tmp_path.iterdir())
    result = called("mask", "job.toml", "--plan", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert "mesh 120-34: opening 49.33 µm, open area 35%, volume 18.23 cm³/m²" in result.stdout
    assert "so 65% leaves" in result.stdout
    assert "a full groove needs 12.5 cm³/m²" in result.stdout
    assert "visible from 500 mm" in result.stdout
    assert sorted(tmp_path.iterdir()) == before


def test_mesh_and_release_give_the_fill(tmp_path):
    mask = 'period_um = 1000.0\n[mask.mesh]\nname = "120-34"\nrelease = 0.5\nemulsion_um = 4.0'
    mask += '\n[process]\nmodel = "linear"'
    job(tmp_path, UNIFORM, mask)
    result = called("mask", "job.toml", "--format", "oas", "--out", "out", cwd=tmp_path)
    assert result.returncode == 1, result.stderr
    for gate in ("ripple_luminance",):  # 1 mm of period, 1 mm of levelling
        assert f"FAIL         screen_{gate} " in result.stdout
    assert "printability: FAIL" in result.stdout
    assert "screens that print this map: mpfcad mask job.toml --propose" in result.stdout
    screen = json.loads((tmp_path / "out" / "screen.json").read_text())
    mesh = screen["mesh"]
    volume = mesh["open_area"] * mesh["thickness_um"] + 4
    assert mesh["volume_with_emulsion_cm3_m2"] == pytest.approx(volume)
    assert mesh["transfer_factor"] == pytest.approx(0.5 * volume / 12.5)
    # C = 55 has fill 0.1213 (closed form): ratio = fill / transfer factor.
    fill = screen["aperture_ratio"]["mean"] * mesh["transfer_factor"]
    assert fill == pytest.approx(0.1213, abs=2e-3)


@pytest.mark.parametrize(
    ("mask", "words"),
    [
        (
            "[mask.mesh]\nthreads_per_cm = 250.0\nthread_um = 48.0",
            ["mask.mesh.thread_um: 48", "leaves nothing open"],
        ),
        (
            '[mask.mesh]\nname = "1-2"',
            ["mask.mesh: '1-2': not in the catalogue: expected a name such as 120-34"],
        ),
        ('[mask.mesh]\nname = "90-48"\nthread_um = 4.0', ["mask.mesh", "expected either name, or"]),
        ('[mask.mesh]\nmash = "90-48"', ["mask.mesh.mash", "unknown key; known: name, catalogue"]),
        ('[mask.mesh]\nname = "90-48"', ["grooves 0-679", "no mesh at this period", "--propose"]),
        ('pattern = "stripe"', ["mask.pattern: stripe: expected 'slot', 'dot'"]),
        ("period_um = 700.0\n[mask.mesh]\nname = '90-48'", ["mesh 106-34 would do"]),
    ],
)
def test_what_cannot_be_made_is_said_in_one_line(tmp_path, mask, words):
    job(tmp_path, UNIFORM, mask)
    refused(called("mask", "job.toml", "--plan", cwd=tmp_path), *words)


@pytest.mark.parametrize("pattern", ["slot", "dot", "blue-noise", "error-diffused"])
def test_a_2d_map_gets_a_checked_mask(tmp_path, pattern):
    period = 400 if pattern == "slot" else 50
    mask = f'pattern = "{pattern}"\nperiod_um = {period}.0\nmin_aperture_um = 9.0'
    job(tmp_path, FIELD, mask, length=25.0)
    result = called("mask", "job.toml", "--format", "oas", "--out", "out", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"mask.oas", "screen.json", "manifest.json"} <= names


def test_a_2d_map_is_refused_by_what_needs_one_section(tmp_path):
    job(tmp_path, FIELD, 'pattern = "dot"\nperiod_um = 50.0\nmin_aperture_um = 9.0')
    refused(
        called("mould", "job.toml", cwd=tmp_path),
        "job.toml: map.file: varies along",
        "a mould is turned",
    )
    job(tmp_path, 'file = "field.npz"', 'pattern = "dot"\nperiod_um = 50.0')
    refused(called("mask", "job.toml", cwd=tmp_path), "map.extent: pitch: expected 'panel'")


SHEET = "threads_per_cm = 90, thread_um = 48, "


def planned(folder, figures):
    job(folder, UNIFORM, f"period_um = 1200\nmesh = {{ {SHEET}{figures} }}")
    return called("mask", "job.toml", "--plan", cwd=folder)


def test_what_a_data_sheet_states_stands_beside_what_geometry_gives(tmp_path):
    figures = "opening_um = 65, thickness_um = 72, open_area_percent = 33, ink_volume_cm3_m2 = 24"
    result = planned(tmp_path, figures)
    assert "open area 33 % stated, 33.1 by its figures; ink volume 24 cm³/m² stated, 23.8" in (
        result.stdout + result.stderr
    )


@pytest.mark.parametrize(
    ("figures", "line"),
    [
        ("opening_um = 65, thickness_um = 300", "thickness_um: 300: expected 48 … 106"),
        ("opening_um = 90", "opening_um: 90: expected 48.7 … 67.9"),
        ("opening_um = 65, open_area_percent = 50", "open_area_percent: 50: expected 33.1 ± 1.5 %"),
        (
            "opening_um = 65, thickness_um = 72, ink_volume_cm3_m2 = 30",
            "ink_volume_cm3_m2: 30: expected 23.8 ± 1.4 cm³/m²: what opening 65, thread 48 and",
        ),
    ],
)
def test_a_data_sheet_that_contradicts_itself_is_refused(tmp_path, figures, line):
    refused(planned(tmp_path, figures), f"job.toml: mask.mesh.{line}")


BIG = """name = "big"
[map]
curvature_per_mm = 1.0
[film]
pitch_um = 2000.0
depth_um = 1000.0
[stack.override]
lamp_radius_mm = 0.2
lamp_height_mm = 0.5
panel_width_mm = 4.0
panel_length_mm = 2.0
lamp_count = 1
lamp_pitch_mm = 4.0
"""


def test_a_film_beyond_the_process_says_what_would_make_it_and_that_makes_it(tmp_path):
    (tmp_path / "job.toml").write_text(BIG)
    refused(
        called("mask", "job.toml", "--plan", cwd=tmp_path),
        "job.toml: map: grooves 0-1: curvature_per_mm 1 … 1: expected 1.666 … 2, ",
        "process.calibration or mask.mesh that fills 0.3333, or film.profile = 'ideal'",
    )
    own = 'kind = "volume"\nsource = "own"\ntransfer_factor = 0.5\n'
    own += "[groove]\npitch_um = 2000.0\ndepth_um = 1000.0\n"
    (tmp_path / "own.toml").write_text("schema = 1\n" + own)
    (tmp_path / "job.toml").write_text(BIG + '[process]\ncalibration = "own.toml"\n')
    result = called("mask", "job.toml", "--format", "oas", "--out", "out", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    screen = json.loads((tmp_path / "out" / "screen.json").read_text())
    assert screen["aperture_ratio"]["max"] == pytest.approx(2 / 3, abs=1e-4)
