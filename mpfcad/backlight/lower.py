"""A stack lowered to the elements that are traced."""

import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from mpfcad.backlight.array_mesh import made_mesh
from mpfcad.backlight.layer.film import lower_film
from mpfcad.backlight.layer.plane import depolarisation_of, lower_plane
from mpfcad.backlight.layer.stated import CONVERTER, POLARISING
from mpfcad.backlight.particle import build_particles
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.optics.element import BsdfSheet, Element, Film, LibraryFilm, Sheet, Slab
from mpfcad.optics.library.file import is_library_file, read_library
from mpfcad.optics.library.piece import Library
from mpfcad.optics.library.top import CellTops
from mpfcad.optics.solid.mesh import FilmMesh, read_film_mesh
from mpfcad.optics.spectral.converter import Converter
from mpfcad.units import deg, um

#: What is read of a film's file.
Mesh = FilmMesh | Library | CellTops


def read_film(path: Path) -> Mesh:
    """Return a film's mesh from disk, or its library of pieces from a 3MF of instances.

    Raises
    ------
    InputError
        when it cannot be read or traced.
    """
    return read_library(path) if is_library_file(path) else read_film_mesh(path)


def lower_stack(
    stack: Stack,
    mesh: Mesh | None,
    offset: float = 0.0,
    read: Callable[[Path], Mesh] = read_film,
) -> list[Element]:
    """Return the traced elements from the bottom up; x = 0 is a lamp's axis, y = 0 the middle.

    `offset` [mm] is the x of the film tile's left edge; `read` reads the other films' files.

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
        if stack.is_slot(layer):
            under = elements[-1]
            is_bonded = layer == "bonded_film"
            below = under.index if is_bonded and isinstance(under, Slab) else 1.0
            assert mesh is not None  # a stack with a slot has one
            elements += lower_film(stack, mesh, below, offset)
        elif layer in stack.own:
            elements.append(_own_layer(stack, layer, read))
        elif stack.kind_of(layer) == "plate":
            bonded = i + 1 < len(stack.layers) and stack.layers[i + 1] == "bonded_film"
            elements.append(_plate(stack, layer == "diffusing_plate", bonded))
        else:
            sigma, transmission = stack[f"{layer}_sigma"], stack["sheet_transmission"]
            left = depolarisation_of(stack, layer)
            elements.append(
                Sheet(sigma, stack["sheet_index"], transmission, _words(layer), depolarisation=left)
            )
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


def _own_layer(stack: Stack, name: str, read: Callable[[Path], Mesh]) -> Element:
    """Return the element of a layer with values of its own that is not the job's film."""
    layer = stack.own[name]
    if layer.kind == "bsdf":
        table = stack.tables[name]
        return BsdfSheet(table.table, table.blend, _words(name))

    def value(key: str) -> float:
        return stack[f"{name}.{key}"]

    words = _words(name)
    if layer.kind == CONVERTER:
        return _converter(stack, name, words)
    if layer.kind in POLARISING:
        return lower_plane(stack, name, words)
    if layer.kind == "plate":
        volume = (value("scattering_per_mm"), value("absorption_per_mm"), value("asymmetry"))
        bonded = stack.layers.index(name) + 1 < len(stack.layers) and (
            stack.layers[stack.layers.index(name) + 1] == "bonded_film"
        )
        return Slab(value("index"), value("thickness_mm"), *volume, bonded, words)
    if layer.kind == "sheet":
        axis, wide, share = (
            stack.get(f"{name}.{key}") for key in ("axis_deg", "wide_sigma", "wide_share")
        )
        across = value("sigma_across") if f"{name}.sigma_across" in stack.quantity else None
        left = depolarisation_of(stack, name)
        return Sheet(
            value("sigma"), value("index"), value("transmission"), words, across, axis * deg,
            wide, share, left,
        )  # fmt: skip
    mesh: Mesh
    if layer.kind != "film":
        mesh = made_mesh(layer.kind, words, value)
    else:
        assert layer.file is not None  # else it is the job's film
        mesh = read(Path(layer.file))
    rotation, absorption = value("rotation_deg") * deg, value("absorption_per_mm")
    roughness = stack.get(f"{name}.roughness")
    if isinstance(mesh, Library | CellTops):
        if layer.flipped or absorption > 0 or roughness > 0:
            raise InputError(f"{words}: a film of instances: expected upright, clear and smooth")
        return LibraryFilm(mesh, value("index"), 1.0, 0.0, words, rotation)
    return Film(
        mesh, value("index"), name=words, rotation=rotation, flipped=layer.flipped,
        absorption=absorption, roughness=roughness,
    )  # fmt: skip


def _converter(stack: Stack, name: str, words: str) -> Converter:
    """Return a sheet that converts light, or a film with faces where it says how it scatters."""
    own = depth_of(stack, name), stack[f"{name}.index"], stack[f"{name}.yield"], words
    if f"{name}.scattering_per_mm" not in stack.quantity:
        return Converter(*own)
    volume = (stack.get(f"{name}.{key}") for key in ("scattering_per_mm", "asymmetry"))
    return Converter(*own, stack[f"{name}.thickness_um"] * um, *volume)


def depth_of(stack: Stack, name: str) -> float:
    """Return the optical depth of a converting layer along the normal."""
    if f"{name}.absorptance" in stack.quantity:
        return -math.log1p(-stack[f"{name}.absorptance"])
    return stack[f"{name}.absorption_per_mm"] * stack[f"{name}.thickness_um"] * um


def printed_films(elements: Iterable[Element]) -> set[str]:
    """Return the names of the films that are libraries of pieces, as a print under LEDs is."""
    return {one.name for one in elements if isinstance(one, LibraryFilm)}
