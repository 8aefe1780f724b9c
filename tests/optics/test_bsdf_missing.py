"""BSDF files as programs and instruments write them: what is missing is stated or refused."""

from pathlib import Path

import numpy as np
import pytest

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import even_basis, ring_basis
from mpfcad.optics.bsdf.file import bsdf_texts, read_bsdf, write_texts
from mpfcad.optics.bsdf.format.rotation import VENDOR, read_rotation
from mpfcad.optics.bsdf.format.zemax import read_zemax_file
from mpfcad.optics.bsdf.missing import NONE, REFLECTOR, Taken
from mpfcad.optics.bsdf.table import ABOVE, BELOW, REFLECT, TRANSMIT, BsdfTable

CASE = Path(__file__).parent / "case"


@pytest.mark.parametrize("name", ["white-black-back-only.xml", "prism-back-only.xml"])
def test_a_missing_side_is_refused_until_something_is_said(name):
    with pytest.raises(InputError, match=r"transmission from below: not in the file: expected"):
        read_bsdf(CASE / name)
    with pytest.raises(InputError, match=r"reflection from below: not in the file: expected"):
        read_bsdf(CASE / name, taken=Taken(reciprocal=True))
    known = read_bsdf(CASE / name, needed=NONE)
    assert known.unknown == {(TRANSMIT, BELOW), (REFLECT, BELOW)}
    reflector = read_bsdf(CASE / name, needed=REFLECTOR)
    assert (REFLECT, ABOVE) not in reflector.unknown


def test_what_is_stated_makes_the_whole_element():
    white = read_bsdf(CASE / "white-black-back-only.xml", taken=Taken(reflection=0.0))
    whole = read_bsdf(CASE / "white-black-both.xml")
    np.testing.assert_allclose(white.value, whole.value, atol=1e-6)
    assert white.note == (
        "transmission from below: by reciprocity from above",
        "reflection from below: Lambertian (reflection = 0)",
    )
    # A lossless prism: what it does not pass it reflects, and reciprocity gives the rest.
    prism = read_bsdf(CASE / "prism-back-only.xml", taken=Taken(reflection="lossless"))
    both = read_bsdf(CASE / "prism-both.xml")
    np.testing.assert_allclose(prism.energy, both.energy, atol=2e-6)
    np.testing.assert_allclose(prism.energy.sum(axis=0), 1, atol=2e-6)
    assert prism.reciprocity_error < 1e-9
    np.testing.assert_allclose(prism.value[TRANSMIT], both.value[TRANSMIT], atol=1e-9)


def test_symmetric_takes_the_other_side():
    table = read_bsdf(CASE / "line-before-declaration.xml", taken=Taken(symmetric=True))
    np.testing.assert_array_equal(table.value[:, BELOW], table.value[:, ABOVE])
    assert table.note[0] == "text before the XML left out: 'Recover using: genBSDF -recover'"


def test_too_much_reflection_is_refused_with_the_place():
    with pytest.raises(InputError, match=r"from below, incidence 65 deg.* 1\.2041: expected at"):
        read_bsdf(CASE / "prism-back-only.xml", taken=Taken(reflection=0.5))


def test_sums_a_little_above_1_are_normalised_on_request_only():
    with pytest.raises(InputError, match=r"1\.0026: expected at most 1; normalise = true"):
        read_bsdf(CASE / "sum-1.0026.xml")
    table = read_bsdf(CASE / "sum-1.0026.xml", normalise=True)
    assert table.energy.sum(axis=0).max() == pytest.approx(1, abs=1e-12)
    assert table.note == ("sums up to 1.0026 leave: all values divided by it (normalise = true)",)


@pytest.mark.parametrize(
    ("name", "note"),
    [
        ("comment-cp1252.bsdf", "text that is no UTF-8 read as Windows-1252"),
        ("lambertian-radial-80.bsdf", "values beyond 80 deg from the ray taken as at that edge"),
        ("lambertian-tis-0.bsdf", "TIS 0 is not stated: the values' integral taken"),
        ("rotations-0-45-90.bsdf", "rotations 0, 45, 90 deg completed by two mirror planes"),
    ],
)  # fmt: skip
def test_zemax_files_as_they_come(name, note):
    table = read_bsdf(CASE / name, needed=NONE)
    assert table.note[0].startswith(note)
    # 0.0428 everywhere is Lambertian: 0.0428·π = 0.13446.
    np.testing.assert_allclose(table.energy[REFLECT, BELOW], 0.13446, rtol=3e-3)
    np.testing.assert_allclose(table.value[REFLECT, BELOW], 0.0428, rtol=0.02)


