"""Klems matrices and tensor trees against Radiance's own reader (pyradiance)."""

import re

import numpy as np
import pytest
from pyradiance import bsdf

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.basis import klems_basis
from mpfcad.optics.bsdf.file import bsdf_texts, read_bsdf, write_texts
from mpfcad.optics.bsdf.missing import NONE
from mpfcad.optics.bsdf.table import ABOVE, BELOW, REFLECT, TRANSMIT, BsdfTable

KEPT = []
HEAD = (
    '<?xml version="1.0"?><WindowElement><Optical><Layer><Material><Name>a</Name>'
    "<Manufacturer>b</Manufacturer><Width>1</Width><Height>1</Height><DeviceType>Other"
    "</DeviceType></Material><DataDefinition><IncidentDataStructure>TensorTree{}"
    "</IncidentDataStructure></DataDefinition>"
)
BLOCK = (
    '<WavelengthData><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock>'
    "<WavelengthDataDirection>{}</WavelengthDataDirection><AngleBasis>LBNL/Shirley-Chiu"
    "</AngleBasis><ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>{}"
    "</ScatteringData></WavelengthDataBlock></WavelengthData>"
)


def loaded(path):
    """Return Radiance's data of a file; never freed, as pyradiance may free them twice."""
    KEPT.append(bsdf.load_file(str(path)))
    return KEPT[-1]


def test_a_klems_matrix_of_the_back_only_is_what_radiance_reads(tmp_path):
    basis = klems_basis("LBNL/Klems Full")
    value = 0.2 * np.random.default_rng(5).random((2, 2, basis.count, basis.count))
    text = bsdf_texts(BsdfTable("a", basis, False, value), "a", "klems")["a.xml"]
    text = re.sub(
        r"(?s)<WavelengthData>(?:(?!</WavelengthData>).)*Front.*?</WavelengthData>", "", text
    )
    path = write_texts(tmp_path, {"a.xml": text})[0]
    table = read_bsdf(path, needed=NONE)
    assert table.unknown == {(TRANSMIT, BELOW), (REFLECT, BELOW)}
    radiance = loaded(path)
    polar, azimuth = np.degrees(basis.polar[basis.ring]), np.degrees(basis.azimuth)
    for i, o in np.random.default_rng(6).integers(1, basis.count, (40, 2)):
        for way, out in ((TRANSMIT, 180 - polar[o]), (REFLECT, polar[o])):
            there = bsdf.query(radiance, polar[i], azimuth[i] + 180, out, azimuth[o])[1]
            # Radiance takes its own solid angles of bins: equal within 5e-4.
            assert table.value[way, ABOVE, i, o] == pytest.approx(there, rel=1e-3)


def tree(rng, dimensions, depth=0):
    """Return a random tree as text: branches above, leaves of grids below."""
    if depth < 2 and (depth == 0 or rng.random() < 0.5):
        branches = (tree(rng, dimensions, depth + 1) for _ in range(1 << dimensions))
        return "{" + " ".join(branches) + "}"
    side = int(rng.choice([1, 2]))
    return "{" + ",\n".join(f"{v:.5f}" for v in 0.2 * rng.random(side**dimensions)) + "}"


def written(folder, dimensions, seed, directions=("Transmission Back", "Reflection Back")):
    rng = np.random.default_rng(seed)
    blocks = [BLOCK.format(name, tree(rng, dimensions)) for name in directions]
    text = HEAD.format(dimensions) + "".join(blocks) + "</Layer></Optical></WindowElement>"
    return write_texts(folder, {"tree.xml": text})[0]


@pytest.mark.parametrize("dimensions", [3, 4])
def test_a_tree_is_what_radiance_reads(tmp_path, dimensions):
    path = written(tmp_path, dimensions, 7)
    table = read_bsdf(path, needed=NONE)
    assert table.isotropic == (dimensions == 3)
    radiance = loaded(path)
    # Radiance's front (+z) is our above: what comes from there is the file's Back. Its vectors
    # point away from the surface, so the incident one is opposite to the way of travel.
    basis, rng = table.basis, np.random.default_rng(3)
    apart = []
    for i in rng.integers(0, len(table.incidence_polar), 6):
        azimuth = 0.0 if table.isotropic else basis.azimuth[i]
        for o in rng.integers(0, basis.count, 6):
            for way in (TRANSMIT, REFLECT):
                # The mean of points over both bins; cells' edges in them leave a few percent.
                mean = mean_of(radiance, basis, table.isotropic, i, o, azimuth, way == 0)
                apart.append(table.value[way, ABOVE, i, o] - mean)
    assert np.std(apart) < 0.006 and np.abs(apart).max() < 0.03
    assert abs(np.mean(apart)) < 0.002
    assert table.unknown == {(TRANSMIT, BELOW), (REFLECT, BELOW)}


def mean_of(radiance, basis, isotropic, i, o, azimuth, through, places=5):
    """Return the mean of Radiance's values over an incidence bin and an outgoing bin."""
    ring = i if isotropic else basis.ring[i]
    total, count = 0.0, 0
    part = (np.arange(places) + 0.5) / places
    low, high = basis.sin2_edge[:-1], basis.sin2_edge[1:]
    turn_in = 0 if isotropic else 2 * np.pi / basis.azimuths[ring]
    turn_out = 2 * np.pi / basis.azimuths[basis.ring[o]]
    for p in part:
        theta = np.arcsin(np.sqrt(low[ring] + (high[ring] - low[ring]) * p))
        for q in part if turn_in else [0.5]:
            come = azimuth + turn_in * (q - 0.5) + np.pi
            for r in part:
                r_out = basis.ring[o]
                out = np.arcsin(np.sqrt(low[r_out] + (high[r_out] - low[r_out]) * r))
                for s in part:
                    leave = basis.azimuth[o] + turn_out * (s - 0.5)
                    polar = np.pi - out if through else out
                    at = np.degrees([theta, come, polar, leave])
                    total += bsdf.query(radiance, *at)[1]
                    count += 1
    return total / count


def test_energy_is_the_trees_own(tmp_path):
    # A tree of one value is Lambertian.
    text = HEAD.format(4) + BLOCK.format("Reflection Back", "{0.1}") + BLOCK.format(
        "Transmission Back", "{0.05}"
    )  # fmt: skip
    path = write_texts(tmp_path, {"a.xml": text + "</Layer></Optical></WindowElement>"})[0]
    table = read_bsdf(path, needed=NONE)
    np.testing.assert_allclose(table.energy[REFLECT, ABOVE], 0.1 * np.pi, rtol=1e-9)
    np.testing.assert_allclose(table.value[TRANSMIT, ABOVE], 0.05, rtol=1e-9)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("{0.1 0.2}", "a leaf of 2 values: expected a power of 16"),
        ("{{0.1}{0.2}}", "2 branches: expected 16"),
        ("{0.1", "expected one tree in closed braces"),
        ("{x}", "could not convert string"),
        ("{nan}", "expected finite numbers"),
        ("{}", "expected values or branches"),
    ],
)
def test_wrong_trees_are_refused(tmp_path, data, words):
    text = HEAD.format(4) + BLOCK.format("Reflection Back", data)
    path = write_texts(tmp_path, {"a.xml": text + "</Layer></Optical></WindowElement>"})[0]
    with pytest.raises(InputError) as error:
        read_bsdf(path, needed=NONE)
    assert words in str(error.value) and "Reflection Back" in str(error.value)
