"""Text and hashes of files: the same bytes on every system."""

import hashlib
import json
from pathlib import Path
from typing import Any


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file as 64 hex digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def canonical_json(value: Any) -> str:
    """Return `value` as JSON with a fixed layout; floats round-trip exactly, NaN is refused."""
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def encoded(text: str) -> bytes:
    r"""Return text as UTF-8; a byte of a file's name that is none stands as `\udcXX`.

    Within JSON that is the escape of the same character, so it is read back as it was.
    """
    return text.encode("utf-8", "backslashreplace")


def write_text(path: Path, text: str) -> None:
    """Write `text` as UTF-8 with bare line feeds on every system."""
    path.write_bytes(encoded(text))
