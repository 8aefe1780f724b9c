"""Polarised light through plates and films beside Mitsuba's polarised variant.

    python benchmarks/polarised.py --rays 100000

It prints I, Q, U, V of both and their difference in standard errors. V's sign is a convention that
the two programs do not share, so its size is compared.
"""

import argparse
import math
import tempfile
from pathlib import Path

import numpy as np
from harness import BARE, CONCAVE, extruded, film_file, row, write_facets
from tracer.films import GROOVES
from tracer.mitsuba_polarised import film, mitsuba, plates, stokes

from mpfcad.optics.base.net import NET
from mpfcad.optics.element import Film, Slab
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import read_film_mesh
from mpfcad.optics.source import EYE, Source
from mpfcad.optics.stokes.engine import trace_stokes

TILTS = {"plate": [(0.5, 0.0), (0.832, 0.0)], "film": [(0.0, 0.0), (0.3, 0.2), (-0.5, 0.6)]}


def own(elements, tilt, rays, seed):
    """Return I, Q, U, V with standard errors, (4,) each."""
    blocks = max(4, rays // NET)
    scene = build_scene(elements, below=1.0, polarised=True)
    found = trace_stokes(scene, Source(EYE, [0.0], 0.05, *tilt), blocks, seed=seed)[:, 0]
    return found.mean(axis=0), found.std(axis=0, ddof=1) / math.sqrt(blocks)


def cases(folder):
    """Yield (name, our elements, Mitsuba's bodies, height [µm] over all, tilt)."""
    mi = mitsuba()
    for count in (1, 3):
        for tilt in TILTS["plate"]:
            bodies = plates(mi, 1.5, count)
            yield f"{count} plates", [Slab(1.5, 1.0)] * count, bodies, 2000.0 * count, tilt
    for name, groove in (("BEF", BARE), ("concave", CONCAVE)):
        own_file = film_file(folder / f"{name}.stl", [groove] * 8)
        # Light of one direction that meets flat facets shows how an STL's single numbers turn them
        # (1.8 % along (0.5, -0.6) at x = 32 mm): so x = 0 is in the middle. And it shows what is
        # guided along the grooves out of a film's ends (2.3 % of 4 × 4 mm): so it is long.
        x, z = row([groove] * GROOVES, 0.15)
        path = write_facets(folder / f"{name}-wide.stl", extruded(x - x[-1] / 2, z, 200.0))
        for tilt in TILTS["film"]:
            elements = [Film(read_film_mesh(own_file), 1.5)]
            yield name, elements, film(mi, path, 1.5), 180.0, tilt


def main() -> None:
    """Print a row a case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rays", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for name, elements, bodies, top, tilt in cases(Path(folder)):
            ours, error = own(elements, tilt, asked.rays, asked.seed)
            theirs, other = stokes(mitsuba(), bodies, tilt, top, asked.rays, asked.seed)
            ours[3], theirs[3] = abs(ours[3]), abs(theirs[3])
            away = (ours - theirs) / np.hypot(np.hypot(error, other), 1e-6)
            worst = max(worst, float(np.abs(away).max()))
            print(f"{name} seen along {tilt}")
            for row in zip("IQUV", ours, error, theirs, other, away, strict=True):
                print("  {} {:9.5f} ± {:.5f}   Mitsuba {:9.5f} ± {:.5f}   {:+.1f} σ".format(*row))
    print(f"largest difference {worst:.1f} σ")


if __name__ == "__main__":
    main()
