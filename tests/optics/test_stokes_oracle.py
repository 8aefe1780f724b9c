"""Paths of polarised light against the oracle, which has coherency matrices instead of Stokes."""

import numpy as np
import pytest
from harness import BARE, crossed_mesh, film_mesh, groove, polarised_paths
from oracle.polarised import PolarisedPhilox
from oracle.tracer import ReferenceTracer
from test_board import LAMBERTIAN, board

from mpfcad.optics.cavity.board import Cup
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.element import Cavity, Film, Sheet, Slab
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.scene import build_scene
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.stokes.plane import PlaneLayer

CAVITY = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.3)
MIRROR = Cavity(20.0, 32.69, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 1.0)
PANEL = Panel(-50.0, 50.0, -40.0, 40.0, (-16.0, 16.0), (1.0, 1.0), 90.0, 0.9, 0.7)
MIXED = [groove(60.0, chords=6), groove(45.0, chords=6)]
HALF = Sheet(0.3, 1.49, 0.98, depolarisation=0.4)
DBEF = PlaneLayer(0.4, (0.9, 0.04), (0.06, 0.93))
QUARTER = PlaneLayer(-0.7, retardation=np.pi / 2)
LCD = PlaneLayer(0.2, (0.85, 0.001))


def elements(name, folder):
    mesh = film_mesh(folder, MIXED)
    film = Film(mesh, 1.55, offset=0.013)
    match name:
        case "mpf":
            return [CAVITY, Slab(1.49, 2.0), Sheet(0.3, 1.49, 0.98), film]
        case "mpf under a sheet":
            return [MIRROR, Slab(1.49, 2.0), HALF, film, HALF]
        case "plate":
            bonded = Slab(1.49, 2.0, 0.3, 0.0036, 0.8, bonded=True)
            return [CAVITY, bonded, Film(mesh, 1.55, 1.49, absorption=0.2)]
        case "birefringent base":
            base = Slab(1.64, 0.1, bonded=True, delay=50.0, axis=0.6)
            return [DBEF, base, Film(mesh, 1.55, 1.64), LCD]
        case "turned":
            return [Film(mesh, 1.5, rotation=0.6), QUARTER, Film(mesh, 1.6, flipped=True)]
        case "pyramids":
            return [DBEF, QUARTER, Film(crossed_mesh(folder), 1.5)]
        case "resin":
            prism = film_mesh(folder, [BARE] * 2)
            return [MIRROR, Film(mesh, 1.5, resin=Resin(prism, 8.0, 0.5))]
        case "two materials, rough":
            own = Resin(film_mesh(folder, [BARE] * 2), 2.0, 0.5, index=1.45, absorption=0.3)
            film = Film(film_mesh(folder, MIXED), 1.55, resin=own, roughness=0.15, rotation=0.4)
            return [film, QUARTER]
        case "polarisers":
            return [MIRROR, QUARTER, film, DBEF, HALF, LCD]
        case "panel":
            panel = Cavity(20.0, 32.0, 0.0, 3.5, 1.7, 20100.0, 0.75, 0.94, 0.6, panel=PANEL)
            return [panel, film, DBEF]
        case "cups":
            mirrors = Cup(2.0, 1.45, 1.5, 0.9, 0.8)
            return [board(4.0, 3.0, LAMBERTIAN, size=2.0, cup=mirrors), film, DBEF]


@pytest.mark.parametrize(
    "name",
    [
        "mpf",
        "mpf under a sheet",
        "plate",
        "birefringent base",
        "turned",
        "pyramids",
        "resin",
        "two materials, rough",
        "polarisers",
        "panel",
        "cups",
    ],
)
def test_paths_equal_the_oracle(tmp_path, name):
    # As of the plain tracer (`test_reference`), a lamp's last-bit differences grow along a path.
    stack, count = elements(name, tmp_path), 60
    scene = build_scene(stack, below=1.0, polarised=True)
    source = Source(EYE, [0.1], 0.05, 0.2, -0.1, 0.5, along=0.3, spot_along=0.01)
    found = polarised_paths(scene, source, 1, count)
    oracle = ReferenceTracer(stack, below=1.0)

    def alone(path):
        random = PolarisedPhilox(1, EYE, path, 1)
        return oracle.radiance(0.1, 0.05, 0.5, random, y=0.3, tilt=(0.2, -0.1), spot_along=0.01)

    expected = np.array([alone(path) + np.zeros(4) for path in range(count)])
    assert (np.abs(expected[:, 1:3]).max(axis=0) > 0.005 * expected[:, 0].max()).all()
    assert name in ("plate", "panel", "mpf") or np.abs(expected[:, 3]).max() > 0
    away = np.abs(found - expected).max(axis=1) / expected.max()
    assert np.mean(away > 1e-9) <= 1 / count, np.flatnonzero(away > 1e-9)
    assert not (away > 1e-6).any()
