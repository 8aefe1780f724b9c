"""Write the film as a STEP file in mm: `BEF` and `fill`, or one body `film`."""

from pathlib import Path

from mpfcad.cad.step.file import PLAIN, Header, StepFile
from mpfcad.cad.step.outline import check_drawable
from mpfcad.cad.step.product import Products
from mpfcad.cad.step.solid import Bodies, draw_bodies
from mpfcad.film import PrismFilm

#: The bodies' names and their colours (red, green, blue; 0…1).
COLOURS = {"BEF": (0.62, 0.74, 0.86), "fill": (0.96, 0.72, 0.26), "film": (0.62, 0.74, 0.86)}


def write_step(
    film: PrismFilm,
    path: Path,
    *,
    name: str = "film",
    bodies: Bodies = "separate",
    header: Header = PLAIN,
) -> None:
    """Write the film with exact parabolas; same film and name, same bytes.

    `separate` bodies are the prism film (`BEF`) and the resin (`fill`, one solid a groove; absent
    without any resin); `fused` is one body `film`. No CAD library is used.

    Raises
    ------
    InputError
        when the film cannot be drawn.
    """
    check_drawable(film)
    path = Path(path)
    file = StepFile(header)
    products = Products(file)
    drawn = draw_bodies(file, film, bodies)
    parts = {body: products.part(body, solids, COLOURS[body]) for body, solids in drawn.items()}
    products.assembly(name, parts)
    products.write(path, name)
