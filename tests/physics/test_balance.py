"""Where the light goes: in = out + absorbed, and not one path lost."""

import numpy as np
import pytest
from harness import (
    BARE,
    PITCH,
    REENTRANT,
    SECTIONS,
    dish_mesh,
    film_mesh,
    groove,
    row,
    section_mesh,
    within,
)

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.optics.base.recorder import FLOWS
from mpfcad.optics.element import Film
from mpfcad.optics.engine import BLOCK, trace
from mpfcad.optics.scene import build_scene
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.optics.source import EYE, LAMBERTIAN_BELOW, LAMPS, Source

UP, DOWN, LOST, ROULETTE, IN_LAMPS, WALLS, RIM, FIRST = range(8)
FILMS = {
    "thesis-32in-conventional": [BARE],
    "thesis-32in-mpf": [groove(c) for c in (60.0, 57.0, 50.0)],
    "thesis-32in-mpf-plate": [groove(60.0)],
}

SMOOTH = groove(60.0, chords=6)


@pytest.mark.parametrize("name", FILMS)
def test_light_in_is_light_out_and_absorbed(tmp_path, name):
    elements = lower_stack(read_stack(name), film_mesh(tmp_path, FILMS[name], base=0.2))
    tally = trace(build_scene(elements), Source(LAMPS, np.zeros(1), 0.0), 200, seed=51)
    flow = tally.fraction
    assert FLOWS == ("up", "down", "lost", "roulette", "lamps", "walls", "rim")
    # The book-keeping is exact, path by path …
    assert flow.sum() == pytest.approx(1, abs=1e-12)
    assert flow[[DOWN, LOST, WALLS, RIM]].sum() == 0
    # … and what the roulette gave and took is zero within its own error: 5 sigma.
    within(flow[ROULETTE], 0.0, tally.fraction_error[ROULETTE], 5)
    absorbed = flow[IN_LAMPS] + flow[FIRST:].sum()
    within(flow[UP] + absorbed, 1.0, tally.fraction_error[ROULETTE], 5)
    assert 0.4 < flow[UP] < 0.8
    names = [element.name for element in elements]
    share = dict(zip(names, flow[FIRST:], strict=True))
    assert share["film"] == 0
    assert all(
        share[n] > 0.001 for n in names if n != "film" and ("plate" not in n or "mpf" not in name)
    )


@pytest.mark.parametrize("name", ["chain", "section", "bvh", *SECTIONS])
def test_no_path_is_lost_in_a_million(tmp_path, name):
    grooves = [groove(c, chords=60) for c in (60.0, 40.0001, 79.99, 0.0, 57.0)]
    if name in SECTIONS:
        film = Film(section_mesh(tmp_path, name), 1.55)
    else:
        film = Film(film_mesh(tmp_path, grooves), 1.55, accelerator=name)
    source = Source(LAMBERTIAN_BELOW, np.linspace(0, 0.25, 5), 0.05)
    tally = trace(build_scene([film]), source, 400, seed=52)
    assert tally.total_paths > 1e6
    assert tally.flow[LOST] == 0
    assert tally.flow[UP] + tally.flow[DOWN] == tally.total_paths


@pytest.mark.slow
@pytest.mark.parametrize("accelerator", ["chain", "bvh", "section", "grid"])
def test_no_path_is_lost_in_ten_million(accelerator):
    if accelerator == "grid":
        mesh = dish_mesh(cells=120)
    else:
        mesh = panel(392.25, REENTRANT if accelerator == "section" else SMOOTH)
    scene = build_scene([Film(mesh, 1.55, accelerator=accelerator)])
    places = np.linspace(0, 1, 20) * mesh.size[0]
    tally = trace(scene, Source(LAMBERTIAN_BELOW, places, 1.0), 1000, seed=56)
    assert tally.total_paths > 1e7
    assert tally.flow[LOST] == 0
    assert tally.flow[UP] + tally.flow[DOWN] == tally.total_paths


def panel(width, surface):
    """Return a film as wide as asked, drawn straight into float32 as an STL file would hold it."""
    x, z = row([surface] * round(width / PITCH), 0.2)
    x, z = (np.float32(v).astype(float) for v in (x, z))
    n, length = len(x), 2.0
    vertex = np.concatenate([np.c_[x, 0 * x, z], np.c_[x, 0 * x + length, z]])
    a = np.arange(n - 1)
    top = np.concatenate([np.c_[a, a + 1, a + 1 + n], np.c_[a, a + 1 + n, a + n]])
    return FilmMesh(vertex, top, (float(x[-1]), length, float(z.max())))


@pytest.mark.parametrize(
    ("width", "surface"),
    [(32.65, groove(60.0, chords=100)), (392.25, SMOOTH), (392.25, REENTRANT)],
    ids=["tile", "panel", "re-entrant panel"],
)
@pytest.mark.parametrize("accelerator", [None, "bvh"])
def test_no_path_is_lost_anywhere_on_the_panel(width, surface, accelerator):
    # At 390 mm a float32 step is 30 nm: facets are crooked there, but the mesh is still closed.
    mesh = panel(width, surface)
    scene = build_scene([Film(mesh, 1.55, accelerator=accelerator)], below=1.0)
    places = np.array([0.0, 0.5, 0.995, 1.0]) * mesh.size[0]
    for kind in (LAMBERTIAN_BELOW, EYE):
        tally = trace(scene, Source(kind, places, 1.0, acceptance=0.5), 40, seed=53)
        assert tally.flow[LOST] == 0
        assert tally.flow[:3].sum() == tally.paths * 4 == 160 * BLOCK


@pytest.mark.parametrize("surface", [SMOOTH, REENTRANT], ids=["chain", "section"])
def test_the_normal_luminance_is_the_same_all_over_the_panel(surface):
    mesh = panel(392.25, surface)
    near, far = (
        trace(build_scene([Film(mesh, 1.55)], below=1.0),
              Source(EYE, np.array([x]), 10.0, acceptance=0.5), 300, seed=54)
        for x in (10.0, 385.0)
    )  # fmt: skip
    within(near.radiance, far.radiance[0], np.hypot(near.radiance_error, far.radiance_error), 4)


def test_the_energy_of_a_whole_panel_closes():
    # 7,845 grooves, 12 lamps one of which is dim, walls: each loss has its name.
    mesh = panel(392.25, SMOOTH)
    given = {"extent": "panel", "lamp_3_luminance_factor": 0.5, "lamp_length_mm": 690.0}
    stack = read_stack("thesis-32in-mpf", overrides=given)
    elements = lower_stack(stack, mesh, -stack.origin[0])
    tally = trace(build_scene(elements), Source(LAMPS, np.zeros(1), 0.0), 150, seed=55)
    flow = tally.fraction
    assert flow.sum() == pytest.approx(1, abs=1e-12)
    assert flow[DOWN] == flow[LOST] == 0
    assert tally.fraction_error[ROULETTE] < 1e-3
    within(flow[ROULETTE], 0.0, tally.fraction_error[ROULETTE], 5)
    assert flow[WALLS] > 0.01 and flow[RIM] > 0.005 and flow[UP] > 0.4