def spread(table, incidence):
    """Return the root mean square of kx and ky about the direct ray at bins near an incidence."""
    basis = table.basis
    chosen = np.flatnonzero(np.abs(basis.polar[basis.ring] - incidence) < np.radians(3))
    sine = np.sin(basis.polar[basis.ring])
    k = sine * np.array([np.cos(basis.azimuth), np.sin(basis.azimuth)])
    chance = table.chance[TRANSMIT, BELOW]
    away = k[:, None, :] - k[:, chosen, None]
    moment = (away**2 * chance[chosen]).sum(axis=2) / chance[chosen].sum(axis=1)
    return np.sqrt(moment)


def test_sample_rotations_are_read_as_the_vendor_defines_them():
    # The sheet spreads along x at every azimuth of incidence.
    table = read_bsdf(CASE / "sample-rotation-as-zemax-says.bsdf", needed=NONE)
    across, along = spread(table, np.radians(20))
    assert (np.abs(across - 0.20) < 0.03).all()
    assert (along < 0.11).all()


def tilted(basis):
    """Return a sheet that sends light towards +x+y, by ever less the further it goes."""
    sine = np.sin(basis.polar[basis.ring])
    k = sine * np.array([np.cos(basis.azimuth), np.sin(basis.azimuth)])
    away = k[:, None, :] - k[:, :, None] - np.array([0.15, 0.08])[:, None, None]
    value = np.exp(-(away[0] ** 2) / 0.05 - away[1] ** 2 / 0.02)
    value = np.stack([np.stack([value] * 2), np.stack([value] * 2)])
    table = BsdfTable("tilted", basis, False, value)
    return BsdfTable("tilted", basis, False, value * 0.45 / table.energy[0, 0][:, None])


def test_an_asymmetric_sheet_survives_the_zemax_format(tmp_path):
    table = tilted(even_basis(9))
    path = write_texts(tmp_path, bsdf_texts(table, "sheet", "zemax"))[0]
    back = read_bsdf(path, needed=NONE)
    want, got = (t.chance[TRANSMIT, BELOW] for t in (table, back))
    for one, chance in ((table, want), (back, got)):
        basis = one.basis
        sine = np.sin(basis.polar[basis.ring])
        k = sine * np.array([np.cos(basis.azimuth), np.sin(basis.azimuth)])
        inner = basis.polar[basis.ring] < np.radians(40)
        mean = (chance @ k.T / chance.sum(axis=1)[:, None] - k.T)[inner].mean(axis=0)
        np.testing.assert_allclose(mean, [0.15, 0.08], atol=0.03)
    # Without its word on rotations the same file has two readings.
    said = read_zemax_file(path)
    path.write_text(path.read_text().replace("# rotation: +y counterclockwise\n", ""))
    with pytest.raises(InputError, match=r"a plane has two; .* expected rotation = "):
        read_bsdf(path, needed=NONE)
    np.testing.assert_array_equal(
        read_zemax_file(path, "+y counterclockwise").rotation, said.rotation
    )


@pytest.mark.parametrize(
    ("rotations", "words"),
    [
        ("0 30 60", "SampleRotation: 0, 30, 60 deg: neither all around nor half"),
        ("0 45 80", "neither all around"),
        ("0 170 340", "in steps of at most 90 deg"),
    ],
)
def test_rotation_sets_without_a_reading_are_refused(tmp_path, rotations, words):
    text = (CASE / "rotations-0-45-90.bsdf").read_text().replace("0\t45\t90", rotations)
    write_texts(tmp_path, {"a.bsdf": text})
    with pytest.raises(InputError) as error:
        read_bsdf(tmp_path / "a.bsdf", needed=NONE)
    assert words in str(error.value)


def test_words_for_rotations():
    assert read_rotation("a", "+y counterclockwise") == VENDOR
    with pytest.raises(InputError, match="expected the way of travel"):
        read_rotation("a", "90")


def test_most_light_beyond_the_grid_is_refused(tmp_path):
    text = (CASE / "lambertian-tis-0.bsdf").read_text()
    text = text.replace("0	10	30	60	90	120	165", "0 1 2 3 4 5 6")
    write_texts(tmp_path, {"a.bsdf": text})
    with pytest.raises(InputError, match="of the light would be beyond: expected radial angles"):
        read_bsdf(tmp_path / "a.bsdf", needed=NONE)


