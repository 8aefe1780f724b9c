"""BSDF files: written and read back, read by other means, and refused where they are wrong."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import AngleBasis, even_basis, klems_basis, ring_basis
from mpfcad.optics.bsdf.file import bsdf_texts, read_bsdf, write_texts
from mpfcad.optics.bsdf.missing import Taken
from mpfcad.optics.bsdf.rebin import expand_isotropic, rebin
from mpfcad.optics.bsdf.table import BsdfTable

QUARTER = klems_basis("LBNL/Klems Quarter")


def rough(basis, isotropic, seed, loss=0.1):
    """Return a reciprocal table of random values."""
    incidences = len(basis.azimuths) if isotropic else basis.count
    value = np.random.default_rng(seed).random((2, 2, incidences, basis.count))
    table = BsdfTable("rough", basis, isotropic, value)
    value = value / table.energy.sum(axis=0)[None, :, :, None] * (1 - loss)
    return BsdfTable("rough", basis, isotropic, value).made_reciprocal()


def lambertian(basis, isotropic, transmitted, reflected):
    """Return an ideal diffuser."""
    incidences = len(basis.azimuths) if isotropic else basis.count
    value = np.empty((2, 2, incidences, basis.count))
    value[0], value[1] = transmitted / np.pi, reflected / np.pi
    return BsdfTable("ideal", basis, isotropic, value)


def written(folder, table, form):
    return write_texts(folder, bsdf_texts(table, "table", form))


@st.composite
def tables(draw):
    isotropic = draw(st.booleans())
    inner = draw(st.lists(st.integers(1, 89), min_size=1, max_size=5, unique=True))
    edge = np.radians([0.0, *sorted(inner), 90.0])
    if isotropic:
        basis = ring_basis(edge, 2 * draw(st.integers(1, 3)))
    else:
        azimuths = draw(st.lists(st.sampled_from([2, 4, 6]), min_size=len(edge) - 1,
                                 max_size=len(edge) - 1))  # fmt: skip
        basis = AngleBasis("own", edge, np.array([1, *azimuths[1:]]))
    return rough(basis, isotropic, draw(st.integers(0, 2**32 - 1)))


@settings(max_examples=20)
@given(table=tables())
@pytest.mark.parametrize("form", ["klems", "csv"])
def test_files_read_back_as_the_same_bits(tmp_path_factory, form, table):
    (path,) = written(tmp_path_factory.mktemp("bsdf"), table, form)
    back = read_bsdf(path)
    expected = expand_isotropic(table) if form == "klems" else table
    assert np.array_equal(back.value, expected.value)
    assert back.basis.is_same(table.basis)
    assert back.isotropic == (table.isotropic and form == "csv")
    assert back.note == ()


@settings(max_examples=15)
@given(table=tables())
def test_other_bins_keep_energy_and_reciprocity(table):
    other = rebin(table, QUARTER)
    np.testing.assert_allclose(other.hemispherical, table.hemispherical, rtol=1e-9)
    assert other.reciprocity_error < 1e-12
    assert other.energy.sum(axis=0).max() <= table.energy.sum(axis=0).max() + 1e-9
    finer = rebin(rebin(table, table.basis), even_basis(4))
    np.testing.assert_allclose(finer.hemispherical, table.hemispherical, rtol=1e-9)


def test_klems_projected_solid_angles():
    basis = klems_basis("LBNL/Klems Full")
    assert basis.count == 145
    assert math.isclose(basis.projected.sum(), math.pi)
    # The cap of 5 deg: π sin²5°.
    assert math.isclose(basis.projected[0], 0.0238638, rel_tol=1e-5)
    middle = np.sin(basis.polar[basis.ring])
    found = basis.bin_of(middle * np.cos(basis.azimuth), middle * np.sin(basis.azimuth))
    assert (found == np.arange(145)).all()
    opposite = basis.opposite
    back = basis.bin_of(-middle * np.cos(basis.azimuth), -middle * np.sin(basis.azimuth))
    assert (opposite[opposite] == np.arange(145)).all()
    assert (back[1:] == opposite[1:]).all()


def test_the_xml_read_by_hand_gives_the_closed_form(tmp_path):
    # Element tree and arithmetic only: columns are incidences, τ = Σ value·projected solid angle.
    basis = klems_basis("LBNL/Klems Full")
    value = lambertian(basis, False, 0.6, 0.3).value.copy()
    value[0, 0, 7, 100] += 0.5  # incidence 7, outgoing 100, from below
    (path,) = written(tmp_path, BsdfTable("ideal", basis, False, value), "klems")
    root = ElementTree.parse(path).getroot()
    space = "{http://windows.lbl.gov}"
    assert root.tag == space + "WindowElement"
    bounds = [float(e.text) for e in root.iter(space + "UpperTheta")]
    azimuths = [int(e.text) for e in root.iter(space + "nPhis")]
    assert bounds == [5, 15, 25, 35, 45, 55, 65, 75, 90]
    solid = []
    for low, high, n in zip([0, *bounds], bounds, azimuths, strict=False):
        part = math.sin(math.radians(high)) ** 2 - math.sin(math.radians(low)) ** 2
        solid += [math.pi * part / n] * n
    totals = {}
    for block in root.iter(space + "WavelengthDataBlock"):
        direction = block.findtext(space + "WavelengthDataDirection")
        lines = block.findtext(space + "ScatteringData").strip().splitlines()
        rows = [[float(v) for v in line.split(",") if v.strip()] for line in lines]
        assert len(rows) == 145 and all(len(row) == 145 for row in rows)
        totals[direction] = [sum(rows[o][i] * solid[o] for o in range(145)) for i in range(145)]
        if direction == "Transmission Front":
            assert math.isclose(rows[100][7], 0.6 / math.pi + 0.5)
    assert np.allclose(totals["Reflection Front"], 0.3) and np.allclose(
        totals["Reflection Back"], 0.3
    )
    front = np.full(145, 0.6)
    front[7] += 0.5 * solid[100]
    assert np.allclose(totals["Transmission Front"], front)


@pytest.mark.parametrize("isotropic", [True, False])
def test_a_lambertian_diffuser_survives_the_zemax_format(tmp_path, isotropic):
    basis = ring_basis(np.radians(np.linspace(0, 90, 10)), 12) if isotropic else even_basis(6)
    paths = written(tmp_path, lambertian(basis, isotropic, 0.6, 0.3), "zemax")
    assert len(paths) == 4
    chosen = paths if isotropic else paths[:1]
    taken = Taken(symmetric=True, reflection=0.3)
    back = read_bsdf(chosen, taken=taken)
    np.testing.assert_allclose(back.energy[0, 0], 0.6, rtol=1e-6)
    # The values too: even over every bin that its grid reaches in full.
    reached = back.basis.edge[1:][back.basis.ring] < np.radians(80)
    np.testing.assert_allclose(back.value[0, 0][:, reached], 0.6 / np.pi, rtol=0.02)


def test_a_zemax_lobe_lies_where_its_angles_say(tmp_path):
    # A lobe 20 deg off the direct ray towards the normal (azimuth 0), at 40 deg: leaves at 20 deg.
    text = zemax(lobe_azimuth=0)
    (path,) = write_texts(tmp_path, {"lobe.bsdf": text})
    table = read_bsdf(path, taken=Taken(symmetric=True, reflection=0.0))
    ring = int(np.searchsorted(table.basis.edge, np.radians(40)))
    peak = int(np.argmax(table.value[0, 0, ring]))
    assert abs(np.degrees(table.basis.polar[table.basis.ring[peak]]) - 20) < 4
    assert abs(np.degrees(table.basis.azimuth[peak])) < 6
    np.testing.assert_allclose(table.energy[0, 0, ring], 0.5, rtol=1e-9)
    assert "reflection from below: Lambertian (reflection = 0)" in table.note


def zemax(lobe_azimuth=0, tis=0.5, level=None):
    azimuth, radial = np.arange(0, 360, 30), np.arange(0, 61, 5)
    value = np.zeros((len(azimuth), len(radial)))
    value[azimuth == lobe_azimuth, radial == 20] = 1.0
    lines = ["# measured", "Source  Measured", "Symmetry  ASymmetrical",
             "SpectralContent  Monochrome", "ScatterType  BTDF", "SampleRotation  1", "0",
             "AngleOfIncidence  1", "40", f"ScatterAzimuth  {len(azimuth)}",
             " ".join(map(str, azimuth)), f"ScatterRadial  {len(radial)}",
             " ".join(map(str, radial)), "", "Monochrome", "DataBegin", f"TIS {tis}"]  # fmt: skip
    # ∫ of the two-sided tents 30 deg by 5 deg: about Δaz·Δr·sin 20°·cos 20°.
    height = tis / (math.radians(30) * math.radians(5) * math.sin(0.349) * math.cos(0.349))
    value *= height if level is None else level
    return "\n".join([*lines, *(" ".join(map(str, row)) for row in value), "DataEnd", ""])


def thesis_csv(transmittance=0.6, drop=None, incidence=range(0, 81, 10)):
    """Return an isotropic CSV as measured: incidence 0–80° in 10° steps, mirrored azimuths."""
    rows = ["side,way,incidence_deg,scatter_deg,scatter_azimuth_deg,bsdf_per_sr"]
    for way, share in (("transmission", transmittance), ("reflection", 0.3)):
        for i in incidence:
            for s in range(0, 90, 5):
                for a in range(0, 181, 30):
                    if (way, i, s, a) != drop:
                        rows.append(f"below,{way},{i},{s},{a},{share / math.pi!r}")
    return "\n".join(rows) + "\n"


def test_the_csv_of_a_measurement(tmp_path):
    (path,) = write_texts(tmp_path, {"sheet.csv": thesis_csv()})
    table = read_bsdf(path, taken=Taken(symmetric=True, reciprocal=True))
    assert table.isotropic and table.basis.azimuths[0] == 12
    np.testing.assert_allclose(table.energy[0], 0.6, rtol=1e-12)
    np.testing.assert_allclose(table.energy[1], 0.3, rtol=1e-12)
    assert any("0 … 80 deg: linear between" in note for note in table.note)
    assert "transmission from above: as from below (symmetric = true)" in table.note
    assert "reflection from above: as from below (symmetric = true)" in table.note


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", thesis_csv(0.9), "a.csv: light from below, incidence"),
        ("a.csv", thesis_csv(0.9), "reflected and transmitted 1.2000: expected at most 1"),
        ("a.csv", thesis_csv(drop=("reflection", 30, 20, 60)),
         "reflection from below: 0 rows at incidence 30, scatter 20, azimuth 60 deg: expected 1"),
        ("a.csv", thesis_csv().replace("below,reflection,10,5,30", "below,reflection,10,95,30", 1),
         "row 1270: 'below,reflection,10,95,30"),
        ("a.csv", "x,y\n1,2\n", "a.csv: header: expected side,way"),
        ("a.csv", thesis_csv().splitlines()[0], "no rows"),
        ("a.bsdf", zemax(tis=0.9, level=1.0), "expected within 20 % of the TIS 0.9"),
        ("a.bsdf", zemax().replace("BTDF", "XTDF"), "ScatterType: ScatterType XTDF: expected"),
        ("a.bsdf", zemax().replace("DataEnd", ""), "data of rotation 1, incidence 1"),
        ("a.bsdf", zemax().replace("40\nScatterAz", "95\nScatterAz"), "AngleOfIncidence: 95 … 95"),
        ("a.xml", "<a>", "cannot be read as XML"),
        ("a.xml", "<a/>", "IncidentDataStructure: missing"),
        ("a.txt", "", "a.txt: .txt: expected .xml, .csv, .astm, .bsdf"),
    ],
)  # fmt: skip
def test_wrong_files_are_refused_with_the_place(tmp_path, name, text, words):
    write_texts(tmp_path, {name: text})
    with pytest.raises(InputError) as error:
        read_bsdf(tmp_path / name, taken=Taken(symmetric=True, reflection=0.0))
    assert words in str(error.value)
    assert "\n" not in str(error.value)


def test_a_wrong_count_in_xml_is_refused(tmp_path):
    (path,) = written(tmp_path, lambertian(QUARTER, False, 0.5, 0.4), "klems")
    text = path.read_text()
    path.write_text(text.replace(f"{0.5 / np.pi!r}, ", "", 1))
    with pytest.raises(
        InputError, match="Transmission Front: 1680 values: expected 41 x 41 = 1681"
    ):
        read_bsdf(path)


def test_reciprocity_is_refused_where_claimed_but_not_so(tmp_path):
    table = lambertian(QUARTER, False, 0.5, 0.4)
    value = table.value.copy()
    value[0, 0] *= np.linspace(0.2, 1, 41)[:, None]
    (path,) = written(tmp_path, BsdfTable("x", QUARTER, False, value), "klems")
    assert read_bsdf(path).reciprocity_error > 0.05
    with pytest.raises(InputError, match=r"table\.xml: claimed reciprocal: error 0\.\d+: expected"):
        read_bsdf(path, taken=Taken(reciprocal=True))


def test_nothing_is_left_when_writing_fails(tmp_path):
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "table.csv").mkdir()
    with pytest.raises(InputError, match="is a folder: expected a file"):
        write_texts(tmp_path / "b", {"table.csv": "x"})
    assert [p.name for p in (tmp_path / "b").iterdir()] == ["table.csv"]
