"""Curvature maps: where a lookup lands, what is read, and every refusal in one line."""

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.film import (
    CurvatureMap,
    Groove,
    build_curvature_map,
    check_curvature,
    read_curvature_table,
    write_curvature_map,
)

BEF = Groove(0.050, 0.025)
PITCH, WIDTH = 32.69, 392.28
HEADER = "position_mm,curvature_per_mm"


def read(path, **given):
    given = {"extent": "pitch", "repeat": "mirror", "profile": "filled"} | given
    return build_curvature_map(
        read_curvature_table(path), groove=BEF, lamp_pitch=PITCH, panel_width=WIDTH, **given
    )


def write(path, rows, header=HEADER):
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def rows_of(position, curvature):
    return [f"{x!r},{c!r}" for x, c in zip(position.tolist(), curvature.tolist(), strict=True)]


@pytest.fixture
def half():
    """Return a good mirrored map."""
    position = np.linspace(0, PITCH / 2, 34)
    return position, 55 + 5 * np.cos(position)


@given(st.integers(-20_000, 20_000), st.integers(-6, 6))
def test_mirrored_lookup_is_exactly_symmetric_and_periodic(steps, lamps):
    position = np.linspace(0, PITCH / 2, 34)
    cmap = CurvatureMap(position, 55 + 5 * np.sin(7 * position), "pitch", "mirror")
    lamp, offset = 16.345, steps * 1e-3
    here = cmap.on_grooves([lamp + offset], PITCH, lamp)
    for other in (lamp - offset, lamp + offset + lamps * PITCH):
        assert cmap.on_grooves([other], PITCH, lamp) == here


def test_mirrored_map_on_a_centred_panel_is_exactly_symmetric(half):
    centres = (np.arange(7846) + 0.5) * 0.05
    lamp = 7846 * 0.05 / 2 + 0.5 * PITCH
    curvature = CurvatureMap(*half, "pitch", "mirror").on_grooves(centres, PITCH, lamp)
    assert np.array_equal(curvature, curvature[::-1])
    assert np.ptp(curvature) > 5


@given(st.floats(-400, 400), st.floats(0, 400))
def test_repeated_lookup_is_linear_between_rows_and_periodic(x, lamp):
    position = np.linspace(0, PITCH, 67)
    truth = 55 + 5 * np.sin(2 * np.pi * position / PITCH)
    cmap = CurvatureMap(position, truth, "pitch", "repeat")
    wanted = np.interp((x - lamp) % PITCH, position, truth)
    assert cmap.on_grooves([x], PITCH, lamp) == pytest.approx(wanted, abs=1e-6)
    assert cmap.on_grooves([x + 3 * PITCH], PITCH, lamp) == pytest.approx(wanted, abs=1e-6)


def test_position_0_is_above_the_lamp(half):
    cmap = CurvatureMap(*half, "pitch", "mirror")
    lamp = 50.0
    assert cmap.on_grooves([lamp], PITCH, lamp) == half[1][0]
    assert cmap.on_grooves([lamp + PITCH / 2], PITCH, lamp) == pytest.approx(half[1][-1])


def test_panel_map_is_read_as_it_stands(tmp_path):
    position = np.linspace(0, WIDTH, 1000)
    path = write(tmp_path / "m.csv", rows_of(position, position / 10 + 2))
    cmap = read(path, extent="panel", repeat="repeat")
    assert cmap.on_grooves([100.0], PITCH, 3.0) == pytest.approx(12.0, abs=1e-12)


def test_uniform_gives_every_groove_the_same():
    assert CurvatureMap.uniform(60.0).on_grooves([0.0, 5.0, 400.0], PITCH, 3.0).tolist() == [60] * 3


def test_csv_and_npz_read_alike(tmp_path, half):
    text = write(tmp_path / "m.csv", rows_of(*half))
    np.savez(tmp_path / "m.npz", position_mm=half[0], curvature_per_mm=half[1])
    for cmap in (read(text), read(tmp_path / "m.npz")):
        assert np.array_equal(cmap.position, half[0])
        assert np.array_equal(cmap.curvature, half[1])


def test_cell_centred_ends_are_within_tolerance(tmp_path):
    position = np.arange(0.025, PITCH / 2, 0.05)
    read(write(tmp_path / "m.csv", rows_of(position, 60 + 0 * position)))


def change(index, text):
    def apply(rows):
        rows[index] = text
        return rows

    return apply


GOOD = 16.345 / 33
REFUSALS = {
    "not a number": (change(2, f"{2 * GOOD},abc"), ["row 4", "curvature_per_mm 'abc'"]),
    "python number": (change(2, f"{2 * GOOD},5_0"), ["row 4", "'5_0'"]),
    "empty field": (change(2, f"{2 * GOOD},"), ["row 4", "''"]),
    "too many fields": (change(2, "1,2,3"), ["row 4", "3 fields", "expected 2"]),
    "nan": (change(3, f"{3 * GOOD},nan"), ["row 5", "curvature_per_mm nan", "finite"]),
    "inf": (change(3, f"{3 * GOOD},inf"), ["row 5", "inf", "0 … 80"]),
    "nan position": (change(3, "nan,50"), ["row 5", "position_mm nan"]),
    "duplicate": (change(4, f"{3 * GOOD},50"), ["row 6", "duplicate of row 5"]),
    "unsorted": (change(4, "0.2,50"), ["row 6", "0.2", "unsorted after row 5", "more than"]),
    "negative": (change(5, f"{5 * GOOD},-3"), ["row 7", "-3", "negative", "0 … 80"]),
    "unprintable": (change(5, f"{5 * GOOD},80.5"), ["row 7", "80.5", "0 … 80", "only be added"]),
    "gap": (lambda rows: rows[:5] + rows[12:], ["row 7", "gap", "after row 6", "2.476"]),
    "starts late": (lambda rows: rows[1:], ["row 2", "starts late", "0 … 16.345 mm"]),
    "ends early": (lambda rows: rows[:-1], ["row 34", "ends early", "0 … 16.345 mm"]),
    "outside": (lambda rows: [*rows, "16.9,50"], ["row 36", "16.9", "outside", "mirror"]),
    "negative position": (lambda rows: ["-1,50", *rows], ["row 2", "-1", "outside"]),
    "per µm": (
        lambda rows: [r.split(",")[0] + ",0.06" for r in rows],
        ["row 2", "0.06", "1/µm", "1000"],
    ),
    "no rows": (lambda rows: [], ["no rows"]),
}


