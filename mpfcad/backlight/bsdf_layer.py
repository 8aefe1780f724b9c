"""A layer of a stack, or its reflector, that is a BSDF table read from files."""

import hashlib
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.optics.bsdf.file import read_bsdf
from mpfcad.optics.bsdf.table import BsdfTable

_INTERPOLATION = {"linear": 1.0, "none": 0.0}
_KEYS = {"kind", "name", "file", "reciprocal", "interpolation", "tag", "source"}
_TAGS = ("given", "sourced", "assumed")


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
        what the stack file says of it, and the text of each file
    """

    name: str
    table: BsdfTable
    blend: float
    tag: str
    source: str
    entry: Mapping[str, object]
    text: Mapping[str, str]

    @property
    def sha256(self) -> str:
        """Hash of the files' text, one behind the other."""
        return hashlib.sha256("".join(self.text.values()).encode()).hexdigest()

    def describe_source(self) -> dict[str, object]:
        """Return {value, tag, source} as of a number: the file, its hash, what was filled in."""
        source = "; ".join((f"{self.source}, SHA-256 {self.sha256}", *self.table.note))
        return {"value": self.name, "tag": self.tag, "source": source}

    def describe(self) -> dict[str, object]:
        """Return the layer as plain values; `restore_bsdf_layer` makes it again of them."""
        return {"entry": dict(self.entry), "text": dict(self.text)}


def restore_bsdf_layer(document: Mapping[str, Mapping]) -> BsdfLayer:
    """Return the layer that was described."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in document["text"].items():
            (Path(folder) / Path(name).name).write_bytes(text.encode())
        return read_bsdf_layer("stack", Path(folder), dict(document["entry"]))


def read_bsdf_layer(where: str, folder: Path, entry: dict[str, object]) -> BsdfLayer:
    """Return the layer of `{ kind = "bsdf", file = … }`, its files beside the stack's.

    `file` is one name or, for `.bsdf`, several; `reciprocal` claims that the element is;
    `interpolation` is linear or none; `tag` and `source` as of a value.

    Raises
    ------
    InputError
        when a key, a value or a file is wrong.
    """
    unknown = sorted(set(entry) - _KEYS)
    if unknown:
        raise InputError(f"{where}: {unknown[0]}: unknown key; allowed: {', '.join(sorted(_KEYS))}")
    if entry.get("kind", "bsdf") != "bsdf":
        raise InputError(f"{where}: kind: {entry['kind']}: must be bsdf")
    names = entry.get("file")
    names = [names] if isinstance(names, str) else names
    if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
        raise InputError(f"{where}: file: {entry.get('file')}: must be a file name, or several")
    reciprocal, way = entry.get("reciprocal", False), entry.get("interpolation", "linear")
    if not isinstance(reciprocal, bool):
        raise InputError(f"{where}: reciprocal: {reciprocal}: must be true or false")
    if way not in _INTERPOLATION:
        raise InputError(f"{where}: interpolation: {way}: must be linear or none")
    tag = entry.get("tag", "given")
    if tag not in _TAGS:
        raise InputError(f"{where}: tag {tag!r}: must be one of {', '.join(_TAGS)}")
    paths = [folder / name for name in names]
    table = read_bsdf(paths, reciprocal=reciprocal)
    source = str(entry.get("source", "given by the user"))
    # By their last names, so that a table restored elsewhere has the same entry.
    kept = {**entry, "file": [path.name for path in paths]}
    text = {path.name: path.read_bytes().decode() for path in paths}
    return BsdfLayer(paths[0].name, table, _INTERPOLATION[way], tag, source, kept, text)
