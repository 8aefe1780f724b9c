"""A stack as plain values, as an export keeps it, and made again of them."""

from dataclasses import asdict
from typing import Any

from mpfcad.backlight.layer.bsdf import restore_bsdf_layer
from mpfcad.backlight.layer.stated import Layer
from mpfcad.backlight.light import describe_bands, restore_bands
from mpfcad.backlight.quantity import Quantity
from mpfcad.backlight.source import restore_spec
from mpfcad.backlight.stack import Stack, stack_file


def describe_stack(stack: Stack) -> dict[str, Any]:
    """Return a stack as plain values; `restore_stack` makes the same stack of them again."""
    source = stack.spec.describe()
    return {
        "name": stack.name,
        "title": stack.title,
        **({"source": source} if source else {}),
        **({"polarised": True} if stack.polarised else {}),
        **({} if stack.bands is None else {"bands": describe_bands(stack.bands)}),
        "layers": list(stack.layers),
        "quantity": {name: asdict(entry) for name, entry in stack.quantity.items()},
        "tables": {name: table.describe() for name, table in stack.tables.items()},
        "extent": stack.extent,
        "own": {
            name: {**asdict(layer), "file": stack_file(name) if layer.file else None}
            for name, layer in stack.own.items()
        },
    }


def restore_stack(document: dict[str, Any]) -> Stack:
    """Return the stack that `describe_stack` has described; its meshes are in the export."""
    quantity = {name: Quantity(**entry) for name, entry in document["quantity"].items()}
    own = {name: Layer(**entry) for name, entry in document["own"].items()}
    tables = {name: restore_bsdf_layer(entry) for name, entry in document["tables"].items()}
    return Stack(
        document["name"], document["title"], tuple(document["layers"]), quantity,
        document["extent"], own, tables, spec=restore_spec(document.get("source", {})),
        polarised=document.get("polarised", False), bands=restore_bands(document.get("bands")),
    )  # fmt: skip
