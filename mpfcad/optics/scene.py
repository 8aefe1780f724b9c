"""A scene: horizontal elements from the bottom up, lowered to flat arrays for the kernels.

Elements touch: a ray that leaves one upward enters the next from below. Between elements is air,
but for a slab with a film bonded on it, where the slab's own medium reaches up to the film.
Everything repeats sideways without end: lamps with the lamp pitch, a film with the size of its
mesh.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import TraceError
from mpfcad.optics.bsdf import BsdfArrays, build_bsdf
from mpfcad.optics.bsdf_table import BsdfTable
from mpfcad.optics.mesh import FilmMesh
from mpfcad.optics.panel import NO_WALL, Panel
from mpfcad.optics.phase import phase_table
from mpfcad.optics.resin import Resin
from mpfcad.optics.tile import ACCELERATORS, build_tile
from mpfcad.optics.tile_table import TileTable, build_tile_table

CAVITY, SLAB, SHEET, FILM, BSDF = range(5)
_PARAMETERS = 12
#: Largest length [mm] along y over which a meter averages on a finite panel.
_MOST_ALONG = 2.0
#: Where a film has the number of its tile, and the scattering coefficient of its resin.
TILE, RESIN = 6, 7


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
    panel
        its edges and its own row of lamps; None: lamps of one kind with their pitch, without end
    brdf, blend
        a table in the place of the reflector's two values, and its interpolation (`BsdfSheet`)
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
    panel: Panel | None = None
    brdf: BsdfTable | None = None
    blend: float = 1.0


@dataclass(frozen=True, eq=False)
class Slab:
    """A plane-parallel plate, clear or with volume scattering.

    Attributes
    ----------
    index
        refractive index
    thickness
        [mm]
    scattering, absorption
        coefficients [1/mm]
    asymmetry
        g, mean cosine of one scattering (Henyey and Greenstein, 1941)
    bonded
        whether the film above is bonded on it, without air between
    phase
        (STEPS+1,) float64, cosines at equal steps of probability in place of `asymmetry`
    """

    index: float
    thickness: float
    scattering: float = 0.0
    absorption: float = 0.0
    asymmetry: float = 0.0
    bonded: bool = False
    name: str = "plate"
    phase: NDArray[np.float64] | None = None


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
        x [mm] in the scene of the tile's left edge, before the film is turned by `rotation`
    accelerator
        None to choose from the mesh, or `chain` or `bvh`
    rotation
        angle [rad] by which the film is turned about z through the scene's origin: π/2 is crossed
    flipped
        whether it lies upside down, turned over about the middle line of its tile along y
    resin
        a fill that scatters, if it does
    """

    mesh: FilmMesh
    index: float
    index_below: float = 1.0
    offset: float = 0.0
    accelerator: str | None = None
    name: str = "film"
    rotation: float = 0.0
    flipped: bool = False
    resin: Resin | None = None


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
_CLASSES = (Cavity, Slab, Sheet, Film, BsdfSheet)


class Scene(NamedTuple):
    """What the kernels read.

    Attributes
    ----------
    kind
        (e,) int64, element kinds from the bottom up
    parameter
        (e, 12) float64, the fields of each element in the order of its class; a plate's end with
        the row of its phase function; a film's: index, index below, offset, cosine and sine of its
        rotation, flipped, number of its tile, of its resin scattering, asymmetry, row of its phase
        function and tile of the prisms under it; a cavity's end with the row of its BRDF or -1; a
        BSDF sheet's is the row of its table
    tiles
        the tiles of the films and of the prisms under scattering resin
    phase
        (r, STEPS+1) float64, tabulated phase functions
    bsdf
        the tables of all BSDF elements
    wall, lamp
        (7,) and (l, 3) float64, a finite panel's (`Panel.arrays`); without end: no lamps
    length
        [mm] along y over which the stack repeats, and a meter averages unless told otherwise
    below, above
        radiance [cd/m²] of black surroundings' place under the first and over the last element
    """

    kind: NDArray[np.int64]
    parameter: NDArray[np.float64]
    tiles: TileTable
    phase: NDArray[np.float64]
    bsdf: BsdfArrays
    wall: NDArray[np.float64]
    lamp: NDArray[np.float64]
    length: float
    below: float
    above: float

    @property
    def accelerators(self) -> str:
        """How the films are traced, each way once: `chain`, `chain, bvh` and so on."""
        films = self.parameter[self.kind == FILM, TILE].astype(int)
        return ", ".join(dict.fromkeys(ACCELERATORS[a] for a in self.tiles.accelerator[films]))


