"""Films of several materials: bonded layers under the prisms, and absorption along the path."""

import math

import numpy as np
import pytest
from harness import BARE, film_mesh, groove, pass_layers
from test_reference import CAVITY, CLEAR, TOP, compare

from mpfcad.backlight import read_stack
from mpfcad.backlight.lower import lower_stack
from mpfcad.errors import InputError, TraceError
from mpfcad.optics.element import Film, Slab
from mpfcad.optics.library.piece import Library
from mpfcad.optics.scene import build_scene

MIXED = [groove(60.0, chords=6), groove(45.0, chords=6)]
PET = Slab(1.65, 0.125, 0.0, 0.4, bonded=True, name="film base")
PRIMER = Slab(1.58, 0.02, 0.0, 2.0, bonded=True, name="film primer", index_below=1.65)
COUNT = 200_000


def passed(elements, enter_below, seed=1, count=COUNT):
    """Return transmittance and reflectance of Lambertian light, with their standard errors."""
    out = np.empty((count, 4))
    pass_layers(build_scene(elements), enter_below, seed, out)
    on = out[:, 0] == (1.0 if enter_below else -1.0)
    back = (out[:, 0] != 0.0) & ~on
    share = [np.where(one, out[:, 3], 0.0) for one in (on, back)]
    return [(s.mean(), s.std() / math.sqrt(count)) for s in share]


def plates(mu, layers):
    """Return (T, R) of a pile of plates (index, thickness, absorption) in air, by adding.

    Interfaces and absorbing gaps are added from the bottom, incoherently (G. G. Stokes, 1862).
    """
    sine = math.sqrt(1 - mu**2)
    index = [1.0, *(n for n, _, _ in layers), 1.0]
    cosine = [math.sqrt(1 - (sine / n) ** 2) for n in index]

    def interface(i):
        (n1, n2), (c1, c2) = index[i : i + 2], cosine[i : i + 2]
        s, p = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2), (n1 * c2 - n2 * c1) / (n1 * c2 + n2 * c1)
        return (s**2 + p**2) / 2

    t, r, back = 1 - interface(0), interface(0), interface(0)
    for i, (_, thickness, absorption) in enumerate(layers):
        through = math.exp(-absorption * thickness / cosine[i + 1])
        top = interface(i + 1)
        # What is below, seen from the far end of this plate.
        t, back = t * through, back * through**2
        many = 1 / (1 - back * top)
        r = r + t * top * many * t
        t, back = t * many * (1 - top), top + (1 - top) ** 2 * back * many
    return t, r


def test_bonded_plates_are_the_closed_form():
    layers = [(1.65, 0.125, 0.4), (1.58, 0.02, 2.0), (1.5, 0.05, 1.0)]
    top = Slab(1.5, 0.05, 0.0, 1.0, index_below=1.58)
    node, weight = np.polynomial.legendre.leggauss(200)
    mu, weight = (node + 1) / 2, weight / 2
    exact = np.array([plates(m, layers) for m in mu])
    wanted = 2 * (exact * (mu * weight)[:, None]).sum(axis=0)
    found = passed([PET, PRIMER, top], True)
    for (value, error), expected in zip(found, wanted, strict=True):
        assert abs(value - expected) < 4 * error + 1e-4, (value, expected, error)


def test_layers_of_the_films_index_are_the_film_alone(tmp_path):
    mesh = film_mesh(tmp_path, [BARE])
    base = Slab(1.5, 0.05, bonded=True)
    (whole, error), _ = passed([Film(mesh, 1.5)], True)
    assert abs(whole - 0.5382) < 4 * error
    thinner = film_mesh(tmp_path, [BARE], base=0.1)
    (split, _), _ = passed([base, Film(thinner, 1.5, 1.5)], True, seed=2)
    assert abs(split - whole) < 4 * math.sqrt(2) * error


