"""A woven mesh: openings, resin volume, and the finest stencil that it carries.

With n threads per length and thread diameter d the opening is w = 1/n - d, the open area
(w/(w+d))², and the theoretical volume open area × fabric thickness. A stencil aperture prints that
volume and what the emulsion adds below the fabric, over its own area; so of a groove whose full
cross-section is A per pitch p, aperture ratio a fills

    fill = a · transfer factor,   transfer factor = release · volume · p / A,

where release (0…1) is the share of the volume that leaves the screen.
"""

from dataclasses import dataclass, replace

from mpfcad.film import Groove
from mpfcad.mask.fabric.weave import Material, check_weave
from mpfcad.units import um

#: Fabric thickness over thread diameter where no figure is given. Polyester: 59/40, 72/48, 84/54
#: and 63/40 of the catalogue have mean 1.53, and twice their deviation is 0.09. Steel wire does
#: not flatten as it is woven: two wires, less up to a tenth. How far a calender rolls it is the
#: weaver's: from hardly at all down to crossings of six tenths.
THICKNESS_FACTOR: dict[Material, tuple[float, float]] = {
    "polyester": (1.53, 0.09),
    "steel": (1.95, 0.10),
    "calendered steel": (1.55, 0.35),
}
#: How far an opening of steel that is computed, and one from a table, may be off [mm], 95 %.
WIRE_WIDTH, STATED_WIDTH = 2.0 * um, 0.5 * um
#: That of polyester, in threads: they flatten as they are woven, at one weaver's more than at
#: another's. The catalogue's openings exceed 1/n - d by up to 0.05 threads or fall short of it by
#: 0.04; ink volumes quoted of SEFAR PET 1500 (156 per inch: 30 cm³/m², 195: 22, 230: 19, read as
#: 61-64, 77-55, 90-48) mean openings that are up to 0.15 threads smaller.
THREAD_WIDTH = 0.15


@dataclass(frozen=True)
class Mesh:
    """A woven mesh; lengths in mm.

    Attributes
    ----------
    name
        threads per cm, a hyphen, thread diameter in µm; of steel as the trade has it, per inch
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
    material
        `polyester`, `steel` (as woven) or `calendered steel`
    opening_width, thickness_width
        half widths of the 95 % intervals of opening and thickness
    """

    name: str
    count: float
    thread: float
    opening: float
    thickness: float
    emulsion: float
    source: str
    material: Material = "polyester"
    opening_width: float = WIRE_WIDTH
    thickness_width: float = 0.0

    @property
    def cell(self) -> float:
        """Distance from thread to thread [mm]."""
        return 1 / self.count

    @property
    def open_area(self) -> float:
        """Open share of the fabric, (w/(w+d))²; (w·n)² where a thread is flattened to 1/n - w."""
        return (self.opening / max(self.cell, self.opening + self.thread)) ** 2

    @property
    def fabric_volume(self) -> float:
        """Theoretical volume of the openings over area [mm, = 1000 cm³/m²]."""
        return self.open_area * self.thickness

    @property
    def volume(self) -> float:
        """Theoretical volume that an aperture prints over its own area [mm], emulsion included."""
        return self.fabric_volume + self.emulsion

    @property
    def volume_width(self) -> float:
        """Half width of the volume's 95 % interval over the volume, from opening and thickness."""
        area = 2 * self.opening_width / self.opening
        fabric = (area**2 + (self.thickness_width / self.thickness) ** 2) ** 0.5
        return fabric * self.fabric_volume / self.volume

    @property
    def is_sourced(self) -> bool:
        """Whether opening and thickness are a table's, not computed."""
        return self.opening_width <= STATED_WIDTH and self.thickness_width <= STATED_WIDTH

    @property
    def computed(self) -> str:
        """Which of opening and thickness are computed, as text; empty: neither."""
        widths = (("opening", self.opening_width), ("thickness", self.thickness_width))
        return " and ".join(name for name, width in widths if width > STATED_WIDTH)

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

    def coated(self, emulsion: float) -> "Mesh":
        """Return the mesh with emulsion [mm] below the fabric."""
        return replace(self, emulsion=emulsion)


def build_mesh(
    threads_per_cm: float,
    thread: float,
    *,
    opening: float | None = None,
    thickness: float | None = None,
    emulsion: float = 0.0,
    material: Material = "polyester",
    source: str = "given",
    name: str | None = None,
    where: str = "mesh.",
) -> Mesh:
    """Return the mesh of a thread count and a thread diameter [mm].

    Opening and thickness [mm] that are left out are computed, and the width of what is then not
    known goes with them.

    Raises
    ------
    InputError
        that begins with `where` and the field, for figures that no weave has.
    """
    check_weave(threads_per_cm, thread, opening, thickness, material, where)
    count = threads_per_cm / 10
    factor, spread = THICKNESS_FACTOR[material]
    computed_width = THREAD_WIDTH * thread if material == "polyester" else WIRE_WIDTH
    computed = [what for what, value in (("opening", opening), ("thickness", thickness))
                if value is None]  # fmt: skip
    return Mesh(
        name=name or f"{threads_per_cm:g}-{thread / um:g}",
        count=count,
        thread=thread,
        opening=1 / count - thread if opening is None else opening,
        thickness=factor * thread if thickness is None else thickness,
        emulsion=emulsion,
        source=source + (f"; {' and '.join(computed)} computed" if computed else ""),
        material=material,
        opening_width=computed_width if opening is None else STATED_WIDTH,
        thickness_width=spread * thread if thickness is None else STATED_WIDTH,
    )