def lighttools(straight=270, incidence=(0, 40)):
    azimuth, radial = range(0, 360, 30), range(0, 90, 5)
    lines = ["Symmetry Asymmetric", "SpectralContent Monochrome",
             f"ScatterAzimuth {len(azimuth)}", " ".join(map(str, azimuth)),
             f"ScatterRadial {len(radial)}", " ".join(map(str, radial)), "DataBegin"]  # fmt: skip
    for aoi in incidence:
        lines += [f"AOI {aoi}", "POI 0", "Side Front", "Wavelength 550", "ScatterType BRDF",
                  "TIS 0.5"]  # fmt: skip
        lines += [
            " ".join(str(1.0 if (a == straight and r == aoi) or (r == aoi == 0) else 0.01)
                     for r in radial)
            for a in azimuth
        ]  # fmt: skip
    return "\n".join([*lines, "DataEnd", ""])


def test_lighttools_files_lie_where_the_mirrored_light_goes(tmp_path):
    write_texts(tmp_path, {"a.bsdf": lighttools()})
    table = read_bsdf(tmp_path / "a.bsdf", needed=NONE)
    ring = int(np.argmin(np.abs(table.basis.polar - np.radians(40))))
    peak = int(np.argmax(table.value[REFLECT, ABOVE, ring]))
    assert table.basis.azimuth[peak] == pytest.approx(0)
    assert table.basis.ring[peak] == ring
    assert "Front read as light from above" in table.note
    write_texts(tmp_path, {"c.bsdf": lighttools().replace("AOI 40\nPOI 0", "AOI 40\nPOI 90")})
    with pytest.raises(InputError, match=r"POI 90: an anisotropic file: .* expected POI 0"):
        read_bsdf(tmp_path / "c.bsdf", needed=NONE)
    write_texts(tmp_path, {"b.bsdf": lighttools().replace("DataEnd", "")})
    with pytest.raises(InputError, match="DataEnd: missing"):
        read_bsdf(tmp_path / "b.bsdf", needed=NONE)


def astm(unit, header="", names="theta_i,phi_i,theta_s,phi_s,BRDF"):
    rows = [header, f"VARS {names}"]
    for i in (0, 30, 60):
        for s in range(0, 90, 10):
            for a in range(0, 360, 30):
                value = 0.1 + (0.2 if (s == i and a == 0) else 0)
                rows.append(",".join(f"{v * unit:.8g}" for v in (i, 180, s, a)) + f",{value}")
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize("unit", [1.0, np.pi / 180])
def test_astm_columns(tmp_path, unit):
    write_texts(tmp_path, {"a.astm": astm(unit, "SAMPLE white")})
    table = read_bsdf(tmp_path / "a.astm", needed=NONE)
    assert table.isotropic
    ring = int(np.argmin(np.abs(table.basis.polar - np.radians(30))))
    peak = int(np.argmax(table.value[REFLECT, BELOW, ring]))
    assert table.basis.azimuth[peak] == pytest.approx(0) and table.basis.ring[peak] == ring
    assert ("degrees" if unit == 1 else "radians") in table.note[0]


def test_astm_angles_with_two_readings_are_refused(tmp_path):
    text = "theta_i,phi_i,theta_s,phi_s,brdf\n0,0,0,0,0.1\n1,0,1,1,0.1\n"
    write_texts(tmp_path, {"a.csv": text})
    with pytest.raises(InputError, match="degrees or radians: expected theta_i_deg or theta_i_rad"):
        read_bsdf(tmp_path / "a.csv", needed=NONE)


def test_isotropic_lossless_reflection_is_reciprocal():
    basis = ring_basis(np.radians([0, 20, 50, 90]), 4)
    from mpfcad.optics.bsdf.missing import fill_in

    transmitted = np.full((3, basis.count), 0.2) * np.array([1.0, 0.7, 0.5])[:, None]
    table = fill_in("a", basis, True, {(TRANSMIT, BELOW): transmitted},
                    Taken(symmetric=True, reflection="lossless"))  # fmt: skip
    np.testing.assert_allclose(table.energy.sum(axis=0), 1, rtol=1e-12)
    back = table.reversed_value()[REFLECT]
    np.testing.assert_allclose(back, table.value[REFLECT], atol=1e-12)