@pytest.mark.parametrize("absorption", [0.0, 1.5])
def test_light_passes_both_ways_alike(tmp_path, absorption):
    # Reciprocity: Lambertian light is transmitted alike from both sides, absorbed or not.
    film = Film(film_mesh(tmp_path, MIXED), 1.5, 1.58, absorption=absorption)
    base = Slab(1.65, 0.125, 0.0, absorption, bonded=True)
    primer = Slab(1.58, 0.02, bonded=True, index_below=1.65)
    up, down = (passed([base, primer, film], side) for side in (True, False))
    assert abs(up[0][0] - down[0][0]) < 4 * math.hypot(up[0][1], down[0][1])
    if absorption == 0:
        for (t, _), (r, _) in (up, down):
            assert t + r == pytest.approx(1, abs=1e-12)
    else:
        assert up[0][0] + up[1][0] < 0.9


def test_every_path_is_the_oracles(tmp_path):
    film = Film(film_mesh(tmp_path, MIXED), 1.5, 1.58, offset=0.013, absorption=3.0)
    compare([CAVITY, CLEAR, PET, PRIMER, film, TOP], 40, grown=1 / 40)
    turned = Film(film_mesh(tmp_path, MIXED), 1.5, rotation=0.4, absorption=3.0)
    compare([CAVITY, turned], 40, grown=1 / 40)


def test_a_stack_lowers_the_films_layers(tmp_path):
    path = tmp_path / "stack.toml"
    path.write_text(
        'extends = "thesis-32in-mpf"\n[value]\nfilm_index = 1.5\nfilm_absorption_per_mm = 0.5\n'
        "film_base_index = 1.65\nfilm_base_thickness_um = 125\nfilm_base_absorption_per_mm = 0.1\n"
        "film_primer_index = 1.58\nfilm_primer_thickness_um = 5\n"
    )
    mesh = film_mesh(tmp_path, MIXED)
    stack = read_stack(path)
    elements = lower_stack(stack, mesh)
    names = [element.name for element in elements]
    at = names.index("film base")
    base, primer, film = elements[at : at + 3]
    assert (base.index, base.thickness, base.absorption, base.index_below) == (1.65, 0.125, 0.1, 1)
    assert (primer.index, primer.index_below, film.index_below) == (1.58, 1.65, 1.58)
    assert film.absorption == 0.5
    assert film.mesh.size[2] == pytest.approx(mesh.size[2] - 0.13)
    assert film.mesh.vertex[film.mesh.used, 2].min() > 0
    build_scene(elements)
    assert "film_base_index" in {row["name"] for row in stack.inputs()}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ("film_base_index = 1.65", "value.film_base_thickness_um: missing: expected with"),
        ("film_base_index = 0.9\nfilm_base_thickness_um = 1", "film_base_index: 0.9"),
        ("film_absorption_per_mm = -1", "film_absorption_per_mm: -1"),
    ],
)
def test_wrong_materials_are_refused(tmp_path, values, words):
    path = tmp_path / "stack.toml"
    path.write_text(f'extends = "thesis-32in-mpf"\n[value]\n{values}\n')
    with pytest.raises(InputError) as error:
        read_stack(path)
    assert words in str(error.value)


def test_layers_thicker_than_the_film_are_refused(tmp_path):
    path = tmp_path / "stack.toml"
    path.write_text(
        'extends = "thesis-32in-mpf"\n[value]\nfilm_base_index = 1.65\n'
        "film_base_thickness_um = 500\n"
    )
    mesh = film_mesh(tmp_path, MIXED)
    with pytest.raises(InputError, match=r"500 µm thick together: expected at most 156\.249"):
        lower_stack(read_stack(path), mesh)
    with pytest.raises(TraceError, match=r"index_below 1: expected the index of film base, 1\.65"):
        build_scene([PET, Film(mesh, 1.5)])
    with pytest.raises(InputError, match="absorption"):
        Film(mesh, 1.5, absorption=-1.0)


