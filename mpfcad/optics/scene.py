"""A scene: horizontal elements from the bottom up, lowered to flat arrays for the kernels.

Elements touch: a ray that leaves one upward enters the next from below. Between elements is air,
but for a slab with a film bonded on it, where the slab's own medium reaches up to the film.
Everything repeats sideways without end: lamps with the lamp pitch, a film with the size of its
mesh.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics.bsdf import BsdfArrays, build_bsdf
from mpfcad.optics.bsdf_table import BsdfTable
from mpfcad.optics.mesh import FilmMesh
from mpfcad.optics.tile import NO_TILE, Tile, build_tile

CAVITY, SLAB, SHEET, FILM, BSDF = range(5)
_PARAMETERS = 10
_NOT_NUMBERS = ("name", "table", "brdf", "blend")


@dataclass(frozen=True)
class Cavity:
    """Lamps in a row over a reflector, below everything else; lengths in mm.

    Attributes
    ----------
    height
        from the reflector (z = 0) to the next element
    lamp_pitch, lamp_position
        spacing of the lamps along x, and x of one of them
    lamp_height, lamp_radius
        axis above the reflector; radius of the tube
    lamp_luminance, lamp_reflectance
        of the tube's surface [cd/m²]; diffuse reflectance 0…1
    reflectance, specular_fraction
        of the reflector 0…1; the mirror-like part of it 0…1, the rest is Lambertian
    brdf, blend
        a table that takes the place of both, seen from above; its interpolation (`BsdfSheet`)
    """

    height: float
    lamp_pitch: float
    lamp_position: float
    lamp_height: float
    lamp_radius: float
    lamp_luminance: float
    lamp_reflectance: float
    reflectance: float
    specular_fraction: float
    name: str = "cavity"
    brdf: BsdfTable | None = None
    blend: float = 1.0


@dataclass(frozen=True)
class Slab:
    """A plane-parallel plate, clear or with volume scattering (Henyey and Greenstein, 1941).

    Attributes
    ----------
    index
        refractive index
    thickness
        [mm]
    scattering, absorption
        coefficients [1/mm]
    asymmetry
        g, mean cosine of one scattering
    bonded
        whether the film above is bonded on it, without air between
    """

    index: float
    thickness: float
    scattering: float = 0.0
    absorption: float = 0.0
    asymmetry: float = 0.0
    bonded: bool = False
    name: str = "plate"


@dataclass(frozen=True)
class Sheet:
    """A thin scatterer: moves the direction cosines (kx, ky) by a Gaussian.

    Attributes
    ----------
    sigma
        standard deviation of the move in each of kx, ky
    index
        refractive index of the two surfaces that accept a direction or reflect it
    transmission
        share of the light that survives a passage
    """

    sigma: float
    index: float
    transmission: float
    name: str = "sheet"


@dataclass(frozen=True, eq=False)
class Film:
    """A film tile read from a mesh.

    Attributes
    ----------
    mesh
        the tile
    index
        refractive index
    index_below
        that of the medium under it: 1, or the slab's on which it is bonded
    offset
        x [mm] in the scene of the tile's left edge
    accelerator
        None to choose from the mesh, or `chain` or `bvh`
    """

    mesh: FilmMesh
    index: float
    index_below: float = 1.0
    offset: float = 0.0
    accelerator: str | None = None
    name: str = "film"


@dataclass(frozen=True, eq=False)
class BsdfSheet:
    """A thin element that scatters by a table.

    Attributes
    ----------
    table
        both ways, both sides
    blend
        0: a table of steps; 1: linear between the bins' middles
    """

    table: BsdfTable
    blend: float = 1.0
    name: str = "bsdf"


Element = Cavity | Slab | Sheet | Film | BsdfSheet


class Scene(NamedTuple):
    """What the kernels read.

    Attributes
    ----------
    kind
        (e,) int64, element kinds from the bottom up
    parameter
        (e, 10) float64, the fields of each element in the order of its class
    tile
        the films' tile; scenes hold at most one film mesh
    bsdf
        the tables of all BSDF elements
    below, above
        radiance [cd/m²] of black surroundings' place under the first and over the last element
    """

    kind: NDArray[np.int64]
    parameter: NDArray[np.float64]
    tile: Tile
    bsdf: BsdfArrays
    below: float
    above: float


def build_scene(elements: list[Element], *, below: float = 0.0, above: float = 0.0) -> Scene:
    """Return the scene of elements given from the bottom up, between radiances `below` and `above`.

    Raises
    ------
    TraceError
        when a cavity is not the lowest element, a bonded slab has no film on it, there is more than
        one film, or the asked accelerator does not fit the mesh.
    """
    films = [e for e in elements if isinstance(e, Film)]
    if len(films) > 1:
        raise TraceError(f"{len(films)} films in one stack: one is supported")
    tables: list[BsdfTable] = []
    blends: list[float] = []
    kind = np.empty(len(elements), np.int64)
    parameter = np.zeros((len(elements), _PARAMETERS))
    for i, element in enumerate(elements):
        if isinstance(element, Cavity) and i > 0:
            raise TraceError("the cavity must be the lowest element")
        upper = elements[i + 1] if i + 1 < len(elements) else None
        if isinstance(element, Slab) and element.bonded and not isinstance(upper, Film):
            raise TraceError("a bonded slab needs a film on it")
        kind[i] = (Cavity, Slab, Sheet, Film, BsdfSheet).index(type(element))
        values = _parameters(element)
        table = getattr(element, "brdf" if isinstance(element, Cavity) else "table", None)
        if table is not None:
            values.append(float(len(tables)))
            tables.append(table)
            blends.append(element.blend)
        elif isinstance(element, Cavity):
            values.append(-1.0)
        parameter[i, : len(values)] = values
    tile = build_tile(films[0].mesh, films[0].accelerator) if films else NO_TILE
    bsdf = build_bsdf(tables, blends)
    return Scene(kind, parameter, tile, bsdf, float(below), float(above))


def _parameters(element: Element) -> list[float]:
    """Return the numbers of an element in the order in which the kernels unpack them."""
    if isinstance(element, Film):
        return [element.index, element.index_below, element.offset]
    return [float(v) for k, v in vars(element).items() if k not in _NOT_NUMBERS]
