"""A case of the thesis: a film in a stack, traced from its mesh file, each trace kept on disk."""

import hashlib
import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from mpfcad.backlight import Stack, read_stack
from mpfcad.store import code_hash

#: Where meshes and finished traces are kept; git ignores it.
CACHE = Path(__file__).parents[2] / "exports" / "reproduction"
#: The packages that decide a traced figure.
_CODE = ("optics", "backlight", "measure")
PITCH, DEPTH, BASE, LENGTH = 0.050, 0.025, 0.2, 2.0
#: A uniform film repeats after any number of grooves; twenty make the meter's spot.
GROOVES = 20
ANGLE_TOLERANCE_DEG = 0.5
EMPTY = 80.0
#: Curvature through the tips at a fill of 10 %: 57.04 /mm (Hsieh, MPF thesis: fitted 58 /mm).
PRINTED = 57.04


@dataclass(frozen=True)
class Case:
    """A uniform film in a stack.

    Attributes
    ----------
    name
        in the results
    preset
        of the stack
    profile
        `filled` or `ideal`
    curvature
        through the tips [1/mm]; 80 with `filled` is the plain BEF
    """

    name: str
    preset: str
    profile: str
    curvature: float

    def stack(self) -> Stack:
        """Return the preset's stack."""
        return read_stack(self.preset)

    def mesh(self) -> Path:
        """Return the film's STL file."""
        return film_mesh(self.profile, self.curvature)

    def identity(self, stack: Stack) -> list:
        """Return all that a figure of this case in a stack depends on but the code and effort."""
        return [describe(stack), file_hash(self.mesh())]


@cache
def film_mesh(profile: str, curvature: float) -> Path:
    """Return the STL file of a uniform film, written anew by each process: never that of old code.

    `curvature` [1/mm]: 80 with `filled` is the film without resin.
    """
    from mpfcad.cad import write_stl
    from mpfcad.film import Groove, PrismFilm

    CACHE.mkdir(parents=True, exist_ok=True)
    path = CACHE / f"{profile}-{curvature:g}.stl"
    film = PrismFilm(
        Groove(PITCH, DEPTH), BASE, LENGTH, profile, np.full(GROOVES, float(curvature))
    )
    part = path.with_name(f".{path.stem}.part.stl")
    write_stl(film, part, np.deg2rad(ANGLE_TOLERANCE_DEG))
    return part.replace(path)


def describe(stack: Stack) -> list:
    """Return a stack's layers and values, as JSON knows them."""
    return [list(stack.layers), {name: entry.value for name, entry in stack.quantity.items()}]


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def keep(kind: str, identity: object, make) -> dict:
    """Return what `make()` returns, from disk if the same code made the same identity before."""
    text = json.dumps([code_hash(*_CODE), identity], sort_keys=True)
    path = CACHE / f"{kind}-{hashlib.sha256(text.encode()).hexdigest()[:20]}.json"
    if path.exists():
        return json.loads(path.read_text("utf-8"))
    made = make()
    part = path.with_name(f".{path.name}.part")
    part.write_text(json.dumps(made), "utf-8")
    part.replace(path)
    return made