def build_scene(elements: list[Element], *, below: float = 0.0, above: float = 0.0) -> Scene:
    """Return the scene of elements given from the bottom up, between radiances `below` and `above`.

    Raises
    ------
    TraceError
        when a cavity is not the lowest element, a bonded slab has no film with its underside on it,
        or the asked accelerator does not fit the mesh.
    """
    _check_order(elements)
    tiles, phases, bsdfs = _Rows(), _Rows(), _Rows()
    kind = np.array([_CLASSES.index(type(element)) for element in elements], np.int64)
    parameter = np.zeros((len(elements), _PARAMETERS))
    for i, element in enumerate(elements):
        values = _parameters(element, tiles, phases, bsdfs)
        parameter[i, : len(values)] = values
    panel = elements[0].panel if elements and isinstance(elements[0], Cavity) else None
    wall, lamp = panel.arrays() if panel else (NO_WALL, np.zeros((0, 3)))
    length = max((_extent_along(e) for e in elements if isinstance(e, Film)), default=1.0)
    if panel:
        length = min(length, _MOST_ALONG)
    table = build_tile_table([build_tile(mesh, way) for mesh, way in tiles.entries])
    phase = phase_table(phases.entries)
    bsdf = build_bsdf([t for t, _ in bsdfs.entries], [blend for _, blend in bsdfs.entries])
    sky = float(below), float(above)
    return Scene(kind, parameter, table, phase, bsdf, wall, lamp, length, *sky)


class _Rows:
    """What elements share, each once: `number` gives the row of an entry."""

    def __init__(self) -> None:
        self.entries: list = []
        self._row: dict[object, int] = {}

    def number(self, key: object, entry: object) -> float:
        if key not in self._row:
            self._row[key] = len(self.entries)
            self.entries.append(entry)
        return float(self._row[key])


def _check_order(elements: list[Element]) -> None:
    for i, element in enumerate(elements):
        if isinstance(element, Cavity) and i > 0:
            raise TraceError("the cavity must be the lowest element")
        upper = elements[i + 1] if i + 1 < len(elements) else None
        if isinstance(element, Slab) and element.bonded:
            if not isinstance(upper, Film):
                raise TraceError("a bonded slab needs a film on it")
            if upper.flipped:
                raise TraceError("a film upside down cannot be bonded on a slab")


def _parameters(element: Element, tiles: _Rows, phases: _Rows, bsdfs: _Rows) -> list[float]:
    """Return the numbers of an element in the order in which the kernels unpack them."""
    if isinstance(element, Film):
        cosine, sine = _quadrant(element.rotation)
        mesh, way = element.mesh, element.accelerator
        values = [element.index, element.index_below, element.offset, cosine, sine]
        values += [float(element.flipped), tiles.number((id(mesh), way), (mesh, way))]
        resin = element.resin
        if resin is not None:
            row = _phase_row(resin.phase, phases)
            prism = tiles.number((id(resin.prism), "chain"), (resin.prism, "chain"))
            values += [resin.scattering, resin.asymmetry, row, prism]
        return values
    if isinstance(element, BsdfSheet):
        return [_bsdf_row(element.table, element.blend, bsdfs)]
    skipped = ("name", "panel", "phase", "brdf", "blend")
    values = [float(v) for k, v in vars(element).items() if k not in skipped]
    if isinstance(element, Slab):
        values.append(_phase_row(element.phase, phases))
    if isinstance(element, Cavity):
        values.append(_bsdf_row(element.brdf, element.blend, bsdfs))
    return values


def _bsdf_row(table: BsdfTable | None, blend: float, bsdfs: _Rows) -> float:
    return -1.0 if table is None else bsdfs.number((id(table), blend), (table, blend))


def _phase_row(phase: NDArray[np.float64] | None, phases: _Rows) -> float:
    return -1.0 if phase is None else phases.number(id(phase), phase)


def _quadrant(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle [rad], exact at right angles."""
    cosine, sine = math.cos(angle), math.sin(angle)
    if abs(cosine) < 1e-15 or abs(sine) < 1e-15:
        return float(round(cosine)), float(round(sine))
    return cosine, sine


def _extent_along(film: Film) -> float:
    """Return over which length [mm] along y a film repeats; turned askew, its longer side."""
    _, sine = _quadrant(film.rotation)
    width, length, _ = film.mesh.size
    return length if sine == 0 else width if abs(sine) == 1 else max(width, length)
