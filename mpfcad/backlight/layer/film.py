"""The job's film as its materials: base and primer under the prisms, resin in their grooves.

The film's mesh is one solid. What of it lies under the prisms becomes bonded slabs, with Fresnel
reflection where the index changes and absorption along the path; the prisms keep what is left. A
resin that scatters or is of another material is told from the prisms by their own mesh.
"""

import math
from dataclasses import replace

from mpfcad.backlight.dispersion import DEFAULT_WAVELENGTH_NM
from mpfcad.backlight.particle import build_particles
from mpfcad.backlight.quantity import FILM_LAYERS
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.optics.element import Element, Film, LibraryFilm, Slab
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.library.piece import Library
from mpfcad.optics.library.top import CellTops
from mpfcad.optics.search.chain import build_chain
from mpfcad.optics.solid.mesh import FilmMesh, read_film_mesh
from mpfcad.units import deg, um

#: What must be left of the prisms' material under the deepest valley [mm].
_LEAST = 1e-6


def lower_film(
    stack: Stack, mesh: FilmMesh | Library | CellTops, index_below: float, offset: float
) -> list[Element]:
    """Return the film's elements from below: its layers as bonded slabs, then the prisms.

    `index_below` is that of the plate on which the film is bonded, or 1; `offset` [mm] the x of the
    tile's left edge. Without layers it is the film alone.

    Raises
    ------
    InputError
        when the layers are as thick as the film under its valleys, it has no flat underside, or
        the mesh of the prisms is missing or none of this film.
    """
    elements: list[Element] = []
    below, thickness = index_below, 0.0
    for layer in FILM_LAYERS:
        if f"{layer}_thickness_um" not in stack.quantity:
            continue
        height, index = stack[f"{layer}_thickness_um"] * um, stack[f"{layer}_index"]
        absorption = stack.get(f"{layer}_absorption_per_mm")
        words = layer.replace("_", " ")
        delay, axis = delay_of(stack, height) if layer == "film_base" else (0.0, 0.0)
        elements.append(
            Slab(
                index, height, 0.0, absorption, bonded=True, name=words, index_below=below,
                delay=delay, axis=axis,
            )
        )  # fmt: skip
        below, thickness = index, thickness + height
    if isinstance(mesh, Library | CellTops):
        return [*elements, _library(stack, mesh, thickness, below, offset)]
    resin = _resin(stack, mesh)
    if thickness:
        mesh = _without(stack.name, mesh, thickness)
        resin = resin and replace(resin, prism=_without(stack.name, resin.prism, thickness))
    name, rotation, flipped = _lie(stack)
    film = Film(
        mesh, stack.of_film("index"), below, offset, None, name, rotation=rotation,
        flipped=flipped, resin=resin, absorption=stack.of_film("absorption_per_mm"),
        roughness=stack.of_film("roughness"),
    )  # fmt: skip
    return [*elements, film]


def delay_of(stack: Stack, height: float) -> tuple[float, float]:
    """Return by how much the base delays light along its axis [rad/mm], and the axis [rad].

    `height` [mm]: of the base, over which its retardation is stated.
    """
    wavelength = stack.get("light_wavelength_nm", DEFAULT_WAVELENGTH_NM)
    waves = stack.get("film_base_retardation_nm") / wavelength
    axis = stack.get("film_base_axis_deg") * deg
    return 2 * math.pi * waves / height, axis


def _lie(stack: Stack) -> tuple[str, float, bool]:
    """Return the film's name in words, its angle [rad] and whether it lies upside down."""
    slot = stack.slot
    own = stack.own.get(slot) if slot else None
    if slot is None or own is None:
        return "film", 0.0, False
    return slot.replace("_", " "), stack[f"{slot}.rotation_deg"] * deg, own.flipped


def _library(
    stack: Stack, library: Library | CellTops, thickness: float, below: float, offset: float
) -> LibraryFilm:
    """Return the film as a library of pieces, without the layers of this thickness [mm] under it.

    Raises
    ------
    InputError
        when it is upside down, absorbs, or its resin is of another material than its prisms.
    """
    name, rotation, flipped = _lie(stack)
    if flipped or stack.of_film("absorption_per_mm") > 0 or stack.needs_prism:
        raise InputError(
            f"{stack.name}: a film of instances: expected upright, clear and smooth, with "
            "resin as its prisms"
        )
    if thickness:
        _refuse_thick(stack.name, thickness, library.low)
        library = library.lowered(thickness)
    return LibraryFilm(library, stack.of_film("index"), below, offset, name, rotation)


def _seen_prisms(stack: Stack) -> str:
    """Return which values let light tell the prisms from their resin."""
    keys = ["resin_scattering_per_mm"] if stack.resin_scatters else []
    keys += ["resin_index, resin_absorption_per_mm"] if stack.resin_differs else []
    return ", ".join(keys or ["film_roughness"])


def _resin(stack: Stack, mesh: FilmMesh) -> Resin | None:
    """Return what lies in the grooves; None where light takes it for the prisms' own material."""
    if not stack.needs_prism:
        return None
    if stack.prism is None:
        raise InputError(
            f"{stack.name}: {_seen_prisms(stack)}: light sees where the resin ends: expected the "
            "film without its resin, too: a job, an export, or mpfcad trace MESH --prism FILE"
        )
    prism = read_film_mesh(stack.prism)
    if build_chain(prism) is None:
        raise InputError(f"{stack.prism}: prisms under the resin: expected prisms drawn along y")
    if prism.size[0] != mesh.size[0]:
        raise InputError(
            f"{stack.prism}: prisms under the resin: {prism.size[0]:g} mm wide: expected as wide "
            f"as the film, {mesh.size[0]:g} mm"
        )
    particles = build_particles(stack.quantity, "resin")
    own = {key: stack[f"resin_{key}"] if f"resin_{key}" in stack.quantity else None
           for key in ("index", "absorption_per_mm")}  # fmt: skip
    return Resin(
        prism, stack.get("resin_scattering_per_mm"), stack.get("resin_asymmetry"),
        None if particles is None else particles.phase(), own["index"], own["absorption_per_mm"],
    )  # fmt: skip


def _refuse_thick(name: str, thickness: float, lowest: float) -> None:
    if not thickness <= lowest - _LEAST:
        raise InputError(
            f"{name}: film layers: {thickness / um:.9g} µm thick together: expected at most "
            f"{max(lowest - _LEAST, 0.0) / um:.9g} µm, to leave some of the prisms under their "
            "valleys"
        )


def _without(name: str, mesh: FilmMesh, thickness: float) -> FilmMesh:
    """Return a film without the layers of this thickness [mm] at its underside."""
    if not mesh.underside:
        raise InputError(f"{name}: film layers: the film has no flat underside: expected one")
    lowest = float(mesh.vertex[mesh.used, 2].min())
    _refuse_thick(name, thickness, lowest)
    vertex = mesh.vertex - (0.0, 0.0, thickness)
    width, length, high = mesh.size
    return FilmMesh(vertex, mesh.top, (width, length, high - thickness), note=mesh.note)
