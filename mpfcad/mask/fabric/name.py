"""Names of meshes as the trade writes them, and those that are nearest to an unknown one."""

import math
import re
from collections.abc import Iterable
from difflib import get_close_matches

from mpfcad.mask.fabric.mesh import Mesh
from mpfcad.mask.fabric.weave import Material
from mpfcad.units import um

#: threads/cm / threads/inch - thread µm and letters for colour and weave: `120/305-34Y PW`.
_NAME = re.compile(r"(?:(\d+(?:\.\d+)?)\s*/\s*)?(\d+(?:\.\d+)?)\s*[-.–]\s*(\d+)\s*[A-Za-z /]*$")
INCH_IN_CM = 2.54
#: Letters that are typed for figures.
_LOOKS_LIKE = str.maketrans("OIL", "011")
#: Words for steel, and for steel that was rolled; before the count or after the thread.
_STEEL = re.compile(r"steel|stainless|inox|edelstahl|(?<![a-z])(ss|sus|v2a|v4a)(?![a-z])")
_ROLLED = re.compile(r"calender|kalandriert|(?<![a-z])(cal|cl|c)(?![a-z])")
#: How far a count per inch, divided by 2.54, may be from the count per cm: both are rounded.
ROUNDING = 0.03
#: A mesh of another material is as far off as one of so much another count.
OTHER_MATERIAL = 0.3


def parse_name(text: str) -> tuple[tuple[float, ...], float] | None:
    """Return the counts per cm that a name may mean, likeliest first, and the thread [µm].

    `120-34`, `120/305-34`, `305-34`, `120.34`, `PET 1500 120/305-34Y PW`. A single count is per cm
    or per inch. None when it is no such name.
    """
    found = _NAME.search(text.strip())
    if found is None:
        return None
    per_cm, count, thread = found.groups()
    stated = float(per_cm or count)
    counts = (stated,) if per_cm is not None else (stated, stated / INCH_IN_CM)
    if not math.isfinite(stated + float(thread)):
        return None
    return counts, float(thread)


def named_materials(text: str) -> tuple[Material, ...]:
    """Return the materials that a name may mean, likeliest first.

    Examples
    --------
    >>> named_materials("SS 325-28 calendered")
    ('calendered steel',)
    """
    words = text.casefold()
    if _ROLLED.search(words):
        return ("calendered steel",)
    if _STEEL.search(words):
        return ("steel", "calendered steel")
    return ("polyester", "steel", "calendered steel")


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
    for material in named_materials(text):
        of_it = [mesh for mesh in meshes if mesh.material == material]
        for count in counts:
            near = [
                (abs(mesh.count * 10 / count - 1), i)
                for i, mesh in enumerate(of_it)
                if abs(mesh.thread / um - thread) < 0.5
                and (
                    round(mesh.count * 10) == count
                    if count == int(count)
                    else abs(mesh.count * 10 / count - 1) <= ROUNDING
                )
            ]
            if near:
                return of_it[min(near)[1]]
    return None


def nearest_names(text: str, meshes: Iterable[Mesh], most: int = 4) -> list[str]:
    """Return the names of the meshes nearest to an unknown one: as written, then as woven."""
    meshes = list(meshes)
    typed = text.upper().translate(_LOOKS_LIKE)
    names = {mesh.name.upper(): mesh for mesh in meshes}
    alike = [names[name] for name in get_close_matches(typed, names, most, 0.6)]
    parsed = parse_name(text)
    number = re.search(r"\d+", text)
    alone = float(number[0]) if number else 0.0
    stated, thread = parsed or ((alone, alone / INCH_IN_CM), 0.0)
    counts = [count for count in stated if 0 < count < math.inf]
    if not counts:
        return _first(most, alike, meshes)
    likeliest = named_materials(text)[0]

    def distance(mesh: Mesh) -> float:
        aside = abs(math.log(mesh.thread / um / thread)) if 0 < thread < math.inf else 0.0
        aside += 0.0 if mesh.material == likeliest else OTHER_MATERIAL
        return min(abs(math.log(mesh.count * 10 / count)) for count in counts) + aside

    woven = sorted(meshes, key=distance)
    return _first(most, sorted(alike[: most // 2], key=distance), woven)


def _first(most: int, *groups: list[Mesh]) -> list[str]:
    return list(dict.fromkeys(mesh.name for group in groups for mesh in group))[:most]
