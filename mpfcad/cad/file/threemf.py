"""Write the film as a 3MF file: unit mm, bodies `BEF` and `fill` as components of one assembly."""

import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from mpfcad.cad.shape.body_mesh import build_body_meshes
from mpfcad.cad.shape.mesh import Mesh
from mpfcad.cad.step.grooves import COLOURS
from mpfcad.film import PrismFilm

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
_PACKAGE = "http://schemas.openxmlformats.org/package/2006"
XML = '<?xml version="1.0" encoding="UTF-8"?>\n'
_TYPES = (
    f'{XML}<Types xmlns="{_PACKAGE}/content-types"><Default Extension="rels" ContentType='
    '"application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" '
    'ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>'
)
_RELATIONS = (
    f'{XML}<Relationships xmlns="{_PACKAGE}/relationships"><Relationship Id="model" Target='
    '"/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>'
    "</Relationships>"
)
#: Where a component stands: the bodies are drawn in place.
_IN_PLACE = "1 0 0 0 1 0 0 0 1 0 0 0"
#: Significant digits of a coordinate: 1e-9 mm at 390 mm.
DIGITS = 12
#: Rows turned into text at a time.
_CHUNK = 100_000


def write_3mf(film: PrismFilm, path: Path, angle_tolerance: float, *, name: str = "film") -> None:
    """Write each body as a mesh of its own, with facets within `angle_tolerance` [rad].

    Coordinates are decimal numbers of doubles, not rounded to float32. Same film, same bytes.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    """
    write_3mf_meshes(build_body_meshes(film, angle_tolerance), path, name)


def write_3mf_meshes(meshes: dict[str, Mesh], path: Path, name: str) -> None:
    """Write closed meshes as the components of one assembly, by the names of their bodies."""
    store_package(Path(path), _model(meshes, name))


def store_package(path: Path, model: Iterator[str]) -> None:
    """Write a 3MF package about a model's text, whole or not at all."""
    part = path.with_name("." + path.name + ".part")
    try:
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            _store(archive, "[Content_Types].xml", iter([_TYPES]))
            _store(archive, "_rels/.rels", iter([_RELATIONS]))
            _store(archive, "3D/3dmodel.model", model)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _store(archive: zipfile.ZipFile, name: str, chunks: Iterator[str]) -> None:
    # A fixed date: the same film gives the same bytes.
    entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
    entry.compress_type = zipfile.ZIP_DEFLATED
    with archive.open(entry, "w", force_zip64=True) as file:
        for chunk in chunks:
            file.write(chunk.encode())


def _model(meshes: dict[str, Mesh], name: str) -> Iterator[str]:
    """Yield the model: materials, a mesh object a body, the assembly, and what is to be built."""
    yield f'{XML}<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}">'
    yield f'<metadata name="Title">{quoteattr(name)[1:-1]}</metadata>'
    yield '<metadata name="Application">mpfcad</metadata><resources><basematerials id="1">'
    for body in meshes:
        colour = "".join(f"{round(part * 255):02X}" for part in COLOURS[body])
        yield f'<base name="{body}" displaycolor="#{colour}"/>'
    yield "</basematerials>"
    for index, (body, mesh) in enumerate(meshes.items()):
        yield f'<object id="{index + 2}" type="model" name="{body}" pid="1" pindex="{index}"><mesh>'
        yield from mesh_rows(mesh)
        yield "</mesh></object>"
    whole = len(meshes) + 2
    yield f'<object id="{whole}" type="model" name={quoteattr(name)}><components>'
    for index in range(len(meshes)):
        yield f'<component objectid="{index + 2}" transform="{_IN_PLACE}"/>'
    yield f'</components></object></resources><build><item objectid="{whole}"/></build></model>'


def mesh_rows(mesh: Mesh) -> Iterator[str]:
    """Yield a mesh's vertices and triangles."""
    yield from _rows("vertices", f"vertex {_attributes('xyz', f'%.{DIGITS}g')}", mesh.vertices)
    triangle = f"triangle {_attributes(('v1', 'v2', 'v3'), '%d')}"
    yield from _rows("triangles", triangle, mesh.triangles)


def _attributes(names: Sequence[str], form: str) -> str:
    return " ".join(f'{name}="{form}"' for name in names)


def _rows(tag: str, form: str, values: np.ndarray) -> Iterator[str]:
    """Yield one element a row of `values`, (n, 3)."""
    yield f"<{tag}>"
    for first in range(0, len(values), _CHUNK):
        chunk = values[first : first + _CHUNK]
        yield (f"<{form}/>" * len(chunk)) % tuple(chunk.ravel().tolist())
    yield f"</{tag}>"
