"""The backlight around the film: lamps, reflector, plate, sheets, and the slot for the film.

A `Stack` is a list of layers from the lamps up and a table of numbers, each tagged `given`,
`sourced` or `assumed`. Presets live as TOML files in `preset/`; `read_stack` reads them and the
user's own.
"""

from mpfcad.backlight.layer.bsdf import BsdfLayer, restore_bsdf_layer
from mpfcad.backlight.layer.stated import LAYERS, Layer
from mpfcad.backlight.quantity import Quantity, ranges_with
from mpfcad.backlight.reader import is_stack_file, list_stacks, read_stack
from mpfcad.backlight.source import Emitters, LightSource, Period, restore_spec
from mpfcad.backlight.stack import PRISM_FILE, Stack, stack_file

__all__ = [
    "LAYERS",
    "PRISM_FILE",
    "BsdfLayer",
    "Emitters",
    "Layer",
    "LightSource",
    "Period",
    "Quantity",
    "Stack",
    "is_stack_file",
    "list_stacks",
    "ranges_with",
    "read_stack",
    "restore_bsdf_layer",
    "restore_spec",
    "stack_file",
]
