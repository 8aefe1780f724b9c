"""`mpfcad fit`: one line for each fault; a small backlight fitted end to end, twice alike."""

import json

import numpy as np
import pytest
from command import content

from mpfcad.backlight import read_stack
from mpfcad.confidence import read_covariance
from mpfcad.errors import InputError
from mpfcad.job.fit import read_fit
from mpfcad.pipeline import FitSetting, fit_backlight
from mpfcad.pipeline.fit.case import build_cases, read_backlight
from mpfcad.pipeline.fit.data import read_data
from mpfcad.pipeline.fit.sought import find_unknowns
from mpfcad.pipeline.fit.stack_file import stack_text

SMALL = """
name = "small"
values = ["reflector_reflectance", "top_sheet_sigma"]

[stack]
preset = "thesis-32in-mpf"

[stack.override]
reflector_reflectance = { value = 0.9, sigma = 0.05 }

[case.mpf]
curvature_per_mm = 60.0

[case.bef]

[[measurement]]
case = "mpf"
over = "bef"
of = "luminance"
value = 0.94
sigma = 0.004

[[measurement]]
case = "mpf"
of = "luminance"
value = 7000.0
sigma = 70.0
"""


def written(tmp_path, text=SMALL, **files):
    for name, content_of in files.items():
        (tmp_path / name.replace("_csv", ".csv")).write_text(content_of)
    path = tmp_path / "fit.toml"
    path.write_text(text)
    return path


def refused(path, setting=None):
    with pytest.raises(InputError) as error:
        fit_backlight(read_fit(path), path, path.parent / "out", setting)
    assert "\n" not in str(error.value) and len(str(error.value)) <= 300
    assert not (path.parent / "out").exists()
    return str(error.value)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (('case = "mpf"\nof', 'case = "slim"\nof'), "measurement 2: case: slim: no such case"),
        (('of = "luminance"\nvalue = 0', 'of = "haze"\nvalue = 0'), "measurement.0.of: haze: exp"),
        (('["reflector_reflectance", "top_sheet_sigma"]', "[]"), "values: .*at least 1"),
        (('["reflector', '["top_sheet_sigma", "reflector'), "values: top_sheet_sigma: named tw"),
        (("[case.bef]\n\n[[measurement]]", "override = { reflector_reflectance = 0.9, "
          "top_sheet_sigma = 0.3, lamp_luminance_cd_m2 = 1e4 }\n\n[case.bef]\n\n[[measurement]]\n"
          'case = "mpf"\nof = "contrast"\nvalue = 0.02\nsigma = 0.01\n\n[[measurement]]'),
         "measurement: mpf: contrast: case.mpf has none of the values sought"),
        (("sigma = 70.0", "sigma = 0.0"), "measurement.1.sigma: 0.0: expected"),
        (("sigma = 70.0", "sigma = -1.0"), "measurement.1.sigma: -1.0: expected"),
        (("sigma = 70.0", "sigma = 1e300"), "measurement.1.sigma: 1e\\+300: expected"),
        (("sigma = 70.0", "sigma = 1e-300"), "measurement.1.sigma: 1e-300: expected"),
        (("value = 0.94", "value = 1e300"), "measurement.0.value: 1e\\+300: expected"),
        (("sigma = 70.0", "sigma = nan"), "measurement.1.sigma: nan: expected"),
        (('over = "bef"', 'over = "mpf"'), "measurement 1: over: mpf: is its own case"),
        (("value = 0.94", "value = 0.0"), "value: 0: luminance over bef: expected a value above"),
        (("value = 7000.0", "value = -2.0"), "value: -2: luminance: expected a value above 0"),
        (("value = 7000.0", "at_most = inf"), "measurement.1.at_most: inf: expected"),
        *[
            (('of = "luminance"\nvalue = 7000.0', f'of = "{of}"\n{key} = {value}'),
             f"{key}: {value}: {of}: expected {wanted}")
            for of, key, value, wanted in (
                ("efficiency", "value", 1.2, "0 … 1"), ("efficiency", "at_least", -0.1, "0 … 1"),
                ("contrast", "value", 1.8, "0 … 1"), ("contrast", "at_most", -0.01, "0 … 1"),
                ("fwhm_across_deg", "value", 180.5, "0 … 180"), ("flux", "value", -0.5, "a value"),
            )
        ],
        (("sigma = 70.0", ""), "sigma: expected the standard error"),
        (("value = 7000.0", ""), "expected one of value, at_most, at_least"),
        (("curvature_per_mm = 60.0", "curvature_per_mm = 90.0"), "90: expected at most 80"),
        (("[case.bef]", '[case.bef]\nlayers = ["glass", "film"]'), "bef.layers: glass: expected"),
        (("[case.bef]", '[case.bef]\nfilm = "no.stl"'), "bef.film: .*no such file"),
        (("[case.bef]", "[case.bef]\nradius = 3"), "case.bef.radius: 3: unknown key; known: lay"),
        (('"top_sheet_sigma"', '"lamp_count"'), "lamp_count: expected values that are not exact"),
        (('"top_sheet_sigma"', '"top_sigma"'), "top_sigma: expected values that are not exact"),
        (('name = "small"', 'name = "small"\nfree = ["top_sheet_sigma", "plate_index", '
         '"lamp_height_mm"]'), "2 measured numbers for 4 values without prior"),
        (('name = "small"', 'name = "small"\ncovariance = "c.csv"'), "eigenvalue"),
        (("value = 7000.0\nsigma = 70.0", 'value = 1.1\nsigma = 0.1\nover = "bef"\n\n[[predict]]\n'
          'case = "mpf"\nof = "luminance"'), "no measurement states an absolute luminance"),
    ],
)  # fmt: skip
def test_wrong_input_is_one_line(tmp_path, change, says):
    assert change[0] in SMALL
    path = written(
        tmp_path,
        SMALL.replace(*change),
        c_csv="top_sheet_sigma,plate_index\n1e-4,1e-3\n1e-3,1e-4\n",
    )
    with pytest.raises(InputError, match=says):
        raise InputError(refused(path))


