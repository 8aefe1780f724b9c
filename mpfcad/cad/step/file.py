"""The text of a STEP file (ISO 10303-21): numbered entities, and the geometry that bodies share.

A point, direction, line or plane that is asked for again is the same entity again.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

#: Decimals of a coordinate [mm]: all that a double has at x = 400 mm.
DECIMALS = 13
#: Entities in a line of the file: a line end after each would be 2 % of a panel.
IN_LINE = 20
#: The header's time: fixed, so that the same film gives the same bytes.
TIMESTAMP = "2000-01-01T00:00:00"


def real(value: float) -> str:
    """Return a number as STEP writes it, 15 significant digits."""
    mantissa, mark, exponent = f"{value + 0.0:.15g}".partition("e")
    return mantissa + ("" if "." in mantissa else ".") + ("E" + exponent if mark else "")


def text(value: str) -> str:
    r"""Return a string as STEP writes it: what is not ASCII as \X2\ and \X4\ codes."""
    written = []
    for character in value.replace("\\", "\\\\").replace("'", "''"):
        code = ord(character)
        if 32 <= code < 127:
            written.append(character)
        else:
            written.append(f"\\X2\\{code:04X}\\X0\\" if code < 2**16 else f"\\X4\\{code:08X}\\X0\\")
    return "'" + "".join(written) + "'"


@dataclass(frozen=True)
class Header:
    """What a STEP file says of itself.

    Attributes
    ----------
    protocol
        application protocol: `ap214` (ISO 10303-214) or `ap242` (ISO 10303-242)
    author, organisation
        as the job names them; empty where it does not
    """

    protocol: Literal["ap214", "ap242"] = "ap214"
    author: str = ""
    organisation: str = ""


PLAIN = Header()


class StepFile:
    """Entities in the order they were added; each is known by its reference, such as `#17`."""

    def __init__(self, header: Header = PLAIN) -> None:
        self.header = header
        self._entities: list[str] = []
        self._known: dict[tuple[object, ...], str] = {}

    def add(self, entity: str) -> str:
        """Add an entity and return its reference."""
        reference = f"#{len(self._entities) + 1}"
        self._entities.append(f"{reference}={entity};")
        return reference

    def share(self, *key: object) -> str:
        """Return the entity with this type and these attributes, added at the first time only."""
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self.add(f"{key[0]}('',{','.join(map(str, key[1:]))})")
        return found

    def point(self, x: float, y: float, z: float) -> str:
        """Return a point [mm]."""
        place = f"({_coordinate(x)},{_coordinate(y)},{_coordinate(z)})"
        return self.share("CARTESIAN_POINT", place)

    def direction(self, x: float, y: float, z: float) -> str:
        """Return a direction; parallel to 1e-9 is the same, as it was first asked for.

        Corners have absolute errors, so the walls of grooves far from x = 0 are parallel only to
        1e-11. The first groove's are the exact ones.
        """
        key = ("DIRECTION", round(x, 9), round(y, 9), round(z, 9))
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = self.add(f"DIRECTION('',({real(x)},{real(y)},{real(z)}))")
        return found

    def vector(self, direction: str) -> str:
        """Return the vector of length 1 mm in a direction."""
        return self.share("VECTOR", direction, "1.")

    def line(self, point: str, direction: str) -> str:
        """Return the straight line through a point."""
        return self.share("LINE", point, self.vector(direction))

    def axes(self, origin: str, axis: str, reference: str) -> str:
        """Return a placement: its z axis is `axis`, its x axis `reference`."""
        return self.share("AXIS2_PLACEMENT_3D", origin, axis, reference)

    def plane(self, point: str, normal: str, reference: str) -> str:
        """Return the plane through a point; `reference` lies in it."""
        return self.share("PLANE", self.axes(point, normal, reference))

    def write(self, path: Path, name: str, schema: str) -> None:
        """Write the whole file in the given schema; nothing in it tells machine or time.

        It is written beside `path` and renamed, so that `path` never holds a part of it.
        """
        head = (
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('Multi-performance film; unit mm; x across,"
            f" y along, z up'),'2;1');\nFILE_NAME({text(name)},'{TIMESTAMP}',"
            f"({text(self.header.author)}),({text(self.header.organisation)}),'mpfcad',"
            f"'mpfcad','');\nFILE_SCHEMA(('{schema}'));\nENDSEC;\nDATA;\n"
        )
        part = path.with_name("." + path.name + ".part")
        try:
            with part.open("w", encoding="ascii", newline="\n") as file:
                file.write(head)
                for first in range(0, len(self._entities), IN_LINE):
                    file.write("".join(self._entities[first : first + IN_LINE]) + "\n")
                file.write("ENDSEC;\nEND-ISO-10303-21;\n")
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)


def _coordinate(value: float) -> str:
    return f"{value + 0.0:.{DECIMALS}f}".rstrip("0")
