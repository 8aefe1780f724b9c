"""A scene: horizontal elements from the bottom up, lowered to flat arrays for the kernels.

Elements touch: a ray that leaves one upward enters the next from below. Between elements is air,
but for a slab with a film bonded on it, where the slab's own medium reaches up to the film.
Everything repeats sideways without end: lamps with the lamp pitch, a film with the size of its
mesh.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError, TraceError
from mpfcad.optics.base.phase import phase_table
from mpfcad.optics.bsdf.passage import BsdfArrays, build_bsdf
from mpfcad.optics.cavity.board import Board
from mpfcad.optics.cavity.emission import Emission, EmissionArrays
from mpfcad.optics.cavity.finite import NO_WALL
from mpfcad.optics.element import (
    CELL_FILM,
    FILM,
    LIBRARY_FILM,
    Cavity,
    Element,
    Film,
    LibraryFilm,
    Slab,
)
from mpfcad.optics.film.passage import TILE
from mpfcad.optics.library.piece import LibraryArrays, build_libraries
from mpfcad.optics.library.top import CellArrays, build_cells
from mpfcad.optics.lowering import COLUMNS, Shared, lower_element, quadrant
from mpfcad.optics.search.tile import ACCELERATORS, build_tile
from mpfcad.optics.search.tile_table import TileTable, build_tile_table
from mpfcad.optics.stokes.mueller import MuellerLayer
from mpfcad.optics.stokes.plane import PlaneLayer

#: Largest length [mm] along y over which a meter averages on a finite panel.
_MOST_ALONG = 2.0


class Scene(NamedTuple):
    """What the kernels read.

    Attributes
    ----------
    kind
        (e,) int64, element kinds from the bottom up
    parameter
        (e, COLUMNS) float64, each element's values in columns that its kernel names (`lowering`)
    tiles
        the tiles of the films and of the prisms under their resin
    phase
        (r, STEPS+1) float64, tabulated phase functions
    library, cells
        films that are pieces of grooves, or cells, and their places
    bsdf
        the tables of all BSDF elements
    wall, lamp
        (7,) and (l, 3) float64, a finite panel's (`Panel.arrays`); without end: no lamps
    led, emission
        (l, 4) float64, a board's (`Board.array`), and how its LEDs emit; no board: no LEDs
    glow
        (n+1,) float64 [cd/m²], what ends paths on the reflector (`cavity.glow`); empty: nothing
    length
        [mm] along y over which the stack repeats, and a meter averages unless told otherwise
    polarised
        whether paths carry Stokes vectors
    below, above
        radiance [cd/m²] of black surroundings' place under the first and over the last element
    """

    kind: NDArray[np.int64]
    parameter: NDArray[np.float64]
    tiles: TileTable
    phase: NDArray[np.float64]
    bsdf: BsdfArrays
    library: LibraryArrays
    cells: CellArrays
    wall: NDArray[np.float64]
    lamp: NDArray[np.float64]
    led: NDArray[np.float64]
    emission: EmissionArrays
    glow: NDArray[np.float64]
    length: float
    polarised: bool
    below: float
    above: float

    @property
    def accelerators(self) -> str:
        """How the films are traced, each way once: `chain`, `chain, grid`, `library` and so on."""
        films = self.parameter[self.kind == FILM, TILE].astype(int)
        ways = [ACCELERATORS[a] for a in self.tiles.accelerator[films]]
        ways += ["library"] if (self.kind == LIBRARY_FILM).any() else []
        ways += ["cells"] if (self.kind == CELL_FILM).any() else []
        return ", ".join(dict.fromkeys(ways))


def build_scene(
    elements: list[Element], *, below: float = 0.0, above: float = 0.0, polarised: bool = False
) -> Scene:
    """Return the scene of elements given from the bottom up, between radiances `below` and `above`.

    Raises
    ------
    TraceError
        when a cavity is not the lowest element, what lies on a bonded slab has not its index below,
        the asked accelerator does not fit the mesh, or a layer acts on polarisation and light has
        none.
    InputError
        when the mesh of a film that is bonded or holds resin has no flat underside.
    """
    return build_scenes([elements], below=below, above=above, polarised=polarised)[0]


def build_scenes(
    variants: list[list[Element]], *, below: float = 0.0, above: float = 0.0,
    polarised: bool = False,
) -> list[Scene]:  # fmt: skip
    """Return the scenes of the same elements with other numbers; their meshes are built once.

    Raises
    ------
    TraceError, InputError
        as `build_scene`.
    """
    shared = Shared()
    lowered = [_rows(elements, shared, polarised) for elements in variants]
    first, walls = _built(variants[0], shared, below, above, polarised), map(_walls, variants)
    return [
        first._replace(kind=kind, parameter=parameter, wall=wall, lamp=lamp)
        for (kind, parameter), (wall, lamp) in zip(lowered, walls, strict=True)
    ]


def _rows(
    elements: list[Element], shared: Shared, polarised: bool
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the kinds and rows of checked elements."""
    _check_order(elements)
    for element in elements:
        if isinstance(element, PlaneLayer | MuellerLayer) and not polarised:
            raise TraceError(f"{element.name}: what acts on polarisation: needs polarised light")
    kind = np.zeros(len(elements), np.int64)
    parameter = np.zeros((len(elements), COLUMNS))
    for i, element in enumerate(elements):
        kind[i], parameter[i] = lower_element(element, shared)
    return kind, parameter


