"""The job's film with layers of its own: base and primer under the prisms, each of its index.

The film's mesh is one solid. What of it lies under the prisms becomes bonded slabs, with Fresnel
reflection where the index changes and absorption along the path; the prisms keep what is left.
"""

from dataclasses import replace

from mpfcad.backlight.quantity import FILM_LAYERS
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError
from mpfcad.optics.element import Element, Film, Slab
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.units import um

#: What must be left of the prisms' material under the deepest valley [mm].
_LEAST = 1e-6


def lower_film(
    stack: Stack, mesh: FilmMesh, resin: Resin | None, index_below: float, offset: float
) -> list[Element]:
    """Return the film's elements from below: its layers as bonded slabs, then the prisms.

    `index_below` is that of the plate on which the film is bonded, or 1; `offset` [mm] the x of the
    tile's left edge. Without layers it is the film alone.

    Raises
    ------
    InputError
        when the layers are as thick as the film under its valleys, or it has no flat underside.
    """
    elements: list[Element] = []
    below, thickness = index_below, 0.0
    for layer in FILM_LAYERS:
        if f"{layer}_thickness_um" not in stack.quantity:
            continue
        height, index = stack[f"{layer}_thickness_um"] * um, stack[f"{layer}_index"]
        absorption = _optional(stack, f"{layer}_absorption_per_mm")
        words = layer.replace("_", " ")
        elements.append(
            Slab(index, height, 0.0, absorption, bonded=True, name=words, index_below=below)
        )
        below, thickness = index, thickness + height
    if thickness:
        mesh = _without(stack.name, mesh, thickness)
        resin = resin and replace(resin, prism=_without(stack.name, resin.prism, thickness))
    absorption = _optional(stack, "film_absorption_per_mm")
    film = Film(mesh, stack["film_index"], below, offset, resin=resin, absorption=absorption)
    return [*elements, film]


def _optional(stack: Stack, key: str) -> float:
    return stack[key] if key in stack.quantity else 0.0


def _without(name: str, mesh: FilmMesh, thickness: float) -> FilmMesh:
    """Return a film without the layers of this thickness [mm] at its underside."""
    if not mesh.underside:
        raise InputError(f"{name}: film layers: the film has no flat underside: expected one")
    lowest = float(mesh.vertex[mesh.used, 2].min())
    if not thickness <= lowest - _LEAST:
        raise InputError(
            f"{name}: film layers: {thickness / um:g} µm thick together: expected less than the "
            f"{lowest / um:g} µm under the film's valleys"
        )
    vertex = mesh.vertex - (0.0, 0.0, thickness)
    width, length, high = mesh.size
    return FilmMesh(vertex, mesh.top, (width, length, high - thickness), note=mesh.note)
