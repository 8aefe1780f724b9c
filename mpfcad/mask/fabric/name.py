"""Names of meshes as the trade writes them, and those that are nearest to an unknown one."""

import math
import re
from collections.abc import Iterable

from mpfcad.mask.fabric.mesh import Mesh
from mpfcad.units import um

#: threads/cm / threads/inch - thread µm and letters for colour and weave: `120/305-34Y PW`.
_NAME = re.compile(r"(?:(\d+(?:\.\d+)?)\s*/\s*)?(\d+(?:\.\d+)?)\s*[-.–]\s*(\d+)\s*[A-Za-z /]*$")
INCH_IN_CM = 2.54
#: How far a count per inch, divided by 2.54, may be from the count per cm: both are rounded.
ROUNDING = 0.03


def parse_name(text: str) -> tuple[tuple[float, ...], float] | None:
    """Return the counts per cm that a name may mean, likeliest first, and the thread [µm].

    `120-34`, `120/305-34`, `305-34`, `120.34`, `PET 1500 120/305-34Y PW`. A single count is per cm
    or per inch. None when it is no such name.
    """
    found = _NAME.search(text.strip())
    if found is None:
        return None
    per_cm, count, thread = found.groups()
    if per_cm is not None:
        return (float(per_cm),), float(thread)
    return (float(count), float(count) / INCH_IN_CM), float(thread)


def match_name(text: str, meshes: Iterable[Mesh]) -> Mesh | None:
    """Return the mesh that a name means; None when there is none."""
    meshes = list(meshes)
    exact = [mesh for mesh in meshes if mesh.name.casefold() == text.strip().casefold()]
    if exact:
        return exact[0]
    parsed = parse_name(text)
    if parsed is None:
        return None
    counts, thread = parsed
    for count in counts:
        near = [
            (abs(mesh.count * 10 / count - 1), i)
            for i, mesh in enumerate(meshes)
            if abs(mesh.thread / um - thread) < 0.5
            and abs(mesh.count * 10 / count - 1) <= (0 if count == int(count) else ROUNDING)
        ]
        if near:
            return meshes[min(near)[1]]
    return None


def nearest_names(text: str, meshes: Iterable[Mesh], most: int = 4) -> list[str]:
    """Return the names of the meshes that are nearest to an unknown one, by count and thread."""
    parsed = parse_name(text)
    number = re.search(r"\d+", text)
    if parsed is None and number is None:
        return [mesh.name for mesh in meshes][:most]
    counts, thread = parsed or ((float(number[0]),), 0.0)  # type: ignore[index]

    def distance(mesh: Mesh) -> float:
        aside = abs(math.log(mesh.thread / um / thread)) if thread else 0.0
        return min(abs(math.log(mesh.count * 10 / count)) for count in counts if count > 0) + aside

    return [mesh.name for mesh in sorted(meshes, key=distance)[:most]]
