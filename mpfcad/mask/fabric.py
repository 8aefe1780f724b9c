"""The screen's woven mesh: openings, resin volume, and the finest stencil that it carries.

With n threads per length and thread diameter d the opening is w = 1/n - d, the open area
(w/(w+d))², and the theoretical volume open area × fabric thickness. A stencil aperture prints that
volume and what the emulsion adds below the fabric, over its own area; so of a groove whose full
cross-section is A per pitch p, aperture ratio a fills

    fill = a · transfer factor,   transfer factor = release · volume · p / A,

where release (0…1) is the share of the volume that leaves the screen. It has to be calibrated.
"""

from dataclasses import dataclass

from mpfcad.errors import InputError
from mpfcad.film import Groove
from mpfcad.units import um

#: Fabric thickness over thread diameter where no catalogue figure is given: 1.48 … 1.58 in
#: catalogues of plain woven polyester.
THICKNESS_FACTOR = 1.5
CATALOGUE = "manufacturer's table (polyester, plain weave, before tensioning)"
COMPUTED = "opening from count and thread; thickness assumed 1.5 × thread"


@dataclass(frozen=True)
class Mesh:
    """A woven mesh; lengths in mm.

    Attributes
    ----------
    name
        threads per cm, a hyphen, thread diameter in µm
    count
        threads per mm
    thread
        diameter of the thread
    opening
        between threads, w
    thickness
        of the fabric
    emulsion
        how far the emulsion stands below the fabric
    source
        where the figures come from
    """

    name: str
    count: float
    thread: float
    opening: float
    thickness: float
    emulsion: float
    source: str

    @property
    def cell(self) -> float:
        """Distance from thread to thread [mm]."""
        return 1 / self.count

    @property
    def open_area(self) -> float:
        """Open share of the fabric, (w/(w+d))²."""
        return (self.opening / (self.opening + self.thread)) ** 2

    @property
    def fabric_volume(self) -> float:
        """Theoretical volume of the openings over area [mm, = 1000 cm³/m²]."""
        return self.open_area * self.thickness

    @property
    def volume(self) -> float:
        """Theoretical volume that an aperture prints over its own area [mm], emulsion included."""
        return self.fabric_volume + self.emulsion

    @property
    def min_feature(self) -> float:
        """Smallest aperture and smallest web that the mesh carries [mm]: one cell of it.

        Wherever such an aperture lies, it has at least one opening's width free in either
        direction; wherever such a web lies, at least one thread's width holds it.
        """
        return self.cell

    def transfer_factor(self, groove: Groove, release: float = 1.0) -> float:
        """Return fill fraction over aperture ratio when a share `release` leaves the screen."""
        return release * self.volume * groove.pitch / groove.area

    def release(self, groove: Groove, transfer_factor: float) -> float:
        """Return the share of the volume that leaves the screen with a given transfer factor."""
        return transfer_factor / self.transfer_factor(groove)


def build_mesh(
    threads_per_cm: float,
    thread: float,
    *,
    thickness: float | None = None,
    emulsion: float = 0.0,
    where: str = "mesh",
) -> Mesh:
    """Return the mesh of a thread count and a thread diameter [mm].

    Raises
    ------
    InputError
        that begins with `where`, for threads that leave no opening.
    """
    count = threads_per_cm / 10
    opening = 1 / count - thread
    if opening <= 0:
        raise InputError(
            f"{where}: {threads_per_cm:g} threads/cm of {thread / um:g} µm: finer than its thread, "
            f"nothing is open: allowed threads thinner than {1 / count / um:.4g} µm"
        )
    return Mesh(
        name=f"{threads_per_cm:g}-{thread / um:g}",
        count=count,
        thread=thread,
        opening=opening,
        thickness=THICKNESS_FACTOR * thread if thickness is None else thickness,
        emulsion=emulsion,
        source=COMPUTED if thickness is None else "given",
    )


def _catalogue(threads_per_cm: float, thread: float, opening: float, thickness: float) -> Mesh:
    name = f"{threads_per_cm:g}-{thread:g}"
    size = (thread * um, opening * um, thickness * um)
    return Mesh(name, threads_per_cm / 10, *size, 0.0, CATALOGUE)


#: Common meshes by name, coarse to fine. Catalogue openings exceed 1/n - d: threads flatten.
MESHES: dict[str, Mesh] = {
    mesh.name: mesh
    for mesh in (
        *(build_mesh(n, d * um) for n, d in ((43, 80), (54, 64), (61, 64), (77, 55))),
        _catalogue(90, 40, 73, 59),
        _catalogue(90, 48, 65, 72),
        _catalogue(90, 54, 59, 84),
        *(build_mesh(n, d * um) for n, d in ((100, 40), (120, 31), (120, 34), (140, 31))),
        *(build_mesh(n, d * um) for n, d in ((150, 31), (165, 31), (180, 27))),
    )
}


def find_mesh(name: str, *, emulsion: float = 0.0, where: str = "mesh") -> Mesh:
    """Return a common mesh, with its emulsion [mm].

    Raises
    ------
    InputError
        that begins with `where` and lists the meshes.
    """
    if name not in MESHES:
        raise InputError(f"{where}: {name!r}: allowed one of {', '.join(MESHES)}")
    mesh = MESHES[name]
    return Mesh(**{**vars(mesh), "emulsion": emulsion})


def coarsest_mesh(feature: float) -> Mesh | None:
    """Return the common mesh with most volume whose smallest feature is at most `feature` [mm]."""
    fine = [mesh for mesh in MESHES.values() if mesh.min_feature <= feature * (1 + 1e-12)]
    return max(fine, key=lambda mesh: mesh.fabric_volume, default=None)
