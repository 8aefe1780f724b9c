"""The meshes that can be named: the table that comes with the program, and tables of a weaver."""

import csv
import math
from functools import cache
from pathlib import Path

from mpfcad.boundary import TEXT_LIMIT, reads, reason_of
from mpfcad.errors import InputError
from mpfcad.mask.fabric.mesh import Mesh, build_mesh
from mpfcad.mask.fabric.name import match_name, nearest_names
from mpfcad.mask.fabric.weave import Material
from mpfcad.units import um

SHIPPED = Path(__file__).with_name("catalogue.csv")
COLUMNS = (
    "name", "material", "threads_per_cm", "thread_um", "opening_um", "thickness_um", "source"
)  # fmt: skip
#: Columns that may be empty: the value is then computed, with its width.
OPTIONAL = ("opening_um", "thickness_um")
LARGEST = 5000.0
MATERIALS: dict[str, Material] = {name: name for name in ("polyester", "steel", "calendered steel")}


@cache
def shipped_catalogue() -> tuple[Mesh, ...]:
    """Return the meshes that come with the program, coarse to fine."""
    return read_catalogue(SHIPPED)


@reads("a table of meshes", TEXT_LIMIT)
def read_catalogue(path: Path) -> tuple[Mesh, ...]:
    """Return the meshes of a table, in its order.

    Raises
    ------
    InputError
        naming the file, the row (the header is row 1), the column and the value.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: {reason_of(error)}: expected a table of meshes") from None
    if not rows or tuple(cell.strip() for cell in rows[0]) != COLUMNS:
        raise InputError(f"{path}: row 1: header: expected {','.join(COLUMNS)}")
    meshes = [_read_row(row, f"{path}: row {number}") for number, row in enumerate(rows[1:], 2)]
    if not meshes:
        raise InputError(f"{path}: no rows: expected 1 or more")
    names = [mesh.name.casefold() for mesh in meshes]
    twice = next((i for i, name in enumerate(names) if name in names[:i]), None)
    if twice is not None:
        raise InputError(f"{path}: row {twice + 2}: name: {meshes[twice].name}: expected it once")
    return tuple(meshes)


def _read_row(row: list[str], where: str) -> Mesh:
    if len(row) != len(COLUMNS):
        raise InputError(f"{where}: {len(row)} columns: expected {len(COLUMNS)}")
    cells = dict(zip(COLUMNS, (cell.strip() for cell in row), strict=True))
    material = MATERIALS.get(cells["material"])
    if material is None:
        raise InputError(
            f"{where}: material: {cells['material']!r}: expected 'polyester', 'steel' or "
            f"'calendered steel'"
        )
    if not cells["name"] or not cells["source"]:
        raise InputError(f"{where}: name, source: expected both")
    value = {
        column: _number(cells[column], f"{where}: {column}", column in OPTIONAL)
        for column in COLUMNS[2:6]
    }
    size = {column: None if v is None else v * um for column, v in value.items()}
    return build_mesh(
        value["threads_per_cm"] or math.nan,
        size["thread_um"] or math.nan,
        opening=size["opening_um"],
        thickness=size["thickness_um"],
        material=material,
        source=cells["source"],
        name=cells["name"],
        where=f"{where}: ",
    )


def _number(text: str, where: str, optional: bool) -> float | None:
    if not text and optional:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value <= LARGEST:
        raise InputError(f"{where}: {text!r}: expected a number above 0, up to {LARGEST:g}")
    return value


def find_mesh(
    name: str,
    *,
    emulsion: float = 0.0,
    catalogue: tuple[Mesh, ...] | None = None,
    where: str = "mesh",
) -> Mesh:
    """Return a mesh by its name in any of the trade's spellings, with its emulsion [mm].

    Raises
    ------
    InputError
        that begins with `where` and lists the nearest meshes.

    Examples
    --------
    >>> find_mesh("120/305-34Y PW").name
    '120-34'
    """
    meshes = shipped_catalogue() if catalogue is None else catalogue
    mesh = match_name(name, meshes)
    if mesh is None:
        near = ", ".join(nearest_names(name, meshes))
        raise InputError(
            f"{where}: {name!r}: not in the catalogue: expected a name such as 120-34 or "
            f"120/305-34; the nearest are {near}"
        )
    return mesh.coated(emulsion)


def coarsest_mesh(
    feature: float, material: Material = "polyester", catalogue: tuple[Mesh, ...] | None = None
) -> Mesh | None:
    """Return the mesh with most volume whose smallest feature is at most `feature` [mm]."""
    fine = [
        mesh
        for mesh in (shipped_catalogue() if catalogue is None else catalogue)
        if mesh.material == material and mesh.min_feature <= feature * (1 + 1e-12)
    ]
    return max(fine, key=lambda mesh: mesh.fabric_volume, default=None)