def one_line(error, path, words):
    text = str(error.value)
    assert "\n" not in text
    assert text.startswith(f"{path}: ")
    assert "expected" in text
    for word in words:
        assert word in text


@pytest.mark.parametrize("name", REFUSALS)
def test_refusals_name_file_row_value_and_range(tmp_path, half, name):
    edit, words = REFUSALS[name]
    path = write(tmp_path / "m.csv", edit(rows_of(*half)))
    with pytest.raises(InputError) as error:
        read(path)
    one_line(error, path, words)


@pytest.mark.parametrize("header", ["position,curvature", "position_mm;curvature_per_mm", ""])
def test_wrong_header_is_refused(tmp_path, half, header):
    path = write(tmp_path / "m.csv", rows_of(*half), header)
    with pytest.raises(InputError) as error:
        read(path)
    one_line(error, path, ["row 1", "header", HEADER])


def test_files_that_are_no_maps_are_refused(tmp_path, half):
    (tmp_path / "m.npz").write_bytes(b"not a zip")
    (tmp_path / "latin.csv").write_bytes(HEADER.encode() + b"\n\xb5,3\n")
    (tmp_path / "m.xlsx").write_bytes(b"")
    np.savez(tmp_path / "one.npz", position_mm=half[0])
    np.savez(tmp_path / "flat.npz", position_mm=half[0], curvature_per_mm=half[1][None])
    np.savez(tmp_path / "short.npz", position_mm=half[0], curvature_per_mm=half[1][1:])
    names = ["absent.csv", "m.npz", "latin.csv", "m.xlsx", "one.npz", "flat.npz", "short.npz"]
    for name in names:
        with pytest.raises(InputError) as error:
            read(tmp_path / name)
        assert "\n" not in str(error.value)
        assert str(error.value).startswith(f"{tmp_path / name}: ")


def test_npz_refusal_names_the_entry(tmp_path, half):
    half[1][7] = np.nan
    np.savez(tmp_path / "m.npz", position_mm=half[0], curvature_per_mm=half[1])
    with pytest.raises(InputError, match=r"entry 7 \(counted from 0\): curvature_per_mm nan"):
        read(tmp_path / "m.npz")


def test_line_number_counts_blank_lines(tmp_path, half):
    rows = rows_of(*half)
    path = write(tmp_path / "m.csv", [*rows[:3], "", "", f"{3 * GOOD},-1", *rows[4:]])
    with pytest.raises(InputError, match="row 7: curvature_per_mm -1"):
        read(path)


def test_repeated_map_must_meet_itself(tmp_path):
    position = np.linspace(0, PITCH, 67)
    path = write(tmp_path / "m.csv", rows_of(position, np.linspace(50, 60, 67)))
    with pytest.raises(InputError, match=r"row 68: .* 60: the map repeats.*expected 50 ± 0.5"):
        read(path, repeat="repeat")


def test_ideal_profile_may_exceed_the_printable_limit(tmp_path, half):
    path = write(tmp_path / "m.csv", rows_of(half[0], half[1] + 40))
    assert read(path, profile="ideal").curvature.max() > 95
    with pytest.raises(InputError, match="not printable"):
        read(path)


@pytest.mark.parametrize("value", [0.0, 1.5, 60.0, 80.0])
def test_good_uniform_curvature_passes(value):
    check_curvature(value, BEF, "filled", "job.toml: map.curvature_per_mm")


@pytest.mark.parametrize("value", [-1.0, 0.06, 80.1, float("nan")])
def test_bad_uniform_curvature_is_refused(value):
    with pytest.raises(InputError) as error:
        check_curvature(value, BEF, "filled", "job.toml: map.curvature_per_mm")
    one_line(error, "job.toml: map.curvature_per_mm", [f"{value:g}"])


def test_export_table(tmp_path):
    path, again = tmp_path / "curvature.csv", tmp_path / "again.csv"
    for target in (path, again):
        write_curvature_map(
            target,
            [0.025, 0.075],
            [60.0, 80.0],
            groove=BEF,
            profile="filled",
            aperture_ratio=[0.06, 0.0],
        )
    assert path.read_bytes() == again.read_bytes()
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))
    assert [row["groove"] for row in rows] == ["0", "1"]
    assert float(rows[0]["fitted_curvature_per_mm"]) == pytest.approx(64.4, abs=0.05)
    assert float(rows[0]["fill_fraction"]) == pytest.approx(2 / 27)
    assert float(rows[1]["aperture_ratio"]) == 0
    assert [p.name for p in sorted(tmp_path.iterdir())] == ["again.csv", "curvature.csv"]