def test_only_values_that_change_a_case_are_sought(tmp_path):
    path = written(tmp_path, SMALL.replace('values = ["reflector_reflectance", "top_sheet_sigma"]',
                                           ""))  # fmt: skip
    fit = read_fit(path)
    stack = read_backlight(fit, path)
    (tmp_path / "made").mkdir()
    cases = build_cases(fit, path, stack, tmp_path / "made")
    unknowns, active = find_unknowns(fit, path, stack, cases)
    # A clear plate does not scatter; a luminance in cd/m² was measured.
    assert "plate_scattering_per_mm" not in unknowns.names
    assert {"thickness_mm", "lamp_luminance_cd_m2", "film_index"} <= set(unknowns.names)
    assert all(row.all() for row in active.values())
    own = SMALL.replace("[case.bef]", "[case.bef]\noverride = { top_sheet_sigma = 0.3 }")
    path.write_text(own)
    (tmp_path / "again").mkdir()
    cases = build_cases(read_fit(path), path, stack, tmp_path / "again")
    unknowns, active = find_unknowns(read_fit(path), path, stack, cases)
    number = unknowns.names.index("top_sheet_sigma")
    assert active["mpf"][number] and not active["bef"][number]


def test_curves_and_cuts_are_read_with_their_errors(tmp_path):
    x = np.arange(0, 66, 1.0)
    light = 7000 * (1 + 0.02 * np.cos(2 * np.pi * (x - 3) / 32.69))
    rows = "\n".join(f"{a},{b:.3f},7.0" for a, b in zip(x, light, strict=True))
    curve = "position_mm,luminance_cd_m2,standard_error\n" + rows
    cut = "angle_deg,luminance\n" + "\n".join(f"{a},{100 - a}" for a in range(-60, 61, 20))
    text = SMALL + """
[[measurement]]
case = "mpf"
of = "curve"
file = "seen.csv"
lamp_at_mm = 3.0
scale_sigma = 0.02

[[measurement]]
case = "mpf"
of = "cut_along"
file = "cut.csv"
sigma = 0.01
"""  # fmt: skip
    path = written(tmp_path, text, seen_csv=curve, cut_csv=cut)
    data, notes = read_data(read_fit(path), path, 32.69)
    cosines, mean, along = data[2:]
    assert cosines.value[0] == pytest.approx(0.02, abs=1e-3)
    assert np.abs(cosines.value[1:]).max() < 1e-3
    # One whole pitch from lamp to lamp.
    error = cosines.covariance[0, 0] ** 0.5
    assert error == pytest.approx(0.001 * (2 / 33) ** 0.5, rel=0.1)
    assert mean.covariance[0, 0] ** 0.5 == pytest.approx(140, rel=0.01)
    assert along.value.mean() == pytest.approx(1) and len(along.label) == 7
    assert len(notes) == 1 and "66 points" in notes[0]
    with pytest.raises(InputError, match=r"measurement 3: seen.csv: .* expected a curve of"):
        read_data(read_fit(path), path, 21.0)
    stated = text.replace("lamp_at_mm = 3.0", "lamp_at_mm = 3.0\npitch_mm = 32.69")
    path.write_text(stated)
    with pytest.raises(InputError, match=r"measurement 3: pitch_mm 32.69: expected .* 21 mm"):
        read_data(read_fit(path), path, 21.0)
    path.write_text(text)
    (tmp_path / "cut.csv").write_text("a,b\n" + "\n".join(f"{a},9" for a in (-1.4, 0, 1.4)))
    with pytest.raises(InputError, match=r"cut.csv: angles within ±1.4: expected degrees"):
        read_data(read_fit(path), path, 32.69)
    for error in (0, -1):
        rows = "\n".join(f"{a},9,{error if a else 1}" for a in (0, 20, 40))
        (tmp_path / "cut.csv").write_text("a,b,c\n" + rows)
        with pytest.raises(InputError, match=rf"cut.csv: row 3: 20, 9, {error}: .*error above 0"):
            read_data(read_fit(path), path, 32.69)
    (tmp_path / "cut.csv").write_text(cut)
    path.write_text(text.replace("sigma = 0.01", ""))
    with pytest.raises(InputError, match=r"cut.csv: no errors: expected a third column, or sigma"):
        read_data(read_fit(path), path, 32.69)


