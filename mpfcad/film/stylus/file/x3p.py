"""ISO 5436-2 `.x3p`: profiles and maps of instruments, in metres, as binary data or as a list.

A zip archive of `main.xml` and, with a link, `bindata/data.bin`. X runs fastest. An incremental
axis has a step and no values of its own; whole numbers are counts of the height's step.
"""

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import TEXT_LIMIT
from mpfcad.errors import InputError
from mpfcad.film.stylus.file.areal import ArealMap, cut_profile
from mpfcad.film.stylus.file.profile import RawProfile

_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}


def read_x3p(path: Path) -> RawProfile:
    """Return the profile in an x3p file [m]; of a map, the one across its grooves.

    Raises
    ------
    InputError
        naming the element that is missing or not as the standard says.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            place = _main(path, archive)
            root = ElementTree.fromstring(_member(path, archive, place))
            for element in root.iter():
                element.tag = element.tag.rpartition("}")[2]
            link = root.findtext(".//DataLink/PointDataLink", "").strip()
            folder = place.rpartition("/")[0]
            name = f"{folder}/{link}".lstrip("/") if link else ""
            data = _member(path, archive, name) if link else None
            link = root.findtext(".//DataLink/ValidPointsLink", "").strip()
            name = f"{folder}/{link}".lstrip("/") if link else ""
            bits = _member(path, archive, name) if link else None
    except (zipfile.BadZipFile, ElementTree.ParseError, NotImplementedError) as error:
        raise InputError(f"{path}: {error}: expected an ISO 5436-2 x3p archive") from None
    except KeyError:
        raise InputError(
            f"{path}: {name}: not in the archive: expected what main.xml names"
        ) from None
    return _profile(path, root, data, bits)


def _main(path: Path, archive: zipfile.ZipFile) -> str:
    names = [n for n in archive.namelist() if n.rpartition("/")[2] == "main.xml"]
    names = [n for n in names if not n.startswith("__MACOSX")]
    if len(names) != 1:
        raise InputError(f"{path}: {len(names)} files main.xml in it: expected one")
    return names[0]


def _member(path: Path, archive: zipfile.ZipFile, name: str) -> bytes:
    size = archive.getinfo(name).file_size
    if size > TEXT_LIMIT:
        raise InputError(
            f"{path}: {name}: {size / 1e6:.0f} MB: expected at most {TEXT_LIMIT / 1e6:.0f} MB"
        )
    return archive.read(name)


def _profile(
    path: Path, root: ElementTree.Element, data: bytes | None, bits: bytes | None
) -> RawProfile:
    """Return what the archive's parts hold; `bits`, lowest first, tell which heights are valid."""
    feature = root.findtext(".//FeatureType", "").strip()
    if feature not in ("PRF", "SUR"):
        raise InputError(f"{path}: FeatureType: {feature or 'missing'}: expected PRF or SUR")
    size = [_whole(path, root, f"Size{axis}") for axis in "XYZ"]
    if root.find(".//MatrixDimension") is None:
        size = [_whole(path, root, "ListDimension"), 1, 1]
    if size[2] != 1:
        raise InputError(f"{path}: SizeZ: {size[2]}: expected 1 height a place")
    absolute = [axis for axis in "XY"[: 1 if feature == "PRF" else 2] if _axis(root, axis) == "A"]
    count = size[0] * size[1]
    found = _listed(path, root) if data is None else _binary(path, root, data, absolute, count)
    if found.shape[0] != count:
        raise InputError(
            f"{path}: {found.shape[0]} heights: expected {count}, {size[0]} × {size[1]}"
        )
    height = found[:, -1] * (
        _number(path, root, "Z", "Increment") if _type(root, "Z") in ("I", "L") else 1.0
    )
    height[~np.isfinite(height)] = np.nan
    if bits is not None:
        known = np.unpackbits(np.frombuffer(bits, np.uint8), bitorder="little")[:count]
        if len(known) != count:
            raise InputError(f"{path}: valid points: {len(known)}: expected {count}")
        height[known == 0] = np.nan
    if not np.isfinite(height).any():
        raise InputError(f"{path}: no height in it is valid: expected a measured surface")
    words = [f"x3p, {feature}"]
    if "X" in absolute and size[1] == 1 and feature == "PRF":
        return RawProfile(found[:, 0], height, "m", "m", None, words)
    if absolute:
        raise InputError(
            f"{path}: C{absolute[0]}: AxisType A, positions of their own: expected I, even steps, "
            "of a map"
        )
    step = _number(path, root, "X", "Increment")
    if size[1] == 1:
        return RawProfile(step * np.arange(count, dtype=np.float64), height, "m", "m", None, words)
    rows = height.reshape(size[1], size[0])
    area = ArealMap(rows, step, _number(path, root, "Y", "Increment"), "m", "m")
    position, mean, cut = cut_profile(path, area)
    return RawProfile(position, mean, "m", "m", None, [*words, cut])


def _listed(path: Path, root: ElementTree.Element) -> NDArray[np.float64]:
    """Return the rows of the list, (n, k) float64; NaN where nothing was measured."""
    rows = [(datum.text or "").split(";") for datum in root.iter("Datum")]
    wide = max((len(row) for row in rows), default=0)
    try:
        return np.array([
            [float(word) for word in row] if any(word.strip() for word in row) else [np.nan] * wide
            for row in rows
        ])  # fmt: skip
    except ValueError as error:
        raise InputError(f"{path}: Datum: {error}: expected rows of {wide} numbers") from None


def _binary(
    path: Path, root: ElementTree.Element, data: bytes, absolute: list[str], count: int
) -> NDArray[np.float64]:
    """Return the rows of the binary data, (n, k) float64: absolute axes, then the height."""
    kind = np.dtype([(axis, _TYPES[_type(root, axis)]) for axis in [*absolute, "Z"]])
    if len(data) != count * kind.itemsize:
        raise InputError(
            f"{path}: data: {len(data)} bytes: expected {count * kind.itemsize}, {count} heights"
        )
    table = np.frombuffer(data, kind)
    columns = [table[name].astype(np.float64) for name in kind.names or ()]
    rows: NDArray[np.float64] = np.column_stack(columns)
    return rows


def _axis(root: ElementTree.Element, axis: str) -> str:
    return root.findtext(f".//C{axis}/AxisType", "I").strip().upper()


def _type(root: ElementTree.Element, axis: str) -> str:
    return root.findtext(f".//C{axis}/DataType", "D").strip().upper()


def _number(path: Path, root: ElementTree.Element, axis: str, name: str) -> float:
    word = root.findtext(f".//C{axis}/{name}", "").strip()
    try:
        value = float(word)
        if not (np.isfinite(value) and value > 0):
            raise ValueError
    except ValueError:
        raise InputError(
            f"{path}: C{axis}: {name}: {word or 'missing'}: expected a number above 0"
        ) from None
    return value


def _whole(path: Path, root: ElementTree.Element, name: str) -> int:
    word = root.findtext(f".//{name}", "1").strip()
    if not word.isdigit() or not 0 < int(word) < TEXT_LIMIT:
        raise InputError(f"{path}: {name}: {word}: expected a whole number from 1 up")
    return int(word)
