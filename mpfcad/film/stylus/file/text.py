"""A text file of numbers, as an instrument wrote it: encoding, delimiter, decimal mark, header."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

_DELIMITERS = {";": "';'", "\t": "tab", "|": "'|'", ",": "','", None: "space"}
# `++` never goes back: a line of ten thousand digits would be tried at each of them.
_PLAIN = re.compile(r"[-+]?(?:\d++\.?\d*+|\.\d++)(?:[eEdD][-+]?\d++)?\Z")
_COMMA = re.compile(r"[-+]?(?:\d++,?\d*+|,\d++)(?:[eEdD][-+]?\d++)?\Z")
_NUMBERED = re.compile(r"[-+]?\d")
_MISSING = frozenset({"nan", "-nan", "nan(ind)", "bad", "***", "---", "--", "n/a", "na", "inf"})
#: Rows of one kind that begin a block of numbers.
_ROWS = 3
#: Columns from which a block is a map's; of several maps in a file the first is taken.
_MAP = 20


@dataclass(frozen=True, eq=False)
class NumberTable:
    """The block of numbers in a text file.

    Attributes
    ----------
    header
        lines above the block, without comment marks
    names
        of each column, joined from the header's lines of so many fields; "" where there are none
    values
        (rows, columns) float64; NaN where a field is missing
    lines
        the file's line of each row
    words
        how it was read: encoding (unless UTF-8), delimiter, decimal mark
    """

    header: list[str]
    names: list[str]
    values: NDArray[np.float64]
    lines: list[int]
    words: list[str]


def decode(path: Path) -> tuple[str, str]:
    """Return a file's text and its encoding.

    Raises
    ------
    InputError
        when it cannot be read or is no text.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    return decode_bytes(raw, path)


def decode_bytes(raw: bytes, path: Path) -> tuple[str, str]:
    """Return the text of a file's bytes and its encoding."""
    for mark, name in (
        (b"\xef\xbb\xbf", "utf-8"),
        (b"\xff\xfe", "utf-16"),
        (b"\xfe\xff", "utf-16"),
    ):
        if raw.startswith(mark):
            return _decoded(raw, "utf-8-sig" if name == "utf-8" else name, path), name
    unmarked = _unmarked_utf16(raw[:4000])
    if unmarked:
        return _decoded(raw, unmarked, path), unmarked
    if b"\0" in raw:
        raise InputError(f"{path}: not a text file: expected columns of numbers")
    try:
        return raw.decode("utf-8"), "utf-8"
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace"), "cp1252"


def is_binary(start: bytes) -> bool:
    """Return whether a file that begins so is no text: it holds zeros, and is no UTF-16."""
    marked = start.startswith((b"\xff\xfe", b"\xfe\xff"))
    return b"\0" in start and not marked and not _unmarked_utf16(start)


def _unmarked_utf16(head: bytes) -> str | None:
    """Return the encoding of UTF-16 without a mark: its zeros stand in every second place only."""
    even, odd = head[::2].count(0), head[1::2].count(0)
    if max(even, odd) <= len(head) // 4 or min(even, odd) > len(head) // 100:
        return None
    return "utf-16-le" if odd > even else "utf-16-be"


def _decoded(raw: bytes, encoding: str, path: Path) -> str:
    try:
        return raw.decode(encoding)
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file: {error}: expected {encoding}") from None


def read_table(path: Path) -> NumberTable:
    """Return the block of numbers in a text file.

    Raises
    ------
    InputError
        naming file, line and value when there is none, when a row differs from the others, or when
        commas may be read both as decimal marks and as delimiters.
    """
    text, encoding = decode(path)
    lines = [line.strip("\r\n\f ﻿") for line in text.splitlines()]
    best: tuple[int, int, _Dialect] | None = None
    for delimiter in _DELIMITERS:
        for comma in (False, True):
            if comma and delimiter == ",":
                continue
            dialect = _Dialect(delimiter, comma)
            start = dialect.start(lines)
            if start is None:
                continue
            score = dialect.score(lines[start:])
            if best is None or score > best[0]:
                best = (score, start, dialect)
    if best is None:
        first = next((line for line in lines if line.strip()), "")
        raise InputError(
            f"{path}: row 1: {first[:60]!r}: no rows of numbers in the file: expected two columns, "
            "position and height"
        )
    _, start, dialect = best
    table = _collect(path, lines, start, dialect)
    if dialect.delimiter == ",":
        table = _rejoin_decimals(path, table)
    words = [] if encoding == "utf-8" else [encoding]
    return NumberTable(table.header, table.names, table.values, table.lines, words + table.words)


@dataclass(frozen=True)
class _Dialect:
    """A delimiter (None: white space) and whether the decimal mark is a comma."""

    delimiter: str | None
    comma: bool

    def fields(self, line: str) -> list[str]:
        """Return a line's fields, without the empty ones at its end."""
        parts = line.split(self.delimiter)
        parts = [part.strip().strip('"') for part in parts]
        while parts and not parts[-1]:
            parts.pop()
        return parts

    def row(self, line: str) -> list[float] | None:
        """Return the numbers of a line, NaN where missing; None where it is no row of numbers."""
        pattern = _COMMA if self.comma else _PLAIN
        numbers: list[float] = []
        for field in self.fields(line):
            if pattern.match(field):
                text = field.replace(",", ".") if self.comma else field
                numbers.append(float(text.replace("d", "e").replace("D", "e")))
            elif not field or field.lower() in _MISSING:
                numbers.append(np.nan)
            else:
                return None
        return numbers if numbers and not all(np.isnan(numbers)) else None

    def start(self, lines: list[str]) -> int | None:
        """Return the index of the first line of the block: rows of as many fields follow it."""
        rows = [(i, self.row(line)) for i, line in enumerate(lines[:5000]) if _is_content(line)]
        for at, (i, first) in enumerate(rows):
            follow = [row for _, row in rows[at : at + _ROWS]]
            if first and all(row is not None and len(row) == len(first) for row in follow):
                return i
        return None

    def score(self, lines: list[str]) -> int:
        """Return how many of (up to 400) lines are rows; two columns or more count double."""
        rows = [self.row(line) for line in lines[:400]]
        return sum((2 if len(row) > 1 else 1) for row in rows if row)


