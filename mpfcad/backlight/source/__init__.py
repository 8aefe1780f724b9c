"""Kinds of light source: each brings its numbers, places, checks, flux, element and picture.

A stack file's `[source]` names the kind; without it a stack has tubes. Another kind is a module
here with an entry in `SPECS`, and its kernels in `optics/cavity/`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from mpfcad.backlight.source.board import LedBoard
from mpfcad.backlight.source.led import LedSpec
from mpfcad.backlight.source.protocol import Emitters, LightSource, Period, SourceSpec
from mpfcad.backlight.source.tube import TubeRow, TubeSpec
from mpfcad.errors import InputError

__all__ = [
    "Emitters",
    "LedBoard",
    "LedSpec",
    "LightSource",
    "Period",
    "SourceSpec",
    "TubeRow",
    "TubeSpec",
    "read_spec",
    "restore_spec",
]


#: Kinds by the name that a stack file gives them.
SPECS: Mapping[str, type[SourceSpec]] = {TubeSpec.kind: TubeSpec, LedSpec.kind: LedSpec}


def read_spec(where: str, folder: Path, entry: object) -> SourceSpec:
    """Return what `[source]` of a stack file beside `folder` says.

    Raises
    ------
    InputError
        when the kind, a key or a value is wrong.
    """
    if not isinstance(entry, Mapping):
        raise InputError(f"{where}: source: {entry!r}: expected a table with kind")
    kind = entry.get("kind")
    if not isinstance(kind, str) or kind not in SPECS:
        raise InputError(f"{where}: source.kind: {kind!r}: expected {', '.join(SPECS)}")
    return SPECS[kind].read(where, folder, entry)


def restore_spec(document: Mapping[str, Any]) -> SourceSpec:
    """Return the spec that was described."""
    return SPECS[document.get("kind", TubeSpec.kind)].restore(document)
