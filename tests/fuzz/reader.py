"""Every reader of the user's files, with files it reads to begin from."""

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from . import instrument, layers, option, written
from .kind import Reader

ROOT = Path(__file__).parents[2]
MASKS, TESTS = ROOT / "masks", ROOT / "tests"


def _files(*patterns: str) -> tuple[bytes, ...]:
    found = [path for pattern in patterns for path in sorted(ROOT.glob(pattern))]
    return tuple(path.read_bytes() for path in found if path.stat().st_size < 40_000)


def _job(path: Path) -> None:
    from mpfcad.job import read_job
    from mpfcad.pipeline.plan.plan import read_job_stack

    read_job_stack(read_job(path), path)


def _sweep(path: Path) -> None:
    from mpfcad.job.sweep import read_sweep
    from mpfcad.pipeline.point.trace import build_point

    sweep = read_sweep(path)
    for number, place in enumerate(sweep.points()):
        build_point(sweep, path, place)
        if number > 3:
            break


def _design(path: Path) -> None:
    from mpfcad.job.design import read_design

    read_design(path)


def _stack(path: Path) -> None:
    from mpfcad.backlight import read_stack

    read_stack(path)


def _process(path: Path) -> None:
    from mpfcad.film import Groove
    from mpfcad.film.process.file import read_process

    read_process(path, Groove(0.05, 0.025))


def _map(path: Path) -> None:
    from mpfcad.film.curvature.file import read_curvature_table

    read_curvature_table(path)


def _field(path: Path) -> None:
    from mpfcad.film import Groove
    from mpfcad.film.field.file import is_field_file, read_curvature_field

    if is_field_file(path):
        groove = Groove(0.05, 0.025)
        read_curvature_field(
            path, profile="filled", groove=groove, panel_width=10.0, panel_length=10.0
        )
    else:
        _map(path)


def _stylus(path: Path) -> None:
    from mpfcad.film import Groove
    from mpfcad.film.stylus.file.reading import read_stylus_trace

    read_stylus_trace(path, Groove(0.05, 0.025))


def _bsdf(path: Path) -> None:
    from mpfcad.optics.bsdf.file import read_bsdf
    from mpfcad.optics.bsdf.missing import Taken

    read_bsdf(path, taken=Taken(symmetric=True, reflection=0.1, transmission=0.5))


def _mesh(path: Path) -> None:
    from mpfcad.optics.solid.mesh import read_film_mesh

    read_film_mesh(path)


def _catalogue(path: Path) -> None:
    from mpfcad.mask.fabric.catalogue import read_catalogue

    read_catalogue(path)


def _manifest(path: Path) -> None:
    from mpfcad.export import MANIFEST, canonical_json, check_manifest
    from mpfcad.export.manifest import _sealed
    from mpfcad.export.text import encoded

    folder = path.with_suffix(".export")
    folder.mkdir(exist_ok=True)
    path.replace(folder / MANIFEST)
    # Sealed again where it is JSON: what lies behind the seal is to be reached.
    with suppress(ValueError, RecursionError, TypeError, AttributeError):
        text = (folder / MANIFEST).read_bytes()
        manifest = json.loads(text.replace(b'"files": {}', b'"files": {"in.json": 0}'))
        (folder / MANIFEST).write_bytes(encoded(canonical_json(_sealed(manifest))))
    check_manifest(folder)


def _npz() -> Iterator[bytes]:
    import io

    for arrays in (
        {"position_mm": np.arange(9.0), "curvature_per_mm": np.full(9, 60.0)},
        {
            "position_across_mm": np.linspace(0, 10, 5),
            "position_along_mm": np.linspace(0, 10, 4),
            "curvature_per_mm": np.full((4, 5), 60.0),
        },
    ):
        file = io.BytesIO()
        np.savez(file, **arrays)
        yield file.getvalue()