def test_a_slot_with_values_of_its_own_has_the_films_layers_too(tmp_path):
    path = tmp_path / "stack.toml"
    slot = '{ kind = "film", name = "turned", rotation_deg = 30, index = 1.52 }'
    layers = f'layers = ["clear_plate", {slot}]\n'
    values = "[value]\nfilm_base_index = 1.65\nfilm_base_thickness_um = 125\n"
    path.write_text(f'extends = "thesis-32in-mpf"\n{layers}{values}')
    mesh = film_mesh(tmp_path, MIXED)
    elements = lower_stack(read_stack(path), mesh)
    assert [one.name for one in elements] == ["reflector", "plate", "film base", "turned"]
    film = elements[-1]
    assert (film.index, film.index_below, film.rotation) == (1.52, 1.65, math.radians(30))
    build_scene(elements)
    path.write_text(
        'extends = "thesis-32in-mpf"\n'
        f"{layers.replace('rotation_deg = 30', 'flipped = true')}{values}"
    )
    with pytest.raises(InputError, match="turned: flipped: a film with base or primer"):
        read_stack(path)
    path.write_text(f'extends = "thesis-32in-mpf"\n{layers}[value]\nfilm_absorption_per_mm = 0.1\n')
    with pytest.raises(InputError, match=r"expected turned\.absorption_per_mm"):
        read_stack(path)


def test_a_library_of_pieces_has_base_and_primer(tmp_path):
    path = tmp_path / "stack.toml"
    text = (
        'extends = "thesis-32in-mpf"\n[value]\nfilm_base_index = 1.65\n'
        "film_base_thickness_um = 125\nfilm_base_absorption_per_mm = 0.1\n"
    )
    path.write_text(text)
    x, z = groove(60.0, chords=6)
    piece = np.stack([x - x[0], z + 0.15], axis=1)
    library = Library(0.05, 0.05, (piece,), np.zeros((2, 2), np.int64))
    as_pieces = lower_stack(read_stack(path), library)[-3:]
    as_mesh = lower_stack(read_stack(path), film_mesh(tmp_path, [(x, z)]))[-3:]
    assert [one.name for one in as_pieces] == [one.name for one in as_mesh]
    assert as_pieces[1].index_below == as_mesh[1].index_below == 1.65
    assert as_pieces[1].library.high == pytest.approx(as_mesh[1].mesh.size[2], abs=1e-8)
    build_scene(as_pieces)
    path.write_text(text + "resin_index = 1.5\n")
    with pytest.raises(InputError, match="a film of instances: expected upright, clear and smooth"):
        lower_stack(read_stack(path), library)
    path.write_text(text.replace("125", "157"))
    with pytest.raises(InputError, match=r"157 µm thick together: expected at most 156\.249 µm"):
        lower_stack(read_stack(path), library)
    path.write_text(text.replace("125", "156.25"))
    with pytest.raises(InputError, match=r"156\.25 µm thick together: expected .* 156\.249 µm"):
        lower_stack(read_stack(path), library)


def test_a_primer_needs_a_base_under_it(tmp_path):
    path = tmp_path / "stack.toml"
    primer = "film_primer_index = 1.58\nfilm_primer_thickness_um = 5\n"
    path.write_text(f'extends = "thesis-32in-mpf"\n[value]\n{primer}')
    with pytest.raises(InputError, match=r"value\.film_base_thickness_um: missing: expected under"):
        read_stack(path)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ('[value]\nfilm_index = "1.5"\n', r"film_index: '1\.5': expected a number"),
        ('[value]\nfilm_index = { value = 1.5, sigma = "0.1" }\n', r"sigma: '0\.1': expected"),
        ('layers = ["1"]\n', r"layers: '1': expected one of"),
        ('[source]\nkind = "7"\n', r"source\.kind: '7': expected"),
        ("[source]\nkind = 7\n", r"source\.kind: 7: expected"),
        ('[source]\nkind = "leds"\nlattice = "square"\nemission = "batwing"\nseed = "1"\n',
         r"seed: '1': expected a whole number"),
    ],
)  # fmt: skip
def test_a_text_where_a_number_belongs_is_shown_as_a_text(tmp_path, table, says):
    path = tmp_path / "stack.toml"
    path.write_text(f'extends = "thesis-32in-mpf"\n{table}')
    with pytest.raises(InputError, match=says):
        read_stack(path)
