"""The printing process: its one published pair, both directions, and what a calibration may say."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import (
    Groove,
    check_aperture_ratio,
    check_printable,
    groove_ranges,
    read_process,
)
from mpfcad.film.process.file import PUBLISHED

BEF = Groove(0.050, 0.025)
THESIS = Path(__file__).parents[2] / "masks" / "process-thesis.toml"
DEFAULT = read_process(None, BEF)
TABLE = """
schema = 1
kind = "table"
source = "prints of a test"
[[row]]
aperture_ratio = 0.05
fitted_curvature_per_mm = 66.0
[[row]]
aperture_ratio = 0.10
curvature_per_mm = 54.59
[[row]]
aperture_ratio = 0.60
fill_fraction = 0.7
"""


def write(path, text):
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return read_process(write(tmp_path_factory.mktemp("process") / "t.toml", TABLE), BEF)


def test_published_pair_is_met_as_a_fitted_curvature():
    curvature = DEFAULT.curvature(0.10)
    assert BEF.fitted_curvature(curvature) == pytest.approx(58.0, abs=1e-9)
    assert curvature == pytest.approx(54.59, abs=0.005)
    assert DEFAULT.transfer_factor == pytest.approx(1.2487, abs=5e-5)


def test_caveat_figures_are_right():
    assert BEF.fill_fraction(58.0) / 0.10 == pytest.approx(0.911, abs=5e-4)
    assert BEF.curvature_of_fitted(58.0) == pytest.approx(54.6, abs=0.05)
    assert "0.911" in DEFAULT.caveats[1]
    assert "54.6" in DEFAULT.caveats[1]


def test_file_and_built_in_calibration_are_the_same():
    assert tomllib.loads(THESIS.read_text(encoding="utf-8")) == PUBLISHED
    assert read_process(THESIS, BEF).describe() == DEFAULT.describe()


@given(st.floats(0, 1))
def test_round_trip_of_the_volume_model(share):
    ratio = share * DEFAULT.aperture_ratio_max
    assert DEFAULT.aperture_ratio(DEFAULT.fill_fraction(ratio)) == pytest.approx(ratio, abs=1e-14)
    there = DEFAULT.aperture_ratio_of_curvature(DEFAULT.curvature(ratio))
    assert there == pytest.approx(ratio, abs=1e-13)


@given(share=st.floats(0, 1))
def test_round_trip_of_a_table(table, share):
    ratio = share * table.aperture_ratio_max
    assert table.aperture_ratio(table.fill_fraction(ratio)) == pytest.approx(ratio, abs=1e-14)
    there = table.aperture_ratio_of_curvature(table.curvature(ratio))
    assert there == pytest.approx(ratio, abs=1e-12)


def test_more_aperture_is_more_fill_and_less_curvature(table):
    for process in (DEFAULT, table):
        ratio = np.linspace(0, process.aperture_ratio_max, 500)
        assert np.all(np.diff(process.fill_fraction(ratio)) > 0)
        assert np.all(np.diff(process.curvature(ratio)) < 0)


def test_no_aperture_is_an_empty_groove(table):
    for process in (DEFAULT, table):
        assert process.curvature(0.0) == pytest.approx(80.0, abs=1e-9)
        assert process.aperture_ratio_of_curvature(80.0) == 0


def test_table_passes_through_its_rows(table):
    assert BEF.fitted_curvature(table.curvature(0.05)) == pytest.approx(66.0, abs=1e-9)
    assert table.curvature(0.10) == pytest.approx(54.59, abs=1e-9)
    assert table.fill_fraction(0.60) == 0.7
    assert table.transfer_factor is None


def test_describe_is_json(table):
    for process in (DEFAULT, table):
        told = json.loads(json.dumps(process.describe()))
        assert told["source"]
        assert told["kind"] == process.kind
    assert len(table.describe()["table"]) == 4


def test_the_same_resin_fills_a_groove_half_as_deep_twice():
    shallow = read_process(None, Groove(0.025, 0.0125))
    assert shallow.transfer_factor == pytest.approx(2 * DEFAULT.transfer_factor)
    assert shallow.fill_fraction_max == 1


def test_transfer_factor_may_be_given(tmp_path):
    text = 'schema = 1\nkind = "volume"\nsource = "x"\ntransfer_factor = 0.8\n'
    process = read_process(write(tmp_path / "p.toml", text), BEF)
    assert process.fill_fraction(0.5) == pytest.approx(0.4, abs=1e-15)
    assert (process.aperture_ratio_max, process.fill_fraction_max) == (1, pytest.approx(0.8))


HEAD = 'schema = 1\nkind = "volume"\nsource = "x"\n'
BAD = {
    "not TOML": ("kind = ", ["not TOML"]),
    "unknown key": (HEAD + "transfer_factor = 1.2\nfactor = 2", ["factor: 2: unknown key"]),
    "unknown key of a row": (
        TABLE.replace("curvature_per_mm = 54.59", "curvature_per_mm = 54.59\nsmile = 3"),
        ["row 2.smile: 3: unknown key"],
    ),
    "kind": ('schema = 1\nkind = "guess"\nsource = "x"', ["kind: 'guess'", "volume"]),
    "schema": (HEAD.replace("1", "7") + "transfer_factor = 1.0", ["schema: 7"]),
    "no source": ('schema = 1\nkind = "volume"\ntransfer_factor = 1.0', ["source"]),
    "text for number": (HEAD + 'transfer_factor = "1.2"', ["transfer_factor: '1.2'"]),
    "zero factor": (HEAD + "transfer_factor = 0.0", ["transfer_factor: 0.0", "greater than 0"]),
    "nan": (HEAD + "transfer_factor = nan", ["transfer_factor: nan", "finite"]),
    "percent": (
        HEAD + "[pair]\naperture_ratio = 10\nfitted_curvature_per_mm = 58",
        ["pair.aperture_ratio: 10", "less than or equal to 1"],
    ),
    "both curvatures": (
        HEAD + "[pair]\naperture_ratio = 0.1\nfitted_curvature_per_mm = 58\ncurvature_per_mm = 54",
        ["pair", "exactly one of"],
    ),
    "pair and factor": (
        HEAD + "transfer_factor = 1.0\n[pair]\naperture_ratio = 0.1\ncurvature_per_mm = 58",
        ["exactly one of [pair] and transfer_factor"],
    ),
    "fitted too high": (
        HEAD + "[pair]\naperture_ratio = 0.1\nfitted_curvature_per_mm = 78",
        ["pair", "78", "0 … 75"],
    ),
    "too high": (TABLE.replace("54.59", "85"), ["row 2", "curvature_per_mm: 85", "0 … 80"]),
    "fills nothing": (
        HEAD + "[pair]\naperture_ratio = 0.1\ncurvature_per_mm = 80",
        ["pair", "fill_fraction 0", "not monotone"],
    ),
    "table not growing": (TABLE.replace("0.60", "0.08"), ["row 3", "0.08", "0.1 of row 2"]),
    "fill not growing": (
        TABLE.replace("fill_fraction = 0.7", "fill_fraction = 0.11"),
        ["row 3", "fill_fraction 0.11", "row 2"],
    ),
    "table of one": (TABLE.split("[[row]]\naperture_ratio = 0.10")[0], ["two or more"]),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_calibrations_are_refused_in_one_line(tmp_path, name):
    text, words = BAD[name]
    path = write(tmp_path / "p.toml", text)
    with pytest.raises(InputError) as error:
        read_process(path, BEF)
    message = str(error.value)
    assert "\n" not in message
    assert message.startswith(f"{path}: ")
    for word in words:
        assert word in message


def test_missing_calibration_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"none\.toml: no such file"):
        read_process(tmp_path / "none.toml", BEF)


def test_what_the_process_cannot_reach_is_refused(table):
    check_printable(DEFAULT, [0.0, 60.0, 80.0], "job")
    check_printable(table, [table.curvature_min, 80.0], "job")
    low = table.curvature_min
    with pytest.raises(InputError, match=r"^job: grooves 1-2, 4: .*5 … 17: expected 18 … 80"):
        check_printable(table, [60, 5, 17, 60, low - 2], "job")
    with pytest.raises(InputError, match="groove 0: "):
        check_printable(DEFAULT, [81.0], "job")
    a_little_more = table.groove.curvature_of_fill(table.fill_fraction_max * 1.001)
    with pytest.raises(InputError, match="groove 0: "):
        check_printable(table, [a_little_more], "job")


def test_aperture_ratios_out_of_range_are_refused():
    check_aperture_ratio(DEFAULT, [0, DEFAULT.aperture_ratio_max], "field")
    for value in (-0.01, 0.81, 1.2, float("nan")):
        with pytest.raises(InputError, match=r"^field: aperture_ratio .*expected 0 … 0\.8008"):
            check_aperture_ratio(DEFAULT, [0.1, value], "field")


def test_groove_ranges():
    assert groove_ranges([7]) == "groove 7"
    assert groove_ranges([12, 13, 14, 600]) == "grooves 12-14, 600"
    assert groove_ranges(np.arange(0, 40, 2)).endswith("10, … (20 in all)")