@pytest.mark.slow
def test_a_backlight_is_fitted_and_the_same_again(tmp_path, monkeypatch):
    import mpfcad.pipeline.fit.tracer as tracer

    monkeypatch.setitem(tracer.ROUND_PATHS, "quick", 1.5)
    monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / "store"))
    path = written(tmp_path)
    records = []
    for number, threads in ((1, 1), (2, 2)):
        monkeypatch.setenv("MPFCAD_CACHE", str(tmp_path / f"store{number}"))
        folder = tmp_path / f"out{number}" / "fit"
        records.append(fit_backlight(read_fit(path), path, folder, FitSetting("quick", threads)))
    assert content(tmp_path / "out1" / "fit") == content(tmp_path / "out2" / "fit")
    record = records[0]
    rows = {row["name"]: row for row in record["values"]}
    assert set(rows) == {"reflector_reflectance", "top_sheet_sigma", "lamp_luminance_cd_m2"}
    assert rows["lamp_luminance_cd_m2"]["prior_sigma"] is None
    assert 0 < rows["top_sheet_sigma"]["left"] <= 1
    assert all(abs(row["residual"]) < 1.5 for row in record["data"])
    assert record["measure_next"][0]["left"] <= record["measure_next"][-1]["left"]
    folder = tmp_path / "out1" / "fit"
    fitted = read_stack(folder / "small.toml")
    names, matrix = read_covariance(folder / "covariance.csv")
    assert names == ["reflector_reflectance", "top_sheet_sigma"]
    for i, name in enumerate(names):
        assert fitted[name] == rows[name]["value"]
        assert fitted.quantity[name].sigma == rows[name]["sigma"]
        assert matrix[i, i] == pytest.approx(rows[name]["sigma"] ** 2)
    assert json.loads((folder / "fit.json").read_text())["name"] == "small"
    assert "top_sheet_sigma" in (folder / "fit.html").read_text()


@pytest.mark.parametrize(
    ("contradicts", "settled", "says"),
    [
        (False, True, "0.4 ± 0.01"),
        (True, True, "0.4 ± 0.01; its measurements contradict each other"),
        (False, False, "0.4 ± 0.01; not settled"),
    ],
)
def test_the_stack_says_that_its_fit_does_not_hold(tmp_path, contradicts, settled, says):
    path = written(tmp_path)
    record = {
        "values": [{"name": "top_sheet_sigma", "value": 0.4, "sigma": 0.01}],
        "contradicts": contradicts,
        "settled": settled,
    }
    stack = read_stack("thesis-32in-mpf")
    text = stack_text(read_fit(path), path, stack, record, tmp_path)
    (tmp_path / "fitted.toml").write_text(text, "utf-8")
    assert read_stack(tmp_path / "fitted.toml").quantity["top_sheet_sigma"].source.endswith(says)
