"""Values by a law of the wavelength: published indices, tables, and what is refused."""

import pytest

from mpfcad.backlight import read_stack
from mpfcad.errors import InputError


def stack(folder, entry, wavelength="light_wavelength_nm = 587.5618"):
    path = folder / "stack.toml"
    path.write_text(f'extends = "thesis-32in-mpf"\n[value]\n{wavelength}\nfilm_index = {entry}\n')
    return read_stack(path)


@pytest.mark.parametrize(
    ("entry", "index"),
    [
        # Schott N-BK7, data sheet: n_d = 1.51680.
        ("{ sellmeier = [1.03961212, 0.00600069867, 0.231792344, 0.0200179144, 1.01046945, "
         "103.560653] }", 1.51680),
        ("{ cauchy = [1.5, 0.0042] }", 1.5 + 0.0042 / 0.5875618**2),
        ("{ table_nm = [[450, 1.55], [650, 1.53]], tag = \"sourced\", source = \"x\" }",
         1.55 - 0.02 * (587.5618 - 450) / 200),
    ],
)  # fmt: skip
def test_an_index_is_that_at_the_stacks_wavelength(tmp_path, entry, index):
    found = stack(tmp_path, entry)
    assert found["film_index"] == pytest.approx(index, abs=6e-6)
    row = next(row for row in found.inputs() if row["name"] == "film_index")
    assert "at 587.562 nm" in row["source"]


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("{ cauchy = [0.5, 0.01] }", "film_index: 0.5"),
        ("{ cauchy = [] }", "film_index: cauchy: []: expected numbers"),
        ("{ sellmeier = [1.0] }", "expected pairs B, C"),
        ("{ table_nm = [[600, 1.5], [700, 1.5]] }", "does not cover light_wavelength_nm 587.562"),
        ("{ cauchy = [1.5], value = 1.5 }", "expected one of cauchy, sellmeier, table_nm"),
    ],
)
def test_wrong_laws_are_refused(tmp_path, entry, words):
    with pytest.raises(InputError) as error:
        stack(tmp_path, entry)
    assert words in str(error.value)


def test_without_a_wavelength_it_is_550_nm(tmp_path):
    found = stack(tmp_path, "{ cauchy = [1.5, 0.004] }", "")
    assert found["film_index"] == pytest.approx(1.5 + 0.004 / 0.55**2)


def test_absorption_reflectance_and_transmission_may_be_tables(tmp_path):
    path = tmp_path / "stack.toml"
    path.write_text(
        'extends = "thesis-32in-mpf"\n[value]\nlight_wavelength_nm = 450\n'
        "film_absorption_per_mm = { table_nm = [[400, 0.4], [500, 0.2]] }\n"
        "reflector_reflectance = { table_nm = [[400, 0.9], [500, 0.96]] }\n"
        "sheet_transmission = { table_nm = [[400, 0.9], [450, 0.95]] }\n"
    )
    found = read_stack(path)
    names = ("film_absorption_per_mm", "reflector_reflectance", "sheet_transmission")
    assert [found[name] for name in names] == pytest.approx([0.3, 0.93, 0.95])


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("film_absorption_per_mm = { cauchy = [0.1] }", "cauchy: expected one of table_nm"),
        ("resin_absorption_per_mm = { table_nm = [[400, 1], [500, 1]] }", "does not cover"),
        ("film_absorption_per_mm = { table_nm = [[400, -1], [700, -1]] }", "-1"),
        (
            "film_absorption_per_mm = { table_nm = [[400, -1], [500, 1], [700, 1]] }",
            "row 1: -1 at 400 nm: expected 0 or more",
        ),
        (
            "reflector_reflectance = { table_nm = [[400, 0.9], [700, 1.3]] }",
            "row 2: 1.3 at 700 nm: expected 0 … 1",
        ),
        ("thickness_mm = { table_nm = [[400, 20], [700, 20]] }", "expected a number"),
        ("resin_index = { cauchy = [0.9] }", "resin_index: 0.9"),
    ],
)
def test_wrong_tables_are_refused(tmp_path, line, words):
    path = tmp_path / "stack.toml"
    path.write_text(f'extends = "thesis-32in-mpf"\n[value]\n{line}\n')
    with pytest.raises(InputError) as error:
        read_stack(path)
    assert words in str(error.value) and "\n" not in str(error.value)
