"""A stack as the tables of a file of its own, which reads as the same stack."""

from typing import Any

from mpfcad.backlight.quantity import Quantity
from mpfcad.backlight.source import TubeSpec
from mpfcad.backlight.stack import Stack
from mpfcad.errors import InputError


def quantity_table(entry: Quantity) -> dict[str, Any]:
    """Return a value as it stands in a stack's file, fit for TOML."""
    width = {} if entry.sigma is None else {"sigma": entry.sigma}
    return {"value": entry.value, **width, "tag": entry.tag, "source": entry.source}


def stack_tables(stack: Stack) -> dict[str, Any]:
    """Return title, layers, extent and values of a stack, fit for TOML; `read_stack` reads them.

    Raises
    ------
    InputError
        when it has layers with values or files of their own, particles, bands, or no tubes.
    """
    particles = any("particle" in name for name in stack.quantity)
    named = not (stack.own or stack.tables or particles or stack.bands)
    if not named or stack.spec.kind != TubeSpec.kind:
        raise InputError(
            f"{stack.name}: layers with values of their own, BSDF tables, particles, bands or "
            "LEDs: expected a backlight of named layers over tubes"
        )
    value = {name: quantity_table(entry) for name, entry in stack.quantity.items()}
    light = {"light": {"polarised": True}} if stack.polarised else {}
    return {
        "title": stack.title, **light, "layers": list(stack.layers), "extent": stack.extent,
        "value": value,
    }  # fmt: skip