def _is_content(line: str) -> bool:
    return bool(line.strip()) and not line.lstrip().startswith(("#", "//", "%"))


def _collect(path: Path, lines: list[str], start: int, dialect: _Dialect) -> NumberTable:
    """Return the rows from `start` on; text after the last of them is a footer."""
    rows: list[list[float]] = []
    numbers: list[int] = []
    wrong: tuple[int, str] | None = None
    width = len(dialect.row(lines[start]) or [])
    for i, line in enumerate(lines[start:], start):
        if not _is_content(line):
            continue
        row = dialect.row(line)
        if row is None and width > _MAP and len(rows) >= _ROWS:
            break
        if row is None:
            wrong = wrong or (i, line)
            continue
        if wrong or len(row) > width:
            at, text = wrong or (i, line)
            raise InputError(f"{path}: row {at + 1}: {text.strip()!r}: expected {width} numbers")
        rows.append(row + [np.nan] * (width - len(row)))
        numbers.append(i + 1)
    if wrong and (len(rows) < _ROWS or _begins_as_row(wrong[1], dialect)):
        at, text = wrong
        raise InputError(f"{path}: row {at + 1}: {text.strip()!r}: expected {width} numbers")
    header = [line.lstrip("#%/ ").rstrip() for line in lines[:start] if line.strip("#%/ \t")]
    mark = "decimal comma" if dialect.comma else "decimal point"
    words = [_DELIMITERS[dialect.delimiter], mark]
    names = _column_names(header, dialect, width)
    return NumberTable(header, names, np.array(rows), numbers, words)


def _begins_as_row(line: str, dialect: _Dialect) -> bool:
    """Return whether a line is a row with something wrong in it, and no footer."""
    fields = dialect.fields(line)
    return len(fields) > 1 and bool((_COMMA if dialect.comma else _PLAIN).match(fields[0]))


def _column_names(header: list[str], dialect: _Dialect, width: int) -> list[str]:
    """Return a name a column, from the header's last lines that have one field a column."""
    found: list[list[str]] = []
    for line in reversed(header):
        fields = dialect.fields(line)
        if len(fields) != width and dialect.delimiter is None:
            fields = re.split(r"\s{2,}|\t", line)
        if dialect.delimiter and len(fields) == width - 1 and line.startswith(dialect.delimiter):
            fields = ["", *fields]
        texts = [field for field in fields if field and not _PLAIN.match(field)]
        if not found and len(fields) == 1 and _PLAIN.match(fields[0]):
            continue  # the number of points, between the names and them
        # `key: value` and `key, 0.25 um` are no names.
        if any(field.endswith(":") for field in fields[:1]) or any(map(_NUMBERED.match, fields)):
            break
        if len(fields) != width or not texts or len(found) == 3:
            break
        found.insert(0, fields)
    return [" ".join(part for part in column if part) for column in zip(*found, strict=True)] or [
        ""
    ] * width


def _are_halves(fields: list[str]) -> bool:
    """Return whether fields may be numbers before and behind decimal commas: digits alone."""
    wholes = [field.strip().lstrip("+-") for field in fields[::2]]
    return len(fields) % 2 == 0 and all(map(str.isdecimal, [*wholes, *fields[1::2]]))


def _rejoin_decimals(path: Path, table: NumberTable) -> NumberTable:
    """Return a table whose commas were decimal marks *and* delimiters with its halves rejoined.

    `0,25,6,2521` is four whole numbers, or two with decimal commas: the header's names tell.
    """
    values = table.values
    whole = bool(np.all(np.isnan(values) | (values == np.round(values))))
    if values.shape[1] % 2 or not whole or any(table.names):
        return table
    text = decode(path)[0].splitlines()
    fields = [text[number - 1].strip().rstrip(",").split(",") for number in table.lines]
    if not all(_are_halves(row) for row in fields):
        return table
    header = table.header[-1] if table.header else ""
    count = len([name for name in header.split(",") if name.strip()])
    if 2 * count != values.shape[1]:
        if len(values) < 2 * _ROWS:
            return table
        raise InputError(
            f"{path}: row {table.lines[0]}: whole numbers between commas: reads as "
            f"{values.shape[1]} columns, or as {values.shape[1] // 2} with decimal commas: "
            "expected a header with one name a column, or ';' between columns"
        )
    rows = [[float(f"{a}.{b}") for a, b in zip(row[::2], row[1::2], strict=True)] for row in fields]
    names = [name.strip() for name in header.split(",") if name.strip()]
    return NumberTable(
        table.header, names, np.array(rows), table.lines, ["','", "decimal comma"]
    )  # fmt: skip
