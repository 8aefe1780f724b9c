"""Radiance's genBSDF of an asymmetric prism film, read as it writes it, beside our own trace."""

import numpy as np
import pyradiance
from harness import extruded, write_facets
from pyradiance.genbsdf import SamplingBox
from pyradiance.util import WrapBSDF

from mpfcad.optics.bsdf.basis import klems_basis
from mpfcad.optics.bsdf.file import read_bsdf
from mpfcad.optics.bsdf.missing import Taken
from mpfcad.optics.bsdf.table import ABOVE, BELOW, REFLECT, TRANSMIT
from mpfcad.optics.bsdf_film import trace_film_bsdf
from mpfcad.optics.solid.mesh import read_film_mesh

PITCH, DEPTH, BASE, COUNT, LENGTH = 0.05, 0.03, 0.05, 41, 2.0
QUARTER = klems_basis("LBNL/Klems Quarter")


def saw():
    """Return a Radiance scene of saw teeth, steep on their right, tips at z = 0."""
    left = -COUNT * PITCH / 2
    x = np.array([left + PITCH * (i + part) for i in range(COUNT) for part in (0, 0.8)])
    x, z = np.append(x, left + COUNT * PITCH), np.append(np.tile([-DEPTH, 0.0], COUNT), -DEPTH)
    low, near, far = -DEPTH - BASE, -LENGTH / 2, LENGTH / 2
    faces = [
        [
            (x[i], near, z[i]),
            (x[i + 1], near, z[i + 1]),
            (x[i + 1], far, z[i + 1]),
            (x[i], far, z[i]),
        ]
        for i in range(len(x) - 1)
    ]
    foot = [(x[0], near, low), (x[0], far, low), (x[-1], far, low), (x[-1], near, low)]
    faces += [foot, [foot[0], (x[0], near, z[0]), (x[0], far, z[0]), foot[1]]]
    faces += [[foot[3], foot[2], (x[-1], far, z[-1]), (x[-1], near, z[-1])]]
    cap = [foot[0], foot[3], *[(a, near, b) for a, b in zip(x, z, strict=True)][::-1]]
    faces += [cap, [(a, far, b) for a, _, b in cap[::-1]]]
    rows = ["void dielectric film 0 0 5 1 1 1 1.5 0"]
    for n, face in enumerate(faces):
        places = " ".join(f"{value:.9f}" for place in face for value in place)
        rows.append(f"film polygon p{n} 0 0 {3 * len(face)} {places}")
    return "\n".join(rows) + "\n"


def genbsdf(folder):
    """Return the XML that genBSDF writes by default: the Back blocks alone."""
    scene = folder / "saw.rad"
    scene.write_text(saw())
    box = SamplingBox(-2 * PITCH, 2 * PITCH, -2 * PITCH, 2 * PITCH, -DEPTH - BASE, 0.0)
    limits = ["-w", "-ab", "5", "-ad", "700", "-lw", "3e-6", "-lr", "30", "-st", "0"]
    made = pyradiance.generate_bsdf(
        str(scene), nsamp=1000, basis="kq", dim=box, front=False, params=limits
    )
    (folder / "t.dat").write_bytes(made.back.transmittance)
    (folder / "r.dat").write_bytes(made.back.reflectance)
    wrap = WrapBSDF(basis="kq", correct_solid_angle=True, n="saw")
    wrap.add_visible(tb=str(folder / "t.dat"), rb=str(folder / "r.dat"))
    path = folder / "saw.xml"
    path.write_bytes(wrap())
    return path


def misplaced(one, other):
    """Return the mean share of light that two tables send elsewhere, from one side."""
    return np.abs(one - other).sum(axis=-1).mean() / 2


def test_an_asymmetric_prism_film_of_genbsdf(tmp_path):
    x, z = np.array([0, 0.8 * PITCH, PITCH]), np.array([BASE, BASE + DEPTH, BASE])
    mesh = read_film_mesh(write_facets(tmp_path / "saw.stl", extruded(x, z, 0.1)))
    own = trace_film_bsdf(mesh, 1.5, QUARTER, rays=4000).table
    # Its noise makes sums of up to 1.01 of a lossless film.
    said = Taken(reflection="lossless")
    read = read_bsdf(genbsdf(tmp_path), taken=said, normalise=True)
    for way in (TRANSMIT, REFLECT):
        assert misplaced(read.chance[way, ABOVE], own.chance[way, ABOVE]) < 0.06
    # The other side by reciprocity; what it reflects is known in sum only.
    assert misplaced(read.chance[TRANSMIT, BELOW], own.chance[TRANSMIT, BELOW]) < 0.06
    assert np.abs(read.energy[:, BELOW] - own.energy[:, BELOW]).mean() < 0.05
    # Turned by half it is another film.
    turned = own.chance[TRANSMIT, ABOVE][QUARTER.opposite][:, QUARTER.opposite]
    assert misplaced(read.chance[TRANSMIT, ABOVE], turned) > 0.4
