"""Lens arrays and composites of bonded films: their meshes, their light, what is refused."""

import numpy as np
import pytest
from harness import aimed, pass_layers, rays, through, within

from mpfcad.backlight import read_stack
from mpfcad.backlight.array_mesh import bef_mesh, composite_mesh, lens_mesh
from mpfcad.backlight.lower import lower_stack
from mpfcad.errors import InputError
from mpfcad.optics.element import Film, Slab
from mpfcad.optics.scene import build_scene

FLAT, CROSSED = (0.05, 0.0), (0.04, 0.02)


def composite(bond=0.003, upper=FLAT):
    return composite_mesh("x", 0.05, 0.025, 0.2, bond, 0.125, upper)


MESHES = {
    "lens": lambda: lens_mesh("x", 0.05, 0.012, 0.2),
    "half spheres": lambda: lens_mesh("x", 0.05, 0.05 / np.sqrt(3), 0.2),
    "flat": composite,
    "crossed": lambda: composite(upper=CROSSED),
}


@pytest.mark.parametrize("name", MESHES)
def test_meshes_repeat_and_have_no_gap(name):
    mesh = MESHES[name]()
    width, length, high = mesh.size
    corner = mesh.vertex[mesh.top]
    assert corner[..., 2].min() > 0 and corner[..., 2].max() == pytest.approx(high, abs=1e-12)
    # Each edge stands in two facets, once in each direction, where the tile is bent to a torus;
    # the ends of a void count as such.
    place = np.round(corner / (width, length, 1) * 1e9).astype(np.int64)
    place[..., :2] %= 10**9
    edges = {}
    for a, b in ((0, 1), (1, 2), (2, 0)):
        for p, q in zip(map(tuple, place[:, a]), map(tuple, place[:, b]), strict=True):
            edges[p, q] = edges.get((p, q), 0) + 1
    assert all(n == edges.get((q, p), 0) for (p, q), n in edges.items())
    area = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] / 2
    assert area.sum() == pytest.approx(width * length, rel=1e-12)


def test_lenses_are_spheres_over_hexagons():
    pitch, sag, base = 0.05, 0.012, 0.2
    mesh = lens_mesh("x", pitch, sag, base)
    reach = pitch / np.sqrt(3)
    radius = (reach**2 + sag**2) / (2 * sag)
    x, y, z = mesh.vertex.T
    a, b = np.meshgrid(np.arange(-1, 4), np.arange(-1, 4))
    middle = np.stack([(a + b % 2 / 2).ravel() * pitch, b.ravel() * pitch * np.sqrt(3) / 2], 1)
    away = np.hypot(x - middle[:, :1], y - middle[:, 1:]).min(axis=0)
    top = base + sag - radius + np.sqrt(radius**2 - away**2)
    cut = ((y == 0) | (y == mesh.size[1])) & (np.round(x / pitch * 32).astype(int) % 2 == 1)
    assert np.abs(z - top)[~cut].max() < 1e-12
    assert (z <= top + 1e-12).all() and np.abs(z - top).max() < 1e-4  # an edge halved: a chord
    assert z.max() == pytest.approx(base + sag) and z.min() == pytest.approx(base)


@pytest.mark.parametrize("name", ["lens", "flat", "crossed"])
def test_lambertian_light_from_both_sides_leaves_lambertian(name):
    scene, count, k = build_scene([Film(MESHES[name](), 1.55)]), 40_000, []
    for below in (True, False):
        out = np.empty((count, 4))
        pass_layers(scene, below, 63 + below, out)
        assert (out[:, 0] != 0).all() and (out[:, 3] == 1).all()
        k.append(out[out[:, 0] == 1, 1:3])
    k = np.concatenate(k)
    within(len(k), count, np.sqrt(count / 2), 4)
    number, *_ = np.histogram2d(
        (k**2).sum(axis=1), np.arctan2(k[:, 1], k[:, 0]), (8, 10), ((0, 1), (-np.pi, np.pi))
    )
    within(((number - count / 80) ** 2 / (count / 80)).sum(), 80, np.sqrt(160), 4)


@pytest.mark.parametrize("name", ["flat", "crossed"])
def test_voids_are_met_alike_by_every_accelerator(name):
    mesh = MESHES[name]()
    for up in (True, False):
        start = rays(3000, up, size=mesh.size[:2])
        found = [through(mesh, start, up, way) for way in ("grid", "bvh")]
        assert np.array_equal(*found) and (found[0][:, 0] != 0).all()
        assert (through(mesh, aimed(mesh, up, 500), up)[:, 0] != 0).all()


def transmittance(elements, count=60_000):
    out = np.empty((count, 4))
    pass_layers(build_scene(elements), True, 71, out)
    return np.mean(out[:, 0] == 1), np.sqrt(0.25 / count)


