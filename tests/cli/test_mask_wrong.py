"""Wrong `[mask]` and `[process]` tables: one line with the job's file, the field and the value."""

import pytest

from mpfcad.cli import run_app

JOB = """name = "bad"
[map]
curvature_per_mm = 60.0
{}
[stack.override]
panel_width_mm = 34.0
panel_length_mm = 60.0
lamp_count = 1
"""
FLOW = "viscosity_pa_s = 1\nsurface_tension_mn_m = 30\ntime_to_uv_s = 10\ncontact_angle_deg = "
WRONG = [
    ("mesh = 120", 'mask.mesh: 120: expected a name such as "120-34", "auto", or a table'),
    ("mesh = true", "mask.mesh: True: expected a name"),
    ('mesh = ["120-34"]', "mask.mesh: ['120-34']: expected a name"),
    ('mesh = ""', "mask.mesh: '': not in the catalogue: expected a name such as"),
    ("mesh = {}", "mask.mesh: {}: expected either name, or threads_per_cm and thread_um"),
    ("mesh = { name = 120 }", "mask.mesh.name: 120: expected a valid string"),
    ('mesh = { name = "120-34", release = 1.46 }', "mask.mesh.release: 1.46: expected less than"),
    ('mesh = { name = "120-34", emulsion_um = -3 }', "mask.mesh.emulsion_um: -3: expected"),
    (
        'mesh = { name = "120-34", catalogue = "none.csv" }',
        "mask.mesh.catalogue: none.csv: no such file: expected a table of meshes",
    ),
    (
        'mesh = { name = "120-34", ink_volume_cm3_m2 = 20 }',
        "mask.mesh: {name, ink_volume_cm3_m2}: ink_volume_cm3_m2: expected to be left out",
    ),
    ("mesh = { threads_per_cm = 120, thread_um = 34, material = 'nylon' }", "mask.mesh.material"),
    ("mesh = { threads_per_cm = 120, thread_um = 34, opening_um = 80 }", "mask.mesh.opening_um"),
    ("mesh = { threads_per_cm = 120, thread_um = 34, thickness_um = 5 }", "mask.mesh.thickness_um"),
    ("mesh = { threads_per_cm = 900, thread_um = 3 }", "mask.mesh.threads_per_cm: 900: expected 5"),
    ("pattern = 3", "mask.pattern: 3: expected 'slot'"),
    ('period_um = "400"', "mask.period_um: '400': expected a valid number"),
    ("period_um = nan", "mask.period_um: nan: expected a finite number"),
    ("period_um = 0.1", "mask.period_um: 0.1: expected greater than or equal to 1"),
    ("formats = []", "mask.formats: []: expected at least 1 item"),
    ('formats = "oas"', "mask.formats: 'oas': expected a valid list"),
    ('formats = ["pdf"]', "mask.formats.0: pdf: expected 'oas'"),
    ('formats = ["oas", "oas"]', "mask.formats: ['oas', 'oas']: expected 'oas' once"),
    ('polarity = "negative"', "mask.polarity: negative: expected 'open' or 'closed'"),
    ('polarity = "closed"\nformats = ["dxf"]', "mask.polarity: closed: dxf cannot hold"),
    ("mirror = 1", "mask.mirror: 1: expected a valid boolean"),
    ("frame_mm = [100]", "mask.frame_mm: [100]: expected at least 2 items"),
    ("frame_mm = [10.0, 10.0]", "mask.frame_mm: 10 x 10: expected more than the artwork"),
    ('revision = "a b"', "mask.revision: a b: expected 1 to 16 letters, digits"),
    ("tif_dpi = 100", "mask.tif_dpi: 100: expected greater than or equal to 2540"),
    ('furniture = ["logo"]', "mask.furniture.0: logo: expected 'fiducial'"),
    ('squeegee = "diagonal"', "mask.squeegee: diagonal: expected 'along' or 'across'"),
    ("min_aperture_um = 0", "mask.min_aperture_um: 0: expected greater than 0"),
    ("min_web_um = 500", "mask: {min_web_um}: min_aperture_um + min_web_um = 515: expected"),
    ('pattern = "dot"\ndot_um = 20', "dot_um = 20: expected with pattern 'blue-noise'"),
    ('pattern = "blue-noise"\ndot_um = 300', "mask.dot_um: 300: expected 21.21 … 35 µm"),
    ('pattern = "dot"\nmesh = "120-34"', "mask.period_um: 400: no aperture fits"),
    ('mesh = "120-34"\nperiod_um = 300', "map: grooves 0-679: curvature_per_mm 60"),
    ('mesh = "180-27"\n[process]\nmodel = "thesis"', "mask.mesh: 180-27: the process lays down"),
    (f'mesh = "180-27"\n[process]\n{FLOW}60', "process.contact_angle_deg: 60: expected below 45"),
    (f'mesh = "180-27"\nlevelling_length_mm = 2\n[process]\n{FLOW}9', "mask.levelling_length_mm"),
    ('[process]\nmodel = "prior"', "process.model: prior: expected a [mask.mesh]"),
]


@pytest.mark.parametrize(("table", "words"), WRONG)
def test_a_wrong_mask_is_one_line_with_file_field_and_value(
    tmp_path, monkeypatch, capsys, table, words
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "job.toml").write_text(JOB.format(f"[mask]\n{table}"), "utf-8")
    assert run_app(["mask", "job.toml", "--plan"]) == 2
    (line,) = (text for text in capsys.readouterr().err.splitlines() if text.startswith("mpfcad"))
    assert line.startswith("mpfcad: job.toml: ") and words in line
    assert "expected" in line and len(line) <= 300


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--mesh", "999-1"), "mask.mesh: '999-1': not in the catalogue"),
        (("--emulsion-um", "-1", "--mesh", "120-34"), "mask.mesh.emulsion_um: -1"),
        (("--period-um", "0"), "mask.period_um: 0"),
        (("--solids", "2"), "process.solids_fraction: 2"),
        (("--polarity", "no"), "mask.polarity: no"),
        (("--revision", ""), "mask.revision: : expected 1 to 16"),
    ],
)
def test_a_wrong_option_names_the_field_that_it_sets(tmp_path, monkeypatch, capsys, options, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "job.toml").write_text(JOB.format(""), "utf-8")
    assert run_app(["mask", "job.toml", "--plan", *options]) == 2
    assert words in capsys.readouterr().err