def _meshes() -> Iterator[bytes]:
    """Give a prism as text and binary STL, OBJ, OFF, PLY and 3MF."""
    import trimesh

    section = [(0, 0), (1, 0), (1, 0.2), (0.5, 0.1), (0, 0.2)]
    bottom = [(x, 0.0, z) for x, z in section]
    top = [(x, 1.0, z) for x, z in section]
    n = len(section)
    faces = [(i, (i + 1) % n, n + (i + 1) % n) for i in range(n)]
    faces += [(i, n + (i + 1) % n, n + i) for i in range(n)]
    ends = [(0, 3, 1), (1, 3, 2), (0, 4, 3)]
    faces += ends + [tuple(n + v for v in reversed(f)) for f in ends]
    faces = [face[::-1] for face in faces]
    mesh = trimesh.Trimesh(np.array(bottom + top), np.array(faces), process=False)
    yield _package(bottom + top, faces)
    for form in ("stl", "stl_ascii", "obj", "ply"):
        made = mesh.export(file_type=form)
        yield made.encode() if isinstance(made, str) else made


def _package(corners, faces) -> bytes:
    """Return a 3MF package of a mesh."""
    import io
    import zipfile

    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in corners)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    model = (
        f'<?xml version="1.0"?><model unit="millimeter" xmlns="{core}"><resources>'
        f'<object id="1" type="model"><mesh><vertices>{vertices}</vertices><triangles>{triangles}'
        '</triangles></mesh></object></resources><build><item objectid="1"/></build></model>'
    )
    types = (
        '<?xml version="1.0"?><Types '
        'xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default '
        'Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>'
        "</Types>"
    )
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("[Content_Types].xml", types)
        archive.writestr("3D/3dmodel.model", model)
    return file.getvalue()


_MANIFEST = (
    b'{\n "schema": 1,\n "name": "a",\n "kind": "run",\n "files": {},\n "self_sha256": "'
    + b"0" * 64
    + b'"\n}\n'
)
_TRACE = "x_um,z_um\n" + "".join(
    f"{x:.2f},{15 * ((x % 50 - 25) / 1000) ** 2 * 1000:.4f}\n" for x in np.arange(0, 200, 2.5)
)


def readers() -> list[Reader]:
    """Return every reader."""
    plain = b'name = "a"\n[map]\ncurvature_per_mm = 60.0\n'
    tables = (
        b'[film]\npitch_um = 50.0\n[mask]\nformats = ["oas"]\n[stack.override]\nlamp_count = 12\n'
    )
    toml = (plain, plain + tables, *_files("masks/uni*.toml", "masks/b*.toml", "masks/pat*.toml",
                                           "tests/cli/corpus/*.toml"))  # fmt: skip
    return [
        Reader("job", ".toml", _job, toml),
        Reader("sweep", ".toml", _sweep, _files("masks/sweep*.toml", "tests/cli/corpus/sw*.toml")),
        Reader("design", ".toml", _design, _files("masks/design*.toml")),
        Reader("stack", ".toml", _stack, _files("mpfcad/backlight/preset/*.toml", "masks/st*.toml",
                                                "tests/cli/corpus/*stack.toml")),
        Reader("process", ".toml", _process, _files("masks/process*.toml",
                                                    "tests/cli/corpus/process*.toml")),
        Reader("map", ".csv", _map, _files("masks/*.csv")),
        Reader("npz", ".npz", _field, (*_npz(), *_files("tests/cli/corpus/*.npz"))),
        Reader("stylus", ".csv", _stylus, (_TRACE.encode(),), costly=True),
        Reader("bsdf-xml", ".xml", _bsdf, _files("tests/optics/case/*.xml")),
        Reader("bsdf-zemax", ".bsdf", _bsdf, _files("tests/optics/case/*.bsdf",
                                                    "tests/cli/corpus/*.bsdf")),
        Reader("bsdf-csv", ".csv", _bsdf, tuple(
            data.replace(b"1000000000", b"4") for data in _files("tests/cli/corpus/*.csv"))),
        Reader("mesh", ".stl", _mesh, (*_meshes(), *_files("tests/cli/corpus/*.stl")), native=True),
        Reader("mesh-catalogue", ".csv", _catalogue, _files("mpfcad/mask/fabric/*.csv")),
        Reader("manifest", ".json", _manifest, (_MANIFEST,), named="manifest.json"),
        *written.readers(),
        *instrument.readers(),
        *layers.readers(),
        *option.readers(),
    ]  # fmt: skip
