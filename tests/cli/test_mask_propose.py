"""`mpfcad mask --propose` and `mask.mesh = "auto"`."""

import json
from itertools import pairwise

import numpy as np
import pytest

from mpfcad.cli import run_app
from mpfcad.mask.pattern.levelling import levelling_residual
from mpfcad.mask.screen.slot_ripple import slot_ripple

PANEL = "[stack.override]\npanel_width_mm = 34.0\npanel_length_mm = 60.0\nlamp_count = 1\n"


def job(folder, map_table, rest):
    text = f'schema = 1\nname = "job"\n[map]\n{map_table}\n{rest}\n{PANEL}'
    (folder / "job.toml").write_text(text, "utf-8")


@pytest.fixture
def patterned(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [[0.0, 46.0], [16.0, 66.0], [34.0, 46.0]]
    return lambda rest: job(tmp_path, f'rows = {rows}\nextent = "panel"', rest)


def test_proposals_are_a_table_best_first(patterned, capsys):
    patterned("")
    assert run_app(["mask", "job.toml", "--propose", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["proposals"]
    assert len(rows) >= 8
    margins = [row["margin"] for row in rows]
    assert all(b <= a + 0.05 for a, b in pairwise(margins))
    best = rows[0]
    assert best["margin"] > 1.2
    assert 0.1 < best["aperture_ratio"][0] < best["aperture_ratio"][1] < 0.85
    assert run_app(["mask", "job.toml", "--propose"]) == 0
    assert best["mesh"] in capsys.readouterr().out.splitlines()[2]


def test_the_best_is_given_as_lines_to_paste_and_as_a_command(patterned, tmp_path, capsys):
    patterned("")
    assert run_app(["mask", "job.toml", "--propose"]) == 0
    out = capsys.readouterr().out
    assert "solids: what the resin has to be diluted to; the job's has 100%" in out
    lines, command = out.split("in the job:\n\n")[1].split("\n\nor its mask at once:\n\n")
    patterned(lines)
    assert run_app(["mask", "job.toml", "--plan"]) == 0
    pasted = capsys.readouterr().out
    patterned("")
    words = command.strip().removeprefix("mpfcad ").replace("'", "").split()
    assert run_app([*words, "--plan"]) == 0
    assert capsys.readouterr().out == pasted
    assert run_app(["mask", "job.toml", "--propose", "--json"]) == 0
    best = json.loads(capsys.readouterr().out)["proposals"][0]
    assert best["job_lines"] == lines.splitlines() and best["command"] == command.strip()
    low, high = best["aperture_ratio"]
    assert f"aperture ratio {low:.4g} … {high:.4g}" in pasted


def test_auto_says_when_it_dilutes(patterned, tmp_path, capsys):
    patterned('[mask]\nmesh = "auto"')
    assert run_app(["mask", "job.toml", "--format", "oas", "--out", "out"]) == 0
    process = json.loads((tmp_path / "out" / "screen.json").read_text("utf-8"))["process"]
    assert "solids, the job's has 100%" in str(process["caveats"])


def test_auto_takes_the_best_says_why_and_its_screen_passes(patterned, tmp_path, capsys):
    patterned('[mask]\nmesh = "auto"')
    assert run_app(["mask", "job.toml", "--propose", "--json"]) == 0
    best = json.loads(capsys.readouterr().out)["proposals"][0]
    assert run_app(["mask", "job.toml", "--format", "oas", "--out", "out"]) == 0
    screen = json.loads((tmp_path / "out" / "screen.json").read_text("utf-8"))
    assert screen["printability"] == "PASS"
    # What was computed of the mesh stays so: the choice does not make it a weaver's figure.
    assert screen["mesh"]["name"] == best["mesh"]
    assert ("computed" in screen["mesh"]["source"]) != best["sourced"]
    assert screen["mesh"]["threads_per_cm"] == pytest.approx(float(best["mesh"].split("-")[0]))
    # The panel holds a whole number of periods.
    assert screen["period_um"] == pytest.approx(best["period_um"], rel=0.01)
    assert f"mesh {best['mesh']}, period {best['period_um']:g} µm" in str(screen["process"])
    found = screen["printing"]["ripple_curvature_per_mm"]
    assert found == pytest.approx(best["ripple_curvature_per_mm"], abs=2e-3)


@pytest.mark.parametrize("curvature", [77.0, 79.95])  # of the second no period holds anything
def test_a_map_that_no_mesh_prints_names_grooves_and_the_nearest_one(
    patterned, tmp_path, capsys, curvature
):
    job(tmp_path, f"curvature_per_mm = {curvature}", '[mask]\nmesh = "auto"')
    assert run_app(["mask", "job.toml", "--plan"]) == 2
    line = capsys.readouterr().err.removeprefix("mpfcad: ")
    stated = f"{curvature:g} … {curvature:g}"
    assert line.startswith(f"job.toml: map: grooves 0-679: curvature_per_mm {stated}: no mesh of")
    assert "nearest map it prints" in line and len(line) <= 301
    ends = [float(x) for x in line.split("expected ")[1].split(" or ")[0].split(" … ")]
    # The map that it names is printed, by a choice of the program's.
    inside = min(max(curvature, ends[0] + 0.01), ends[1] - 0.01)
    job(tmp_path, f"curvature_per_mm = {inside}", '[mask]\nmesh = "auto"')
    assert run_app(["mask", "job.toml", "--plan"]) == 0


def test_a_weaver_s_table_is_what_is_proposed_from(patterned, tmp_path, capsys):
    header = "name,material,threads_per_cm,thread_um,opening_um,thickness_um,source\n"
    (tmp_path / "weaver.csv").write_text(header + "325-16,steel,128,16,62,34,sheet\n", "utf-8")
    patterned('[mask.mesh]\nname = "auto"\ncatalogue = "weaver.csv"\n')
    assert run_app(["mask", "job.toml", "--propose", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["proposals"]
    assert [row["mesh"] for row in rows] == ["325-16"]


def test_the_ripple_s_closed_form_is_that_of_the_mask():
    from mpfcad.film import Groove, PrismFilm, read_process
    from mpfcad.mask import MaskRules, build_mask

    groove = Groove(0.050, 0.025)
    process = read_process(None, groove)
    for period, length in ((1.0, 1.0), (2.0, 1.0), (2.0, 0.4)):
        rules = MaskRules("slot", period, 0.015, 0.015, levelling_length=length)
        film = PrismFilm(groove, 0.2, 200.0, "filled", np.full(4, 55.0))
        mask = build_mask(film, process, rules, "job")
        found = levelling_residual(mask)
        wanted = slot_ripple(found.groove_ratio[0], mask.period, length)
        assert found.groove_rms[0] == pytest.approx(float(wanted), rel=0.03)


def test_a_map_of_both_directions_prints_through_auto(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    x, y = np.linspace(0, 34, 18), np.linspace(0, 60, 31)
    names = ("position_across_mm", "position_along_mm", "curvature_per_mm")
    curvature = 57 + 5 * np.cos(x / 5) * np.cos(y[:, None] / 9)
    np.savez("field.npz", **dict(zip(names, (x, y, curvature), strict=True)))
    job(tmp_path, 'file = "field.npz"\nextent = "panel"', '[mask]\nmesh = "auto"')
    assert run_app(["mask", "job.toml", "--format", "oas", "--out", "out"]) == 0
    screen = json.loads((tmp_path / "out" / "screen.json").read_text("utf-8"))
    gates = {gate["name"]: gate for gate in screen["gates"]}
    assert screen["printability"] == "PASS"
    # Ratios are those of the map's ends, not of whole grooves' means.
    low, high = screen["order"]["aperture_ratio"]
    assert high > 1.8 * low
    assert gates["screen_ratio_min"]["value"] == pytest.approx(low, abs=1e-3)
    # A slot drawn groove by groove is one aperture: its length counts, not the groove's width.
    assert gates["screen_aperture_um"]["value"] > 50.5
    # From the export alone: mirrored, and back to the same bytes.
    for path in tmp_path.glob("*.npz"):
        path.unlink()
    again = ("--format", "oas", "--out")
    assert run_app(["mask", "out", "--mirror", *again, "mirrored"]) == 0
    assert run_app(["mask", "mirrored", "--no-mirror", *again, "back"]) == 0
    files = [(tmp_path / name / "mask.oas").read_bytes() for name in ("out", "mirrored", "back")]
    assert files[0] == files[2] != files[1]