def _walls(elements: list[Element]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a finite panel's walls and lamps."""
    panel = elements[0].panel if elements and isinstance(elements[0], Cavity) else None
    return panel.arrays() if panel else (NO_WALL, np.zeros((0, 3)))


def _built(
    elements: list[Element], shared: Shared, below: float, above: float, polarised: bool
) -> Scene:
    """Return the scene of what elements share; their rows and walls are empty."""
    panel = elements[0].panel if elements and isinstance(elements[0], Cavity) else None
    board = elements[0] if elements and isinstance(elements[0], Board) else None
    led = board.array() if board else np.zeros((0, 4))
    emission = board.emission.arrays() if board else Emission.none()
    length = max((_extent_along(e) for e in elements if isinstance(e, Film)), default=1.0)
    if board:
        length = board.period[1]
    if panel:
        length = min(length, _MOST_ALONG)
    table = build_tile_table([build_tile(mesh, way) for mesh, way in shared.tiles.entries])
    phase = phase_table(shared.phases.entries)
    tables = shared.bsdfs.entries
    bsdf = build_bsdf([t for t, _ in tables], [blend for _, blend in tables])
    library = build_libraries(shared.libraries.entries)
    cells = build_cells(shared.cells.entries)
    sky = float(below), float(above)
    return Scene(
        np.zeros(0, np.int64), np.zeros((0, COLUMNS)), table, phase, bsdf, library, cells,
        NO_WALL, np.zeros((0, 3)), led, emission, np.zeros(0), length, polarised, *sky,
    )  # fmt: skip


def _check_order(elements: list[Element]) -> None:
    for i, element in enumerate(elements):
        if isinstance(element, Cavity | Board) and i > 0:
            raise TraceError("the cavity must be the lowest element")
        hanging = isinstance(element, Film) and not element.mesh.underside
        if isinstance(element, Film) and hanging and (element.index_below != 1 or element.resin):
            raise InputError(
                f"{element.name}: mesh without flat underside: needs one to be bonded or to hold "
                "resin that scatters or is of another material"
            )
        upper = elements[i + 1] if i + 1 < len(elements) else None
        if isinstance(element, Slab) and element.bonded:
            if not isinstance(upper, Film | LibraryFilm | Slab):
                raise TraceError("a bonded slab needs a film or slab on it")
            if isinstance(upper, Film) and upper.flipped:
                raise TraceError("a film upside down cannot be bonded on a slab")
            if upper.index_below != element.index:
                raise TraceError(
                    f"{upper.name}: index_below {upper.index_below:g}: expected the index of "
                    f"{element.name}, {element.index:g}"
                )
        lower = elements[i - 1] if i else None
        lies_on = isinstance(lower, Slab) and lower.bonded
        floats = lower is not None or isinstance(element, Slab)
        in_index = isinstance(element, Film | LibraryFilm | Slab) and element.index_below != 1
        if in_index and floats and not lies_on:
            raise TraceError(f"{element.name}: index_below: expected a bonded slab under it")


def _extent_along(film: Film) -> float:
    """Return over which length [mm] along y a film repeats; turned askew, its longer side."""
    _, sine = quadrant(film.rotation)
    width, length, _ = film.mesh.size
    return length if sine == 0 else width if abs(sine) == 1 else max(width, length)
