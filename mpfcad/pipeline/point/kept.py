"""Results of traced points on disk: a file each, named by a hash of all that it depends on."""

import hashlib
import json
from pathlib import Path
from typing import Any

from mpfcad.export import canonical_json, write_text
from mpfcad.pipeline.point.trace import Point
from mpfcad.pipeline.run.record import versions


def point_file(point: Point, folder: Path) -> Path:
    """Return the file of a point's result in a folder."""
    text = canonical_json(versions()) + point.inputs()
    return folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"


def find_kept(file: Path) -> dict[str, Any] | None:
    """Return the result in a file, if it is there."""
    return json.loads(file.read_bytes()) if file.is_file() else None


def keep_result(file: Path, result: dict[str, Any]) -> dict[str, Any]:
    """Write a result, and return it as it will be read: a fresh one and a kept one are the same."""
    text = canonical_json(result)
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f".{file.name}.part")
    write_text(part, text)
    part.replace(file)
    return json.loads(text)
