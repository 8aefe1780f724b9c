"""manifest.json: size and SHA-256 of every file of an export, and a hash of itself."""

import hashlib
import json
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

from mpfcad.errors import ExportError, InputError
from mpfcad.export.text import canonical_json, encoded, sha256, write_text

MANIFEST = "manifest.json"
#: Beside the files of the manifest: its signature, where it is signed.
SIGNATURE = f"{MANIFEST}.sig"
_KEYS = {"schema", "name", "kind", "files", "self_sha256"}
#: A manifest of a few dozen files has a few kilobytes.
_MOST_BYTES = 10_000_000


def write_manifest(folder: Path, name: str, kind: str) -> None:
    """Write manifest.json: size and SHA-256 of every other file, and a hash of itself."""
    files = {
        path.name: {"sha256": sha256(path), "bytes": path.stat().st_size}
        for path in sorted(folder.iterdir())
        if path.name not in (MANIFEST, SIGNATURE)
    }
    manifest = {"schema": 1, "name": name, "kind": kind, "files": files}
    write_text(folder / MANIFEST, canonical_json(_sealed(manifest)))


def check_manifest(folder: Path) -> dict[str, Any]:
    """Return the manifest of `folder` after hashing every file in it.

    Raises
    ------
    InputError
        when there is no manifest.
    ExportError
        naming the first file that is changed, missing, a link or not of the export.
    """
    path = folder / MANIFEST
    if not path.is_file():
        raise InputError(f"{path}: no such file: {folder} is no export of mpfcad")
    manifest = read_sealed(path)
    for name, entry in manifest["files"].items():
        file = folder / name
        if file.is_symlink():
            raise ExportError(f"{file}: is a link: expected the file itself")
        if not file.is_file():
            raise ExportError(f"{file}: missing")
        digest = sha256(file)
        if digest != entry["sha256"] or file.stat().st_size != entry["bytes"]:
            raise ExportError(f"{file}: changed: SHA-256 is {digest}, not {entry['sha256']}")
    for file in sorted(folder.iterdir()):
        if file.name not in (MANIFEST, SIGNATURE) and file.name not in manifest["files"]:
            raise ExportError(f"{file}: not in the manifest")
    return manifest


def kind_of(folder: Path) -> str | None:
    """Return the kind that a folder's manifest states, or None."""
    kind = _read(folder / MANIFEST).get("kind")
    return kind if isinstance(kind, str) else None


def read_entries(path: Path) -> tuple[dict[str, Any], bool]:
    """Return the files that a manifest states, and whether it is as it was written.

    Of one that was edited, the entries that make sense.
    """
    with suppress(ExportError):
        return read_sealed(path)["files"], True
    files = _read(path).get("files")
    entries = files.items() if isinstance(files, dict) else ()
    return {name: entry for name, entry in entries if not _trouble(name, entry)}, False


def is_own(file: Path, files: dict[str, Any]) -> bool:
    """Tell whether a file is as its manifest states: made by mpfcad, and not edited since."""
    entry = files.get(file.name)
    if entry is None or file.is_symlink() or not file.is_file():
        return False
    return file.stat().st_size == entry["bytes"] and sha256(file) == entry["sha256"]


def _sealed(manifest: dict[str, Any]) -> dict[str, Any]:
    body = {key: value for key, value in manifest.items() if key != "self_sha256"}
    return {**body, "self_sha256": hashlib.sha256(encoded(canonical_json(body))).hexdigest()}


def _read(path: Path) -> dict[str, Any]:
    try:
        if path.is_symlink() or path.stat().st_size > _MOST_BYTES:
            return {}
        manifest = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return manifest if isinstance(manifest, dict) else {}


def read_sealed(path: Path) -> dict[str, Any]:
    """Return a manifest whose bytes are exactly those that `write_manifest` writes.

    Raises
    ------
    ExportError
        when they are not, or when an entry is none that it writes.
    """
    manifest = _read(path)
    try:
        intact = encoded(canonical_json(_sealed(manifest))) == path.read_bytes()
    except (OSError, ValueError, TypeError, RecursionError):
        intact = False
    if not intact:
        raise ExportError(f"{path}: changed: it does not match its own self_sha256")
    if set(manifest) != _KEYS or not isinstance(manifest["files"], dict):
        raise ExportError(f"{path}: its keys: expected {', '.join(sorted(_KEYS))}")
    for name, entry in manifest["files"].items():
        trouble = _trouble(name, entry)
        if trouble:
            raise ExportError(f"{path}: files: {name[:60]!r}: {trouble}")
    return manifest


def _trouble(name: str, entry: Any) -> str | None:
    if name in ("", ".", "..", MANIFEST, SIGNATURE) or re.search(r"[/\\:\x00]", name):
        return "expected the name of a file in the folder itself"
    if not isinstance(entry, dict) or set(entry) != {"sha256", "bytes"}:
        return "expected sha256 and bytes"
    if not re.fullmatch(r"[0-9a-f]{64}", str(entry["sha256"])) or type(entry["bytes"]) is not int:
        return "expected 64 hex digits and a whole number"
    return None
