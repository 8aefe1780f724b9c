"""The elements that a scene is built of, and their kinds."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base.mirror import Mirrored
from mpfcad.optics.bsdf.table import BsdfTable
from mpfcad.optics.cavity.board import Board
from mpfcad.optics.cavity.finite import Panel
from mpfcad.optics.film.resin import Resin
from mpfcad.optics.library.piece import Library
from mpfcad.optics.library.top import CellTops
from mpfcad.optics.solid.mesh import FilmMesh
from mpfcad.optics.spectral.converter import Converter
from mpfcad.optics.stokes.mueller import MuellerLayer
from mpfcad.optics.stokes.plane import PlaneLayer
from mpfcad.sound import refuse_unsound

#: Kinds as the kernels know them.
CAVITY, SLAB, SHEET, FILM, BSDF, LIBRARY_FILM, CELL_FILM, PLANE, MUELLER, CONVERTER = range(10)
#: The column of a BSDF sheet in `Scene.parameter`: the row of its table.
TABLE = 0
#: Tiles of a film's mesh that a cell must hold for the film to be called even.
EVEN = 8


@dataclass(frozen=True)
class Cavity(Mirrored):
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

    def __post_init__(self) -> None:
        for name in ("height", "lamp_pitch", "lamp_radius"):
            refuse_unsound(f"{self.name}.{name}", getattr(self, name), 0.0, above=True)
        for name in ("lamp_reflectance", "reflectance", "specular_fraction", "blend"):
            refuse_unsound(f"{self.name}.{name}", getattr(self, name), 0.0, 1.0)
        refuse_unsound(f"{self.name}.lamp_luminance", self.lamp_luminance, 0.0)


@dataclass(frozen=True, eq=False)
class Slab(Mirrored):
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
        whether the film or slab above is bonded on it, without air between
    phase
        (STEPS+1,) float64, cosines at equal steps of probability in place of `asymmetry`
    index_below
        that of the medium under it: 1, or the slab's on which it is bonded
    delay
        of a uniaxial plate, by how much light polarised along its axis falls behind: phase a path
        across the axis [rad/mm]
    axis
        angle [rad] of that axis from y, anticlockwise seen from above
    """

    index: float
    thickness: float
    scattering: float = 0.0
    absorption: float = 0.0
    asymmetry: float = 0.0
    bonded: bool = False
    name: str = "plate"
    phase: NDArray[np.float64] | None = None
    index_below: float = 1.0
    delay: float = 0.0
    axis: float = 0.0

    def is_mirrored(self, period: float) -> bool:
        """Tell whether it has no axis, or one along y or across."""
        return self.delay == 0.0 or abs(math.sin(2.0 * self.axis)) < 1e-12

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.axis", self.axis)
        refuse_unsound(f"{self.name}.index", self.index, 1.0)
        refuse_unsound(f"{self.name}.index_below", self.index_below, 1.0)
        for name in ("thickness", "scattering", "absorption", "delay"):
            refuse_unsound(f"{self.name}.{name}", getattr(self, name), 0.0)
        refuse_unsound(f"{self.name}.asymmetry", self.asymmetry, -1.0, 1.0)


@dataclass(frozen=True)
class Sheet(Mirrored):
    """A thin scatterer: moves the direction cosines (kx, ky) by a Gaussian, or by one of two.

    Attributes
    ----------
    sigma
        standard deviation of the move along the axis, and across it unless `sigma_across` is given
    index
        refractive index of the two surfaces that accept a direction or reflect it
    transmission
        share of the light that survives a passage
    sigma_across
        standard deviation of the move across the axis
    axis
        angle [rad] of the axis from x, anticlockwise as seen from above
    wide_sigma, wide_share
        of a second lobe, in each of kx, ky; the share 0…1 of all moves that it has
    depolarisation
        share of the polarisation that a passage or reflection takes, where light has one
    """

    sigma: float
    index: float
    transmission: float
    name: str = "sheet"
    sigma_across: float | None = None
    axis: float = 0.0
    wide_sigma: float = 0.0
    wide_share: float = 0.0
    depolarisation: float = 1.0

    def __post_init__(self) -> None:
        across = self.sigma if self.sigma_across is None else self.sigma_across
        refuse_unsound(f"{self.name}.sigma", self.sigma, 0.0)
        refuse_unsound(f"{self.name}.sigma_across", across, 0.0)
        refuse_unsound(f"{self.name}.axis", self.axis)
        refuse_unsound(f"{self.name}.wide_sigma", self.wide_sigma, 0.0)
        refuse_unsound(f"{self.name}.wide_share", self.wide_share, 0.0, 1.0)
        refuse_unsound(f"{self.name}.index", self.index, 1.0)
        refuse_unsound(f"{self.name}.transmission", self.transmission, 0.0, 1.0)
        refuse_unsound(f"{self.name}.depolarisation", self.depolarisation, 0.0, 1.0)

    def is_mirrored(self, period: float) -> bool:
        """Tell whether the lobe is round or lies along x or y."""
        is_round = self.sigma_across is None or self.sigma_across == self.sigma
        return is_round or abs(math.sin(2.0 * self.axis)) < 1e-12


