"""The text of a BSDF file as instruments and programs write it, and the root of an XML file."""

import codecs
from pathlib import Path
from xml.etree import ElementTree

from mpfcad.errors import InputError

_BOMS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"),
         (codecs.BOM_UTF16_BE, "utf-16"))  # fmt: skip


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a file.

    Raises
    ------
    InputError
        when it cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None


def read_text(path: Path) -> tuple[str, tuple[str, ...]]:
    """Return a file's text and notes; text that is no Unicode is taken as Windows-1252.

    Raises
    ------
    InputError
        when it cannot be read, or holds bytes that no text has.
    """
    data = read_bytes(path)
    encoding = next((name for bom, name in _BOMS if data.startswith(bom)), "utf-8")
    if encoding != "utf-16" and b"\0" in data:
        raise InputError(f"{path}: holds binary data: expected a text file")
    try:
        return data.decode(encoding), ()
    except UnicodeDecodeError:
        return data.decode("cp1252", "replace"), ("text that is no UTF-8 read as Windows-1252",)


def read_xml(path: Path) -> tuple[ElementTree.Element, tuple[str, ...]]:
    """Return the root of an XML file, its tags without namespace, and notes.

    Text before the XML, as genBSDF writes its way to recover there, is left out and noted.

    Raises
    ------
    InputError
        when the file is no XML.
    """
    data = read_bytes(path)
    notes: tuple[str, ...] = ()
    if not data.startswith(tuple(bom for bom, _ in _BOMS)):
        start = data.find(b"<?xml")
        start = data.find(b"<") if start < 0 else start
        before = data[: max(start, 0)].decode("utf-8", "replace").strip()
        if before:
            data = data[start:]
            notes = (f"text before the XML left out: {before.splitlines()[0][:60]!r}",)
    try:
        root = ElementTree.fromstring(data)
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise InputError(f"{path}: cannot be read as XML: {error}") from None
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    return root, notes
