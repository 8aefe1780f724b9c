"""One film in every format: read as the same solid; what was understood is said."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from harness import BARE, extruded, film_file, row, write_facets

from mpfcad.cad import write_3mf, write_ply, write_step, write_stl
from mpfcad.errors import InputError
from mpfcad.film import Groove, PrismFilm
from mpfcad.optics.solid.closed import volume
from mpfcad.optics.solid.file import read_solid
from mpfcad.optics.solid.mesh import read_film_mesh

CASE = Path(__file__).parent / "case"


@pytest.fixture
def facets():
    return np.round(extruded(*row([BARE] * 2, 0.15), 0.1), 9)


def welded(facets):
    point, number = np.unique(facets.reshape(-1, 3), axis=0, return_inverse=True)
    return point, number.reshape(-1, 3)


def stl_text(facets, bodies=1):
    lines = []
    for n, part in enumerate(np.array_split(facets, bodies)):
        lines.append(f"solid part {n}")
        for corner in part:
            rows = "\n".join("vertex {:.9e} {:.9e} {:.9e}".format(*p) for p in corner)
            lines.append(f"facet normal 0 0 0\nouter loop\n{rows}\nendloop\nendfacet")
        lines.append(f"endsolid part {n}")
    return "\r\n".join(lines)


def obj(facets):
    point, number = welded(facets)
    rows = ["# a film", "o film", *("v {:.9f} {:.9f} {:.9f}".format(*p) for p in point)]
    # One based; some by negative numbers, some with texture and normal left out.
    for n, (a, b, c) in enumerate(number):
        if n % 2:
            rows.append(f"f {a + 1}// {b + 1}// {c + 1}//")
        else:
            rows.append(f"f {a - len(point)} {b - len(point)} {c - len(point)}")
    return "\n".join(rows).replace("//", "")


def ply(facets, binary):
    point, number = welded(facets)
    head = (
        f"ply\nformat {'binary_little_endian' if binary else 'ascii'} 1.0\nelement vertex "
        f"{len(point)}\nproperty double x\nproperty double y\nproperty double z\nelement face "
        f"{len(number)}\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()
    if binary:
        record = np.zeros(len(number), [("n", "u1"), ("v", "<i4", 3)])
        record["n"], record["v"] = 3, number
        return head + point.astype("<f8").tobytes() + record.tobytes()
    rows = [" ".join(f"{v:.9f}" for v in p) for p in point]
    return head + "\n".join([*rows, *(f"3 {a} {b} {c}" for a, b, c in number), ""]).encode()


def threemf(path, facets, unit="millimeter", factor=1.0, build='<item objectid="1"/>', more=""):
    point, number = welded(facets * factor)
    vertices = "".join('<vertex x="{:.12g}" y="{:.12g}" z="{:.12g}"/>'.format(*p) for p in point)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in number)
    model = (
        f'<?xml version="1.0"?><model unit="{unit}" xmlns="http://schemas.microsoft.com/'
        '3dmanufacturing/core/2015/02"><resources><object id="1" type="model" name="film"><mesh>'
        f"<vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh></object>{more}"
        f"</resources><build>{build}</build></model>"
    )
    package = "http://schemas.openxmlformats.org/package/2006"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{package}/content-types"><Default Extension="rels" ContentType='
            '"application/vnd.openxmlformats-package.relationships+xml"/><Default Extension='
            '"model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
            "</Types>",
        )
        archive.writestr(
            "_rels/.rels",
            f'<Relationships xmlns="{package}/relationships"><Relationship Id="a" Target='
            '"/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/'
            '3dmodel"/></Relationships>',
        )
        archive.writestr("3D/3dmodel.model", model)
    return path


def same(path, facets, words):
    mesh, plain = read_film_mesh(path), read_film_mesh(write_facets(path.parent / "p.stl", facets))
    assert mesh.size == pytest.approx(plain.size, abs=1e-7)
    assert len(mesh.top) == len(plain.top) and mesh.underside
    order = [np.lexsort(np.round(m.vertex[m.top].mean(axis=1), 6).T) for m in (mesh, plain)]
    corner = [m.vertex[m.top].mean(axis=1)[o] for m, o in zip((mesh, plain), order, strict=True)]
    np.testing.assert_allclose(corner[0], corner[1], atol=2e-8)
    assert words in mesh.note and mesh.note.startswith(f"read {path.name}: ")
    return mesh


@pytest.mark.parametrize("binary", [False, True])
def test_ply(tmp_path, facets, binary):
    path = tmp_path / "film.ply"
    path.write_bytes(ply(facets, binary))
    same(path, facets, "PLY, taken as mm")


def test_stl_text_and_its_parts(tmp_path, facets):
    path = tmp_path / "film.stl"
    path.write_text(stl_text(facets))
    same(path, facets, "STL as text")
    path.write_text(stl_text(facets).replace("vertex", "vertex 1", 1))
    with pytest.raises(InputError, match=r"film\.stl: line 4: .*: expected vertex and three"):
        read_film_mesh(path)


def test_obj(tmp_path, facets):
    path = tmp_path / "film.obj"
    path.write_text(obj(facets))
    same(path, facets, "OBJ, taken as mm")


def test_3mf_in_inches(tmp_path, facets):
    path = threemf(tmp_path / "film.3mf", facets, "inch", 1 / 25.4)
    same(path, facets, "unit inch converted to mm")


def test_3mf_instances_are_placed(tmp_path, facets):
    # The film once as it is, once more beside it: components of an assembly, moved by the item.
    wide = facets[:, :, 0].max()
    place = '<component objectid="1" transform="1 0 0 0 1 0 0 0 1 {} 0 0"/>'
    more = (
        f'<object id="2" type="model"><components>{place.format(0)}{place.format(wide)}'
        "</components></object>"
    )
    item = '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 5 -3 1"/>'
    path = threemf(tmp_path / "film.3mf", facets, build=item, more=more)
    mesh = read_film_mesh(path)
    assert mesh.size == pytest.approx((2 * wide, 0.1, 0.175), abs=1e-8)
    assert "2 bodies (film) taken as one solid" in mesh.note
    whole = read_solid(path)
    assert whole.vertex.min(axis=0) == pytest.approx([5, -3, 1])
    single = read_solid(threemf(tmp_path / "one.3mf", facets))
    assert volume(whole.vertex, whole.facet) == pytest.approx(
        2 * volume(single.vertex, single.facet), rel=1e-9
    )


def test_a_mirrored_instance_is_turned_outward(tmp_path, facets):
    item = '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'
    solid = read_solid(threemf(tmp_path / "film.3mf", facets, build=item))
    assert volume(solid.vertex, solid.facet) > 0


@pytest.mark.parametrize("form", ["3mf", "ply", "step"])
def test_our_own_files_are_films_again(tmp_path, form):
    film = PrismFilm(Groove(0.050, 0.025), 0.15, 0.2, "filled", np.full(4, 60.0))
    path, angle = tmp_path / f"film.{form}", np.radians(0.5)
    if form == "step":
        write_step(film, path)
    else:
        {"3mf": write_3mf, "ply": write_ply}[form](film, path, angle)
    write_stl(film, tmp_path / "film.stl", angle)
    mesh, plain = read_film_mesh(path), read_film_mesh(tmp_path / "film.stl")
    assert mesh.size == pytest.approx(plain.size, abs=1e-6)
    assert mesh.underside
    solid = read_solid(path)
    assert volume(solid.vertex, solid.facet) == pytest.approx(film.volume, rel=1e-4)
    assert (" bodies (" in mesh.note) == (form != "ply")


def test_the_slab_as_text_and_with_bytes_after_it():
    text = read_film_mesh(CASE / "slab-ascii.stl")
    more = read_film_mesh(CASE / "slab-trailing-bytes.stl")
    assert text.size == more.size == (1.0, 1.0, 1.0)
    assert "2 bytes after the last facet left out" in more.note


def test_corners_that_differ_in_the_last_step_are_joined(tmp_path, facets):
    single = facets.astype("<f4")
    moved = single.copy()
    rng = np.random.default_rng(1)
    chosen = rng.random(moved.shape) < 0.2
    up = np.nextafter(moved, np.float32(9))
    moved = np.where(chosen & (moved > 0), up, moved)
    path = write_facets(tmp_path / "a.stl", moved)
    mesh = read_film_mesh(path)
    assert "corners that differ in the last step of float32 joined" in mesh.note
    plain = read_film_mesh(write_facets(tmp_path / "b.stl", single))
    assert mesh.size == pytest.approx(plain.size, abs=1e-7)
    assert len(mesh.top) == len(plain.top)
    # Two steps apart is another corner.
    far = np.where(chosen & (single > 0), np.nextafter(np.nextafter(up, np.float32(9)), 9), single)
    with pytest.raises(InputError, match="open or inconsistently oriented"):
        read_film_mesh(write_facets(tmp_path / "c.stl", far))


def test_upside_down_and_far_away_are_said(tmp_path, facets):
    turned = facets * [1, -1, -1]
    mesh = read_film_mesh(write_facets(tmp_path / "a.stl", turned))
    assert mesh.note.endswith("the film lies upside down: its flat side is up, and is traced so")
    flat = read_film_mesh(film_file(tmp_path / "b.stl", [BARE]))
    assert "upside down" not in flat.note and "float32" not in flat.note
    solid = read_solid(write_facets(tmp_path / "c.stl", facets + np.array([20_000.0, 0, 0])))
    assert "coordinates up to 20000.1 mm: float32 steps of 2 µm spoil" in solid.note[0]


@pytest.mark.parametrize(
    ("name", "data", "words"),
    [
        ("a.stl", b"\x89PNG\r\n\x1a\n" + bytes(200), "looks like a PNG image: expected STL, 3MF"),
        ("a.stl", b"%PDF-1.4\n" + b"x" * 200, "looks like a PDF"),
        ("a.x_t", b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ*", "looks like a Parasolid file"),
        ("a.igs", b"x" * 72 + b"S      1\n" + b"y" * 80, "looks like an IGES file"),
        ("a.sldprt", b"\xd0\xcf\x11\xe0" + bytes(600), "looks like an OLE file"),
        ("a.dxf", b"  0\nSECTION\n  2\nHEADER\n", "looks like a DXF drawing"),
        ("a.zip", b"PK\x03\x04" + bytes(100), "looks like a ZIP archive without a 3MF model"),
        ("a.glb", b"glTF" + bytes(100), "looks like a glTF binary"),
        ("a.txt", b"hello", "looks like no known kind of file"),
        ("a.step", b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n", "STEP"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 1\nend_header\n", "PLY"),
        ("a.obj", b"v 0 0 0\nf 1 2 3\n", "OBJ"),
    ],
)
def test_what_is_no_mesh_is_named(tmp_path, name, data, words):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError) as error:
        read_film_mesh(tmp_path / name)
    assert words in str(error.value) and str(tmp_path / name) in str(error.value)
    assert "\n" not in str(error.value)
