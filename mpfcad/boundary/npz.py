"""Arrays from an NPZ file: named ones, of a size that the file really has."""

import math
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary.file import check_file, guarded
from mpfcad.errors import InputError

#: Largest array [bytes]: a panel's map at a tenth of a groove pitch is below a gigabyte.
_LIMIT = 4_000_000_000
_EXPECTED = "an NPZ file of plain number arrays"


def read_arrays(path: Path, names: Sequence[str]) -> list[NDArray[Any]]:
    """Return the arrays of these names from an NPZ file.

    Each array's stated shape is compared with the size of its entry before it is read, so that a
    file of a few kilobytes cannot ask for more memory than the machine has.

    Raises
    ------
    InputError
        naming the file and the array that is missing, has no numbers, or is too large.
    """
    check_file(path, expected=_EXPECTED)
    with guarded(path, _EXPECTED):
        if not zipfile.is_zipfile(path):
            raise InputError(f"{path}: not an NPZ file of plain number arrays")
        with zipfile.ZipFile(path) as archive:
            there = [name.removesuffix(".npy") for name in archive.namelist()]
            missing = [name for name in names if name not in there]
            if missing:
                found = ", ".join(there)[:80] or "none"
                raise InputError(
                    f"{path}: array {missing[0]} missing among {found}: expected {', '.join(names)}"
                )
            return [_array(path, archive, name) for name in names]


def has_array(path: Path, name: str) -> bool:
    """Return whether a file is an NPZ file with an array of a name."""
    try:
        check_file(path)
        with zipfile.ZipFile(path) as archive:
            return f"{name}.npy" in archive.namelist()
    except (InputError, OSError, ValueError, zipfile.BadZipFile, NotImplementedError):
        return False


def _array(path: Path, archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    entry = archive.getinfo(f"{name}.npy")
    where = f"{path}: array {name}"
    if entry.file_size > _LIMIT:
        most = f"expected at most {_LIMIT / 1e9:.0f} GB"
        raise InputError(f"{where}: {entry.file_size / 1e9:.1f} GB: {most}")
    with guarded(where, "numbers as numpy writes them"), archive.open(entry) as file:
        version = np.lib.format.read_magic(file)
        readers = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        if version not in readers:
            raise InputError(f"{where}: NPY version {version}: expected 1.0 or 2.0")
        shape, fortran, dtype = readers[version](file)
        if dtype.kind not in "iuf":
            raise InputError(f"{where}: {dtype} of shape {shape}: expected numbers")
        count = math.prod(shape)
        size = count * dtype.itemsize
        if min(shape, default=0) < 0 or size > entry.file_size:
            words = f"shape {shape}: {size} bytes in an entry of {entry.file_size}"
            raise InputError(f"{where}: {words[:120]}: expected as many as it states")
        values = np.frombuffer(file.read(size), dtype, count)
        return values.reshape(shape, order="F" if fortran else "C").copy()
