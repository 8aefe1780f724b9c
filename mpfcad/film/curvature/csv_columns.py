"""Columns of numbers from a CSV file with a fixed header; every refusal names file and row."""

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError


def read_columns(path: Path, names: tuple[str, ...]) -> tuple[NDArray[np.float64], list[int]]:
    """Return the columns, (n, len(names)) float64, and the line of the file of each row.

    Numbers may be infinite or NaN: what is expected is the caller's to say.

    Raises
    ------
    InputError
        when the file cannot be read, its header is not `names`, or a field is no number.
    """
    lines: list[int] = []
    values: list[list[float]] = []
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(file)
            header = next(reader, [])
            if tuple(header) != names:
                raise InputError(
                    f"{path}: row 1: header {','.join(header)!r}: expected {','.join(names)!r}"
                )
            for fields in reader:
                if fields:
                    lines.append(reader.line_num)
                    values.append(_parse_row(path, reader.line_num, fields, names))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a text file ({error}): expected CSV in UTF-8") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    return np.array(values, dtype=float).reshape(-1, len(names)), lines


def _parse_row(path: Path, line: int, fields: list[str], names: tuple[str, ...]) -> list[float]:
    if len(fields) != len(names):
        text = ",".join(fields)
        raise InputError(
            f"{path}: row {line}: {text!r}: {len(fields)} fields: expected {len(names)}"
        )
    numbers = []
    for name, text in zip(names, fields, strict=True):
        try:
            numbers.append(float(text.replace("_", "?")))  # Python alone reads 1_000 as a number
        except ValueError:
            raise InputError(f"{path}: row {line}: {name} {text!r}: expected a number") from None
    return numbers
