"""Gerber RS-274X read again: a strict reader of the commands that a mask is made of.

It knows FS, MO, AD (C and R), LP, SR, G01, G36, G37, D01 to D03 and G04; anything else is
refused. Step-and-repeat blocks stay arrays.
"""

import re
from pathlib import Path

from mpfcad.errors import ExportError
from mpfcad.mask.array import ApertureArray, Placement
from mpfcad.mask.check.found import Box, FoundMask, read_polarity, region_of
from mpfcad.mask.layer import APERTURE, COUPON, FIDUCIAL, LAYERS, OUTLINE, TEXT
from mpfcad.mask.rule import GRID
from mpfcad.units import um

_FLASH = re.compile(r"X(-?\d+)Y(-?\d+)D0([123])\*")
_RECTANGLE = re.compile(r"%ADD(\d+)R,([\d.]+)X([\d.]+)\*%")
_CIRCLE = re.compile(r"%ADD(\d+)C,([\d.]+)\*%")
_REPEAT = re.compile(r"%SRX(\d+)Y(\d+)I([\d.]+)J([\d.]+)\*%")
_LAYER = re.compile(r"G04 #@! TA\.AperFunction,Other,(\w+)\*")
_PASSED = ("G01*", "M02*")
_NUMBERS = {name: layer for layer, name in LAYERS.items()}


def read_gerber(path: Path) -> FoundMask:
    """Return what a Gerber file holds.

    Raises
    ------
    ExportError
        naming the first line that no mask has.
    """
    reader = _Reader(path)
    try:
        with path.open(encoding="ascii") as file:
            for number, line in enumerate(file, 1):
                reader.read(number, line.rstrip("\n"))
    except (OSError, UnicodeDecodeError) as error:
        raise ExportError(f"{path}: not a readable mask: {error}") from None
    reader.finish()
    polarity = read_polarity(path, tuple(reader.text))
    arrays = reader.flashes[APERTURE]
    if (polarity == "closed") != reader.is_inverted:
        raise ExportError(f"{path}: text: 'drawn = {polarity}' is not what is painted")
    return FoundMask(
        outline=reader.outline,
        unit=GRID / um,
        text=tuple(reader.text),
        fiducials=tuple(reader.polygons[FIDUCIAL]),
        coupon=tuple(reader.flashes[COUPON]),
        drawn="open",
        arrays=lambda: iter(arrays),
        window=lambda box: region_of(iter(arrays), box),
        snap_error=reader.snap_error,
    )


class _Reader:
    """The state of the plotter."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.text: list[str] = []
        self.layer = 0
        self.size: dict[int, tuple[int, int]] = {}
        self.code = 0
        self.repeat = (1, 1, 0, 0)
        self.dark = True
        self.flashes: dict[int, list[ApertureArray]] = {layer: [] for layer in LAYERS}
        self.polygons: dict[int, list[Box]] = {layer: [] for layer in LAYERS}
        self.contour: list[tuple[int, int]] | None = None
        self.line: list[tuple[int, int]] = []
        self.stated: set[str] = set()
        self.snap_error = 0.0
        self.is_whole = False

    @property
    def is_inverted(self) -> bool:
        """Whether the panel is painted dark first."""
        return self.polygons[APERTURE] == [self.outline]

    @property
    def outline(self) -> Box:
        """The panel, by the line around it: the line's middle is half its width outside."""
        half = self.size[min(self.size)][0] // 2
        x, y = zip(*self.line, strict=True)
        return min(x) + half, min(y) + half, max(x) - half, max(y) - half

    def read(self, number: int, line: str) -> None:
        """Carry out one command."""
        if self.is_whole:
            raise ExportError(f"{self.path}: line {number}: a command after the end")
        found = _FLASH.fullmatch(line)
        if found:
            self._operate(int(found[1]), int(found[2]), int(found[3]))
        elif line.startswith("G04 #@! TF."):
            pass
        elif line.startswith("G04 ") and not line.startswith("G04 #@!"):
            self.text.append(line[4:-1])
        elif line in ("%FSLAX46Y46*%", "%MOMM*%"):
            self.stated.add(line)
        elif line in ("G36*", "G37*"):
            self._region(begins=line == "G36*")
        elif line in ("%LPD*%", "%LPC*%"):
            self.dark = line == "%LPD*%"
        elif re.fullmatch(r"D\d\d+\*", line):
            self.code = int(line[1:-1])
        elif line in _PASSED:
            self.is_whole = line == "M02*"
        elif not self._define(line):
            raise ExportError(f"{self.path}: line {number}: {line[:40]!r}: no command of a mask")

    def finish(self) -> None:
        """Refuse a file that lacks unit, format, outline or end."""
        if len(self.stated) != 2 or not self.is_whole or len(self.line) != 5:
            raise ExportError(f"{self.path}: not a readable mask: unit, format, outline or end")

    def _define(self, line: str) -> bool:
        if found := _RECTANGLE.fullmatch(line):
            self.size[int(found[1])] = (_steps(found[2]), _steps(found[3]))
        elif found := _CIRCLE.fullmatch(line):
            self.size[int(found[1])] = (_steps(found[2]), _steps(found[2]))
        elif found := _LAYER.fullmatch(line):
            self.layer = _NUMBERS.get(found[1], 0)
            return self.layer != 0
        elif found := _REPEAT.fullmatch(line):
            self.repeat = (int(found[1]), int(found[2]), _steps(found[3]), _steps(found[4]))
        elif line == "%SR*%":
            self.repeat = (1, 1, 0, 0)
        else:
            return False
        return True

    def _operate(self, x: int, y: int, operation: int) -> None:
        if operation == 3:
            width, length = self.size[self.code]
            if width % 2 or length % 2:
                self.snap_error = GRID / 2
            columns, rows, dx, dy = self.repeat
            place = Placement((x - width // 2, y - length // 2), columns, rows, (dx, 0), (0, dy))
            if self.layer == APERTURE and self.dark == bool(self.polygons[APERTURE]):
                raise ExportError(f"{self.path}: an aperture that is painted with wrong polarity")
            self.flashes[self.layer].append(ApertureArray((width, length), place))
        elif self.contour is not None:
            self.contour.append((x, y))
        elif self.layer == OUTLINE:
            self.line.append((x, y))
        else:
            raise ExportError(f"{self.path}: a line that is not the outline's")

    def _region(self, *, begins: bool) -> None:
        if begins:
            self.contour = []
            return
        x, y = zip(*(self.contour or ()), strict=True)
        if self.layer not in (APERTURE, FIDUCIAL, TEXT, COUPON):
            raise ExportError(f"{self.path}: a region on layer {self.layer}")
        self.polygons[self.layer].append((min(x), min(y), max(x), max(y)))
        self.contour = None


def _steps(text: str) -> int:
    """Return a length in mm as grid steps."""
    return round(float(text) / GRID)
