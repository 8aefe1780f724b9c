"""Colour the bodies of a STEP file.

OCCT's own colours come in an order that changes from run to run; these are appended to the text.
"""

import re
from pathlib import Path

_SOLID = re.compile(rb"#(\d+) = MANIFOLD_SOLID_BREP\(")
_SHAPE = re.compile(rb"= (?:ADVANCED_BREP_)?SHAPE_REPRESENTATION\('[^']*',\(([^)]*)\)\s*,\s*#(\d+)")
_LAST = re.compile(rb"#(\d+) = ")
_END = b"ENDSEC;\nEND-ISO-10303-21;\n"


def colour_bodies(path: Path, colours: list[tuple[float, float, float]]) -> None:
    """Give each body of the file its colour (red, green, blue; 0…1), in the order written.

    Raises
    ------
    ValueError
        when the file does not hold one body a colour.
    """
    text = path.read_bytes()
    solids = set(_SOLID.findall(text))
    bodies = []
    for items, context in _SHAPE.findall(text):
        inside = [int(item) for item in re.findall(rb"#(\d+)", items) if item in solids]
        if inside:
            bodies.append((inside, int(context)))
    if len(bodies) != len(colours) or not text.endswith(_END):
        raise ValueError(f"{path.name}: {len(bodies)} bodies for {len(colours)} colours")
    number = int(_LAST.findall(text[-10_000:])[-1])
    lines: list[str] = []
    for (inside, context), colour in zip(bodies, colours, strict=True):
        body = _styles(number + 1, inside, context, colour)
        number += len(body)
        lines += body
    with path.open("r+b") as file:
        file.seek(-len(_END), 2)
        file.write("".join(line + "\n" for line in lines).encode() + _END)


def _styles(
    first: int, solids: list[int], context: int, colour: tuple[float, float, float]
) -> list[str]:
    """Return the entities, numbered from `first`, that give the solids one colour."""
    rgb = ",".join(f"{part:.6E}" for part in colour)
    chain = [
        f"COLOUR_RGB('',{rgb})",
        f"FILL_AREA_STYLE_COLOUR('',#{first})",
        f"FILL_AREA_STYLE('',(#{first + 1}))",
        f"SURFACE_STYLE_FILL_AREA(#{first + 2})",
        f"SURFACE_SIDE_STYLE('',(#{first + 3}))",
        f"SURFACE_STYLE_USAGE(.BOTH.,#{first + 4})",
        f"PRESENTATION_STYLE_ASSIGNMENT((#{first + 5}))",
    ]
    style = first + len(chain) - 1
    chain += [f"STYLED_ITEM('color',(#{style}),#{solid})" for solid in solids]
    items = ",\n  ".join(f"#{style + 1 + i}" for i in range(len(solids)))
    chain.append(
        f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',(\n  {items}),#{context})"
    )
    return [f"#{first + i} = {entity};" for i, entity in enumerate(chain)]
