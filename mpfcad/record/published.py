"""The published JSON schemas (draft 2020-12) of what the program writes, by name.

>>> sorted(SCHEMAS)
['manifest', 'measure', 'trace', 'verification', 'verify']
"""

import json
from importlib.resources import files
from typing import Any

#: Name -> what it describes.
SCHEMAS = {
    "verification": "verification.json of an export",
    "manifest": "manifest.json of an export",
    "measure": "measure.json",
    "trace": "what mpfcad trace --json prints",
    "verify": "what mpfcad verify --json prints",
}


def published_schema(name: str) -> dict[str, Any]:
    """Return the JSON schema of that name.

    >>> published_schema("verification")["title"]
    'verification.json'

    Raises
    ------
    KeyError
        when there is none of that name.
    """
    if name not in SCHEMAS:
        raise KeyError(f"{name}: expected one of {', '.join(SCHEMAS)}")
    text = files("mpfcad.record").joinpath("schema", f"{name}.schema.json").read_text("utf-8")
    schema: dict[str, Any] = json.loads(text)
    return schema