def test_a_faint_bond_leaves_a_prism_film_under_a_plate():
    # 0.02 µm of 25: four of 5000 parts of the width are bonded, whatever those pass.
    apart, error = transmittance([Film(bef_mesh(0.05, 0.025, 0.2), 1.55), Slab(1.55, 0.125)])
    bonded, _ = transmittance([Film(composite(2e-5), 1.55)])
    within(bonded, apart, error * np.sqrt(2) + 4e-4, 4)


def test_a_wide_bond_leaves_a_plate():
    # All but 4e-4 of the grooves is filled with the bond.
    plate, error = transmittance([Slab(1.55, 0.35)])
    filled, _ = transmittance([Film(composite(0.025 * (1 - 2e-4)), 1.55)])
    within(filled, plate, error * np.sqrt(2) + 4e-4, 4)
    assert transmittance([Film(composite(), 1.55)])[0] < plate - 0.1


def write(folder, layer):
    (folder / "s.toml").write_text(
        f'extends = "thesis-32in-mpf"\nlayers = ["clear_plate", "film", {layer}]\n'
    )
    return folder / "s.toml"


def lowered(folder, layer):
    return lower_stack(read_stack(write(folder, layer)), bef_mesh(0.05, 0.025, 0.2))[-1]


def test_layers_make_their_meshes(tmp_path):
    lens = lowered(tmp_path, '{ kind = "lens", sag_um = 10, rotation_deg = 90, index = 1.5 }')
    assert lens.mesh.size == pytest.approx((0.05, 0.05 * np.sqrt(3), 0.21)) and lens.index == 1.5
    layer = '{ kind = "composite", bond_um = 2, upper_depth_um = 20, upper_pitch_um = 40 }'
    both = lowered(tmp_path, layer)
    assert both.mesh.size == pytest.approx((0.05, 0.04, 0.2 + 0.023 + 0.125 + 0.02))
    assert both.rotation == 0.0 and both.index_below == 1.0


@pytest.mark.parametrize(
    ("layer", "words"),
    [
        ('{ kind = "lens", sag_um = 40 }', "sag_um: 40: expected at most half a sphere"),
        ('{ kind = "composite" }', "bond_um: missing"),
        ('{ kind = "composite", bond_um = 25 }', "bond_um: 25: expected above 0 and below"),
        ('{ kind = "composite", bond_um = 5, cover_um = 4 }', "cover_um: 4: expected above"),
        ('{ kind = "sheet", sigma = -0.1 }', "sigma: -0.1: expected a number in 0"),
        ('{ kind = "sheet", sigma = 0.1, sigma_across = -1 }', "sigma_across: -1: expected"),
        ('{ kind = "sheet", sigma = 0.1, axis_deg = 20 }', "sigma_across: missing"),
        (
            '{ kind = "sheet", sigma = 0.1, sigma_across = 0.2, axis_deg = inf }',
            "axis_deg: inf: expected a number",
        ),
        ('{ kind = "sheet", sigma = 0.1, wide_share = 0.2 }', "wide_sigma: missing"),
        ('{ kind = "sheet", sigma = 0.1, wide_sigma = 0.2 }', "wide_share: missing"),
        (
            '{ kind = "sheet", sigma = 0.1, wide_sigma = 1, wide_share = 1.5 }',
            "wide_share: 1.5: expected a number in 0 … 1",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(tmp_path, layer, words):
    with pytest.raises(InputError) as error:
        lowered(tmp_path, layer)
    assert words in str(error.value) and "\n" not in str(error.value)
    assert len(str(error.value)) <= 300


def test_a_sheet_has_the_lobes_that_its_layer_states(tmp_path):
    plain = lowered(tmp_path, '{ kind = "sheet", name = "a", sigma = 0.1 }')
    assert (plain.sigma_across, plain.axis, plain.wide_share) == (None, 0.0, 0.0)
    layer = '{ kind = "sheet", sigma = 0.1, sigma_across = 0.02, axis_deg = 90'
    one = lowered(tmp_path, layer + ", wide_sigma = 0.5, wide_share = 0.2 }")
    assert (one.sigma_across, one.wide_sigma, one.wide_share) == (0.02, 0.5, 0.2)
    assert one.axis == pytest.approx(np.pi / 2)
    # Values that are left out are none of the stack's, as in stacks of before.
    stack = read_stack(write(tmp_path, '{ kind = "sheet", name = "a", sigma = 0.1 }'))
    names = [entry["name"] for entry in stack.inputs() if str(entry["name"]).startswith("a.")]
    assert names == ["a.sigma", "a.index", "a.transmission"]
