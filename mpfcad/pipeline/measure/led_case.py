"""What films under LEDs are held against: the stack without films, bare prisms, the first alone."""

import tempfile
from dataclasses import replace
from pathlib import Path

from mpfcad.measure import Lit
from mpfcad.pipeline.measure.case import Case, mesh_case, plain_case, read_case, write_plain


def read_cases(source: str, stack: str | None = None) -> list[Case]:
    """Return the case of a source, and before it, of two printed films, that of the first alone.

    `source` and `stack` as in `read_case`.

    Raises
    ------
    InputError
        when there is no such thing, or it is wrong.
    """
    case = read_case(source, stack)
    if not case.lit.is_cell or not _printed(case.lit):
        return [case]
    alone = read_case(source, stack, alone=True)
    if _printed(alone.lit):
        return [case]  # the stack's own film, not one of a job
    return [replace(alone, name=f"{case.name}, first film alone"), case]


def plain_cases(lit: Lit) -> list[Case]:
    """Return a stack of LEDs without its prism films, and with bare prisms in all their places."""
    stack = lit.stack
    kept = tuple(layer for layer in stack.layers if stack.kind_of(layer) != "film")
    own = {name: layer for name, layer in stack.own.items() if name in kept}
    empty = replace(stack, layers=kept, own=own, prism=None)
    none = replace(mesh_case(None, empty, 0.0), name="no prism film")
    with tempfile.TemporaryDirectory() as temporary:
        mesh = Path(temporary) / "bef.stl"
        write_plain(stack, mesh)
        bare = {
            name: replace(layer, file=str(mesh)) if name in _printed(lit) else layer
            for name, layer in stack.own.items()
        }
        found = plain_case(replace(stack, own=bare))
    return [none, replace(found, name="bare prisms")]


def _printed(lit: Lit) -> list[str]:
    """Return the layers besides the job's film that are printed: libraries of pieces."""
    from mpfcad.backlight.lower import printed_films

    libraries = printed_films(lit.elements)
    own = [name for name in lit.stack.own if not lit.stack.is_slot(name)]
    return [name for name in own if name.replace("_", " ") in libraries]
