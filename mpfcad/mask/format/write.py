"""A mask to a file: one writer a suffix; the file takes its name only when it is whole."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from mpfcad.boundary.out import whole_file
from mpfcad.errors import ExportError, InputError
from mpfcad.mask.aperture import Mask
from mpfcad.mask.format.drawing import Drawing, draw
from mpfcad.mask.format.dxf import write_dxf
from mpfcad.mask.format.gdsii import write_gdsii
from mpfcad.mask.format.gerber import write_gerber
from mpfcad.mask.format.oasis import write_oasis
from mpfcad.mask.format.svg import write_svg
from mpfcad.mask.format.tiff import write_tiff
from mpfcad.mask.phototool import Phototool
from mpfcad.mask.told import Told, untold

#: A file in which places stand one by one must not get larger than this [bytes].
LARGEST_FILE = 256 * 1024**2


@dataclass(frozen=True)
class Format:
    """How a format is written.

    Attributes
    ----------
    title
        its name
    write
        writes a drawing to a path
    paints
        whether open can be drawn on closed
    place_size
        bytes that a place takes which is not part of a lattice
    closes
        whether polarity `closed` is offered
    tells
        whether `write` takes somebody who is told how far it is
    """

    title: str
    write: Callable[..., None]
    paints: bool
    place_size: float
    closes: bool = True
    tells: bool = False


#: Suffix -> format.
FORMATS = {
    "oas": Format("OASIS", write_oasis, False, 2),
    "gds": Format("GDSII", write_gdsii, False, 56),
    "dxf": Format("DXF R2000", write_dxf, False, 120, closes=False),
    "gbr": Format("Gerber RS-274X", write_gerber, True, 24),
    "svg": Format("SVG", write_svg, True, 40),
    "tif": Format("TIFF", write_tiff, True, 24, tells=True),
}


def write_mask(
    mask: Mask, path: Path, phototool: Phototool | None = None, told: Told = untold
) -> None:
    """Write the mask to `path`; its suffix says in which format.

    `told` gets the share of a picture that is written, as it grows.

    Raises
    ------
    InputError
        for another suffix, or a mask that the format cannot hold.
    ExportError
        when the disk does not take the file; there is then none of that name.
    """
    path = Path(path)
    style = FORMATS.get(path.suffix.removeprefix("."))
    if style is None:
        known = ", ".join(f".{suffix}" for suffix in FORMATS)
        raise InputError(f"{path}: mask format {path.suffix!r}: expected {known}")
    if not style.closes and phototool is not None and phototool.polarity == "closed":
        raise InputError(f"{path}: mask.polarity: closed: expected oas, gds, gbr, svg, tif")
    drawing = draw(mask, phototool or Phototool(), paints=style.paints)
    if _listed_size(style, drawing) > LARGEST_FILE:
        refuse_large(mask, [path.suffix[1:]], drawing.phototool, path.name)
    try:
        with whole_file(path) as part:
            style.write(drawing, part, *((told,) if style.tells else ()))
    except OSError as error:
        raise ExportError(f"{path}: cannot be written: {error.strerror or error}") from None


def refuse_large(mask: Mask, suffixes: Iterable[str], phototool: Phototool, where: str) -> None:
    """Refuse formats whose files would list so many apertures that they get absurdly large.

    Raises
    ------
    InputError
        naming the first format, and those that hold the mask.
    """
    drawings: dict[bool, Drawing] = {}

    def size(style: Format) -> float:
        if style.paints not in drawings:
            drawings[style.paints] = draw(mask, phototool, paints=style.paints)
        return _listed_size(style, drawings[style.paints])

    for suffix in suffixes:
        listed = size(FORMATS[suffix])
        if listed > LARGEST_FILE:
            able = ", ".join(n for n, style in FORMATS.items() if size(style) <= LARGEST_FILE)
            raise InputError(
                f"{where}: mask.formats: {suffix} lists apertures one by one, here in "
                f"{listed / 1024**2:.0f} MiB: expected at most {LARGEST_FILE / 1024**2:.0f}: "
                f"formats of {able or 'none: a longer mask.period_um'}"
            )


def _listed_size(style: Format, drawing: Drawing) -> float:
    """Return the bytes of the places that a file lists one by one."""
    arrays = (*drawing.tiles, *(() if style.title == "OASIS" else drawing.arrays))
    places = (array.place.count if array.place.offset is not None else 1 for array in arrays)
    return style.place_size * sum(places)
