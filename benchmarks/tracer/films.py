"""Films alone: extruded ones, and a field of pyramids."""

import numpy as np
from harness import CONCAVE, film_file

from tracer.mesh import pyramids, reentrant_grooves
from tracer.mitsuba_scene import PITCH, mitsuba_film
from tracer.race import entry, race, spent
from tracer.single_ray_scene import raysect_film

GROOVES, CELLS = 654, 707


def ours(path, kind, rho=None):
    """Return trace(n, seed) → (mean, standard error, paths) of a film between black halves."""
    from mpfcad.optics.base.recorder import FLOW_ELEMENTS
    from mpfcad.optics.element import Cavity, Film
    from mpfcad.optics.engine import BLOCK, trace
    from mpfcad.optics.scene import build_scene
    from mpfcad.optics.solid.mesh import read_film_mesh
    from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, Source

    mesh = read_film_mesh(path)
    place = np.full(32, mesh.size[0] / 2)
    film = Film(mesh, 1.5)
    if rho is None:
        scene = build_scene([film], below=1.0)
    else:
        # Lamps so thin and far that none is met: what the reflector absorbs of a meter's unit is
        # (1-ρ) times its luminance, if it shone with radiance 1. It is as near to the film as the
        # peer's: in a wider gap light would forget below which groove it was.
        cavity = Cavity(1e-3, 1e6, 5e5, 0.5, 1e-6, 0.0, 0.0, rho, 0.0)
        scene = build_scene([cavity, film])

    def run(n, seed):
        blocks = max(2, n // (BLOCK * len(place)))
        where = LAMBERTIAN_BELOW if kind == "transmittance" else EYE
        tally = trace(scene, Source(where, place, 0.05), blocks, seed=seed)
        share, error = tally.fraction, tally.fraction_error
        if rho is not None:
            value, sigma = (v[FLOW_ELEMENTS] / (1 - rho) for v in (share, error))
            return value, sigma, tally.total_paths
        if kind == "transmittance":
            return share[0], error[0], tally.total_paths
        error = np.sqrt((tally.radiance_error**2).mean() / len(place))
        return tally.radiance.mean(), error, tally.total_paths

    return run


def film_rows(folder, quick, present):
    path = film_file(folder / "film.stl", [CONCAVE] * GROOVES, length=20.0)
    cell = film_file(folder / "cell.stl", [CONCAVE] * 8, length=0.4)
    scale = 1 if quick else 4
    for kind in ("transmittance", "normal luminance"):
        lambertian = kind == "transmittance"
        for what, file, beside, goal in (("mesh", path, 0, 5), ("cell", cell, PITCH, None)):
            name = f"film, {kind}, beside Mitsuba ({what})"
            if not present["mitsuba"]:
                yield entry(f"{name}: absent", None, "k/s")
                continue
            peer = mitsuba_film(file, 1.5, lambertian, beside=beside)
            counts = (scale * 1_000_000, scale * 500_000)
            yield from race(name, ours(path, kind), peer, counts, 3, goal)
        if not present["raysect"]:
            yield entry(f"film, {kind}, beside raysect: absent", None, "k/s")
            continue
        peer = raysect_film(cell, 1.5, lambertian)
        counts = (scale * 1_000_000, scale * 40_000)
        name = f"film, {kind}, beside raysect (cell)"
        yield from race(name, ours(path, kind), peer, counts, 2, 12)
    name = "film over a 95 % white reflector beside Mitsuba (mesh)"
    if not present["mitsuba"]:
        yield entry(f"{name}: absent", None, "k/s")
        return
    peer = mitsuba_film(path, 1.5, False, reflectance=0.95)
    counts = (scale * 300_000, scale * 200_000)
    yield from race(name, ours(path, "luminance", rho=0.95), peer, counts, 3, 5)


def section_rows(folder, quick, present):
    """Trace grooves that are wider below than at their mouth: no height over the underside."""
    count = GROOVES // 4 if quick else GROOVES // 2
    path = reentrant_grooves(folder / "re-entrant.stl", count)
    paths = 500_000 if quick else 2_000_000
    for kind in ("transmittance", "normal luminance"):
        name = f"{count} re-entrant grooves, {kind}, beside Mitsuba (mesh)"
        if not present["mitsuba"]:
            yield entry(f"{name}: absent", None, "k/s")
            continue
        peer = mitsuba_film(path, 1.5, kind == "transmittance")
        yield from race(name, ours(path, kind), peer, (2 * paths, paths), 3, 3)


def pyramid_rows(folder, quick, present):
    """Trace a field of pyramids; Mitsuba's as it is, and two cells of one between mirrors.

    Those are endless, as ours is: else guided light leaves at the sides. Mirrors at the sides of
    the whole field would not do: far out Mitsuba's ray offsets are 1.6 µm.
    """
    from mpfcad.optics.search.grid.build import build_grid
    from mpfcad.optics.solid.mesh import read_film_mesh

    cells = 400 if quick else CELLS
    path = pyramids(folder / "pyramids.stl", cells)
    field = f"pyramids, {4 * cells * cells:,} facets"
    mesh = read_film_mesh(path)
    grid, cpu = spent(build_grid, mesh)
    yield entry(f"{field}, grid built", cpu, "s")
    yield entry("    its size", sum(v.nbytes for v in grid) / 2**20, "MiB")
    if not present["mitsuba"]:
        yield entry(f"{field}, beside Mitsuba: absent", None, "k/s")
        return
    cell = pyramids(folder / "few.stl", 8)
    for what, file, beside in (("mesh", path, 0), ("cell", cell, PITCH)):
        for kind in ("transmittance", "normal luminance"):
            lambertian = kind == "transmittance"
            peer = mitsuba_film(file, 1.5, lambertian, beside=beside, top=190.0)
            name = f"{field}, {kind}, beside Mitsuba ({what})"
            yield from race(name, ours(path, kind), peer, (500_000, 500_000), 3, 1.5)