@dataclass(frozen=True, eq=False)
class Film(Mirrored):
    """A film tile read from a mesh.

    Attributes
    ----------
    mesh
        the tile
    index
        refractive index of the prisms, and of a resin that has none of its own
    index_below
        that of the medium under it: 1, or the slab's on which it is bonded
    offset
        x [mm] in the scene of the tile's left edge, before the film is turned by `rotation`
    accelerator
        None to choose from the mesh, or one of `tile.ACCELERATORS`
    rotation
        angle [rad] by which the film is turned about z through the scene's origin: π/2 is crossed
    flipped
        whether it lies upside down, turned over about the middle line of its tile along y
    resin
        a fill that scatters or is of another material than the prisms, if it is
    absorption
        coefficient [1/mm] of the prisms, and of a resin that has none of its own
    roughness
        root mean square slope of the prisms' facets; where `resin` is None, of the whole top
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
    absorption: float = 0.0
    roughness: float = 0.0

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.index", self.index, 1.0)
        refuse_unsound(f"{self.name}.index_below", self.index_below, 1.0)
        refuse_unsound(f"{self.name}.absorption", self.absorption, 0.0)
        refuse_unsound(f"{self.name}.roughness", self.roughness, 0.0, 1.0)
        refuse_unsound(f"{self.name}.offset", self.offset)
        refuse_unsound(f"{self.name}.rotation", self.rotation)

    @property
    def shows_prism(self) -> bool:
        """Whether light sees the prisms' surface under the resin: rough, or of two materials."""
        if self.resin is None:
            return False
        index, absorption = self.resin.index, self.resin.absorption
        own = index not in (None, self.index) or absorption not in (None, self.absorption)
        return own or self.roughness > 0

    def is_mirrored(self, period: float) -> bool:
        """Tell whether the tile repeats so often in a cell that its side does not count."""
        return max(self.mesh.size[:2]) * EVEN <= period


@dataclass(frozen=True, eq=False)
class LibraryFilm(Mirrored):
    """A film as a library of groove pieces, or of cells, and their places.

    Attributes
    ----------
    library
        pieces and places
    index, index_below
        refractive index; that of the medium under it
    offset
        x [mm] in the scene of its left edge, before it is turned by `rotation`
    rotation
        angle [rad] by which it is turned about z through the scene's origin: π/2 is crossed
    """

    library: Library | CellTops
    index: float
    index_below: float = 1.0
    offset: float = 0.0
    name: str = "film"
    rotation: float = 0.0

    def is_mirrored(self, period: float) -> bool:
        """Tell whether the pieces are placed alike to both sides of x = 0 and of y = 0."""
        chosen = self.library.chosen
        both = np.array_equal(chosen, chosen[::-1]) and np.array_equal(chosen, chosen[:, ::-1])
        return both and self.offset == 0.0


@dataclass(frozen=True, eq=False)
class BsdfSheet(Mirrored):
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

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}.blend", self.blend, 0.0, 1.0)


Element = (
    Cavity | Board | Slab | Sheet | Film | BsdfSheet | LibraryFilm | PlaneLayer | MuellerLayer
    | Converter
)  # fmt: skip
