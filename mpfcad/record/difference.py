"""Where two documents of plain values differ."""

from typing import Any


def find_difference(stored: Any, found: Any, where: str = "") -> str | None:
    """Return the first place where two documents differ, as `key.key: stored, found`, or None."""
    if isinstance(stored, dict) and isinstance(found, dict):
        for key in [*stored, *(key for key in found if key not in stored)]:
            place = f"{where}.{key}" if where else key
            if key not in stored or key not in found:
                return f"{place}: only in the {'file' if key in stored else 'new result'}"
            difference = find_difference(stored[key], found[key], place)
            if difference:
                return difference
        return None
    if isinstance(stored, list) and isinstance(found, list) and len(stored) == len(found):
        pairs = enumerate(zip(stored, found, strict=True))
        hits = (find_difference(a, b, f"{where}[{i}]") for i, (a, b) in pairs)
        return next((hit for hit in hits if hit), None)
    return None if stored == found else f"{where}: stored {stored!r}, found {found!r}"
