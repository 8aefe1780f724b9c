"""A layer of a stack, or its reflector, that is a BSDF table read from files."""

import hashlib
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.file import read_bsdf
from mpfcad.optics.bsdf.missing import LOSSLESS, REFLECTOR, WHOLE, Taken
from mpfcad.optics.bsdf.table import BsdfTable

_INTERPOLATION = {"linear": 1.0, "none": 0.0}
_FLAGS = ("reciprocal", "symmetric", "normalise")
_STATED = ("reflection", "transmission")
_KEYS = {
    "kind", "name", "file", "interpolation", "rotation", "tag", "source", *_FLAGS, *_STATED,
}  # fmt: skip
_TAGS = ("given", "sourced", "assumed")


#: A file's text; where it is no UTF-8 its bytes as Latin-1, {"latin-1": text}.
Text = str | Mapping[str, str]


@dataclass(frozen=True, eq=False)
class BsdfLayer:
    """A table with where it comes from.

    Attributes
    ----------
    name
        the file's name, or the first's
    table
        checked on reading
    blend
        0: a table of steps; 1: linear between the bins' middles
    tag, source
        as of a quantity
    entry, text
        what the stack file says of it, and the text of each file (no UTF-8: {"latin-1": text})
    reflector
        whether it is the stack's reflector, which needs reflection from above only
    """

    name: str
    table: BsdfTable
    blend: float
    tag: str
    source: str
    entry: Mapping[str, object]
    text: Mapping[str, Text]
    reflector: bool = False

    @property
    def sha256(self) -> str:
        """Hash of the files' bytes, one behind the other."""
        return hashlib.sha256(b"".join(map(_bytes, self.text.values()))).hexdigest()

    def describe_source(self) -> dict[str, object]:
        """Return {value, tag, source} as of a number: the file, its hash, what was filled in."""
        source = "; ".join((f"{self.source}, SHA-256 {self.sha256}", *self.table.note))
        return {"value": self.name, "tag": self.tag, "source": source}

    def describe(self) -> dict[str, object]:
        """Return the layer as plain values; `restore_bsdf_layer` makes it again of them."""
        said = {"entry": dict(self.entry), "text": dict(self.text)}
        return {**said, "reflector": True} if self.reflector else said


def _bytes(text: Text) -> bytes:
    return text.encode() if isinstance(text, str) else text["latin-1"].encode("latin-1")


def _text(data: bytes) -> Text:
    try:
        return data.decode()
    except UnicodeDecodeError:
        return {"latin-1": data.decode("latin-1")}


def restore_bsdf_layer(document: Mapping[str, Any]) -> BsdfLayer:
    """Return the layer that was described."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in document["text"].items():
            (Path(folder) / Path(name).name).write_bytes(_bytes(text))
        return read_bsdf_layer(
            "stack", Path(folder), dict(document["entry"]), document.get("reflector", False)
        )


def read_bsdf_layer(
    where: str, folder: Path, entry: dict[str, Any], reflector: bool = False
) -> BsdfLayer:
    """Return the layer of `{ kind = "bsdf", file = … }`, its files beside the stack's.

    `file` is one name or, for `.bsdf`, several; `reciprocal` claims that the element is;
    `symmetric`, `reflection` and `transmission` say what a missing side is; `normalise` accepts
    sums a few percent above 1; `rotation` says what Zemax sample rotations mean; `interpolation` is
    linear or none; `tag` and `source` as of a value.

    Raises
    ------
    InputError
        when a key, a value or a file is wrong, or a side is missing and nothing said of it.
    """
    unknown = sorted(set(entry) - _KEYS)
    if unknown:
        expected = ", ".join(sorted(_KEYS))
        raise InputError(f"{where}: {unknown[0]}: unknown key; expected {expected}")
    if entry.get("kind", "bsdf") != "bsdf":
        raise InputError(f"{where}: kind: {entry['kind']!r}: expected bsdf")
    names = entry.get("file")
    names = [names] if isinstance(names, str) else names
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise InputError(f"{where}: file: {entry.get('file')}: expected a file name, or several")
    way, tag = entry.get("interpolation", "linear"), entry.get("tag", "given")
    if not isinstance(way, str) or way not in _INTERPOLATION:
        raise InputError(f"{where}: interpolation: {way}: expected linear or none")
    if not isinstance(tag, str) or tag not in _TAGS:
        raise InputError(f"{where}: tag: {tag!r}: expected one of {', '.join(_TAGS)}")
    for key in _FLAGS:
        if not isinstance(entry.get(key, False), bool):
            raise InputError(f"{where}: {key}: {entry[key]!r}: expected true or false")
    rotation = entry.get("rotation")
    if rotation is not None and not isinstance(rotation, str):
        raise InputError(f"{where}: rotation: {rotation}: expected '+y counterclockwise'")
    paths = [folder / name for name in names]
    table = read_bsdf(
        paths,
        taken=_taken(where, entry),
        needed=REFLECTOR if reflector else WHOLE,
        normalise=entry.get("normalise", False),
        rotation=rotation,
    )
    source = str(entry.get("source", "given by the user"))
    # By their last names, so that a table restored elsewhere has the same entry.
    kept = {**entry, "file": [path.name for path in paths]}
    text = {path.name: _text(path.read_bytes()) for path in paths}
    blend = _INTERPOLATION[way]
    return BsdfLayer(paths[0].name, table, blend, tag, source, kept, text, reflector)


def _taken(where: str, entry: Mapping[str, Any]) -> Taken:
    """Return what a layer's entry says of what its file does not hold."""
    for key in _STATED:
        value = entry.get(key)
        number = isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1
        lossless = key == "reflection" and value == LOSSLESS
        if not (value is None or number or lossless):
            more = f", or {LOSSLESS}" if key == "reflection" else ""
            raise InputError(f"{where}: {key}: {value!r}: expected 0 … 1{more}")
    return Taken(
        entry.get("symmetric", False),
        entry.get("reflection"),
        entry.get("transmission"),
        entry.get("reciprocal", False),
    )
