"""A stack lowered to the elements that are traced."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.backlight.film_layer import lower_film
from mpfcad.backlight.particle import build_particles
from mpfcad.backlight.quantity import FILM_LAYERS
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.optics.element import BsdfSheet, Element, Film, LibraryFilm, Sheet, Slab
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.library.file import is_library_file, read_library
from mpfcad.optics.library.piece import Library
from mpfcad.optics.search.chain import build_chain
from mpfcad.optics.solid.mesh import FilmMesh, read_film_mesh
from mpfcad.units import deg, um


def lower_stack(
    stack: Stack, mesh: FilmMesh | Library | None, offset: float = 0.0
) -> list[Element]:
    """Return the traced elements from the bottom up; x = 0 is a lamp's axis, y = 0 the middle.

    `offset` [mm] is the x of the film tile's left edge.

    Raises
    ------
    InputError
        when the mesh of another film, or that of the prisms, cannot be traced.
    """
    if stack.has_slot != (mesh is not None):
        what = "its film needs a mesh" if stack.has_slot else "has no film: expected no mesh"
        raise InputError(f"stack {stack.name}: {what}")
    elements: list[Element] = [stack.source.lower(stack.tables)]
    for i, layer in enumerate(stack.layers):
        if layer in stack.own:
            elements.append(_own_layer(stack, layer, mesh, offset))
        elif stack.kind_of(layer) == "plate":
            bonded = i + 1 < len(stack.layers) and stack.layers[i + 1] == "bonded_film"
            elements.append(_plate(stack, layer == "diffusing_plate", bonded))
        elif stack.kind_of(layer) == "sheet":
            sigma, transmission = stack[f"{layer}_sigma"], stack["sheet_transmission"]
            elements.append(Sheet(sigma, stack["sheet_index"], transmission, _words(layer)))
        else:
            under = elements[-1]
            is_bonded = layer == "bonded_film"
            below = under.index if is_bonded and isinstance(under, Slab) else 1.0
            assert mesh is not None  # a stack with a slot has one
            if isinstance(mesh, Library):
                elements.append(_library(stack, mesh, below, offset))
            else:
                elements += lower_film(stack, mesh, _resin(stack, mesh), below, offset)
    return elements


def _words(layer: str) -> str:
    return layer.replace("_", " ")


def _plate(stack: Stack, diffusing: bool, bonded: bool) -> Slab:
    volume: dict[str, Any] = {}
    if diffusing:
        particles = build_particles(stack.quantity, "plate")
        volume = {
            "scattering": stack["plate_scattering_per_mm"],
            "absorption": stack["plate_absorption_per_mm"],
            "asymmetry": stack["plate_asymmetry"],
            "phase": None if particles is None else particles.phase(),
        }
    return Slab(stack["plate_index"], stack["plate_thickness_mm"], bonded=bonded, **volume)


def _resin(stack: Stack, mesh: FilmMesh | None) -> Resin | None:
    if not stack.resin_scatters:
        return None
    if stack.prism is None:
        raise InputError(
            f"{stack.name}: resin that scatters: "
            "expected the mesh of the film without resin (--prism)"
        )
    prism = read_film_mesh(stack.prism)
    if build_chain(prism) is None:
        raise InputError(f"{stack.prism}: prisms under the resin: expected prisms drawn along y")
    if mesh is None or prism.size[0] != mesh.size[0]:
        raise InputError(
            f"{stack.prism}: prisms under the resin: {prism.size[0]:g} mm wide: expected as wide "
            f"as the film, {mesh.size[0] if mesh else 0:g} mm"
        )
    particles = build_particles(stack.quantity, "resin")
    phase = None if particles is None else particles.phase()
    return Resin(prism, stack["resin_scattering_per_mm"], stack["resin_asymmetry"], phase)


def _own_layer(stack: Stack, name: str, mesh: FilmMesh | Library | None, offset: float) -> Element:
    """Return the element of a layer with values of its own."""
    layer = stack.own[name]
    if layer.kind == "bsdf":
        table = stack.tables[name]
        return BsdfSheet(table.table, table.blend, _words(name))

    def value(key: str) -> float:
        return stack[f"{name}.{key}"]

    words = _words(name)
    if layer.kind == "plate":
        volume = (value("scattering_per_mm"), value("absorption_per_mm"), value("asymmetry"))
        bonded = stack.layers.index(name) + 1 < len(stack.layers) and (
            stack.layers[stack.layers.index(name) + 1] == "bonded_film"
        )
        return Slab(value("index"), value("thickness_mm"), *volume, bonded, words)
    if layer.kind == "sheet":
        return Sheet(value("sigma"), value("index"), value("transmission"), words)
    resin = None
    if layer.kind == "bef":
        mesh, offset = (
            _bef_mesh(*(value(f"{key}_um") * um for key in ("pitch", "depth", "base"))),
            0.0,
        )
    elif layer.file is not None:
        mesh, offset = read_film(Path(layer.file)), 0.0
    elif mesh is not None:
        resin = None if isinstance(mesh, Library) else _resin(stack, mesh)
    assert mesh is not None  # a stack with a slot has one
    rotation, absorption = value("rotation_deg") * deg, value("absorption_per_mm")
    if isinstance(mesh, Library):
        _refuse_library(words, layer.flipped or absorption > 0 or resin is not None)
        return LibraryFilm(mesh, value("index"), 1.0, offset, words, rotation)
    return Film(
        mesh, value("index"), 1.0, offset, None, words, rotation=rotation,
        flipped=layer.flipped, resin=resin, absorption=absorption,
    )  # fmt: skip


def printed_films(elements: Iterable[Element]) -> set[str]:
    """Return the names of the films that are libraries of pieces, as a print under LEDs is."""
    return {one.name for one in elements if isinstance(one, LibraryFilm)}


def _library(stack: Stack, library: Library, below: float, offset: float) -> LibraryFilm:
    """Return the element of the job's film as a library of pieces."""
    names = [f"{layer}_thickness_um" for layer in FILM_LAYERS]
    absorbs = "film_absorption_per_mm" in stack.quantity and stack["film_absorption_per_mm"] > 0
    layered = any(name in stack.quantity for name in names)
    _refuse_library(stack.name, absorbs or layered or stack.resin_scatters)
    return LibraryFilm(library, stack["film_index"], below, offset)


def _refuse_library(name: str, wrong: bool) -> None:
    if wrong:
        raise InputError(
            f"{name}: a film of instances: expected upright, clear, and of one material"
        )


def read_film(path: Path) -> FilmMesh | Library:
    """Return a film's mesh from disk, or its library of pieces from a 3MF of instances.

    Raises
    ------
    InputError
        when it cannot be read or traced.
    """
    return read_library(path) if is_library_file(path) else read_film_mesh(path)


def _bef_mesh(pitch: float, depth: float, base: float) -> FilmMesh:
    """Return one groove of a plain prism film [mm], from tip to tip."""
    x = np.tile([0.0, pitch / 2, pitch], 2)
    z = np.tile([base + depth, base, base + depth], 2)
    vertex = np.stack([x, np.repeat([0.0, pitch], 3), z], axis=1)
    top = np.array([[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]])
    return FilmMesh(vertex, top, (pitch, pitch, base + depth))
