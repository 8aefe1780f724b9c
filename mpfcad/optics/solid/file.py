"""Reads a solid from a file of any format, tells what was understood, and joins its bodies."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import reads
from mpfcad.errors import InputError
from mpfcad.optics.solid.closed import find_fault
from mpfcad.optics.solid.crossing_section import extruded_section
from mpfcad.optics.solid.format.body import MeshFile
from mpfcad.optics.solid.format.look import PLAIN, looks_like, mesh_format
from mpfcad.optics.solid.format.polygon import read_polygons
from mpfcad.optics.solid.format.step import read_step
from mpfcad.optics.solid.format.stl import read_stl_binary, read_stl_text
from mpfcad.optics.solid.format.threemf import read_3mf
from mpfcad.optics.solid.union import unite_bodies, unite_section
from mpfcad.optics.solid.weld import Welded, join_last_steps, weld, weld_doubles

#: Step of float32 numbers [mm] from which on a film's slopes are no longer what was drawn.
COARSE = 2.5e-4
SUFFIXES = (".stl", ".3mf", ".ply", ".obj", ".step", ".stp")


@dataclass(frozen=True, eq=False)
class Solid:
    """What a file holds as one mesh.

    Attributes
    ----------
    vertex, facet
        (v, 3) float64 [mm] and (n, 3) int64
    kind
        the format in words
    note
        what was joined, converted or is doubtful, a sentence each
    """

    vertex: NDArray[np.float64]
    facet: NDArray[np.int64]
    kind: str
    note: tuple[str, ...]

    def last_steps_joined(self) -> "Solid":
        """Return the solid with corners of open edges joined that differ in float32's last step."""
        (vertex, facet), joined = join_last_steps(self.vertex, self.facet)
        said = f"{joined} corners that differ in the last step of float32 joined"
        return Solid(vertex, facet, self.kind, (*self.note, said)) if joined else self

    def summary(self, path: Path) -> str:
        """Return in a line what was read."""
        size = " x ".join(f"{s:.6g}" for s in np.ptp(self.vertex, axis=0))
        read = f"read {path.name}: {self.kind}, {len(self.facet)} facets, {size} mm"
        return "; ".join((read, *self.note))


@reads("a mesh or STEP file")
def read_solid(path: Path) -> Solid:
    """Return the solid of a file, whatever it bounds; the format is found from its bytes.

    Raises
    ------
    InputError
        when the file is missing, of no format that is read, or a number in it is not finite.
    """
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    read = _read(path, data)
    for body in read.body:
        if not np.isfinite(body.corner).all():
            bad = body.corner[~np.isfinite(body.corner).all(axis=(1, 2))][0]
            raise InputError(f"{path}: mesh: facet {bad.tolist()}: expected finite numbers")
    if len(read.body) > 1:
        return _joined(path, read)
    corner, note = read.body[0].corner, list(read.note)
    vertex, facet = weld(corner.astype(np.float32)) if read.single else weld_doubles(corner)
    step = float(np.spacing(np.float32(np.abs(vertex).max())))
    if read.single and step > COARSE:
        note.append(
            f"coordinates up to {np.abs(vertex).max():g} mm: float32 steps of {1000 * step:.2g} µm "
            "spoil the film's slopes; expected near 0"
        )
    return Solid(vertex, facet, read.kind, tuple(note))


def _read(path: Path, data: bytes) -> MeshFile:
    match mesh_format(data):
        case "stl-text":
            return read_stl_text(path, data)
        case "stl":
            return read_stl_binary(path, data)
        case "3mf":
            return read_3mf(path, data)
        case "step":
            return read_step(path, data)
        case "ply" | "obj" as form:
            return read_polygons(path, data, form)
    found = looks_like(data)
    if path.suffix.lower() == ".stl" and found == PLAIN:
        return read_stl_binary(path, data)
    raise InputError(f"{path}: looks like {found}: expected STL, 3MF, PLY, OBJ or STEP")


def _joined(path: Path, read: MeshFile) -> Solid:
    """Return bodies as one solid: where they touch there is no surface between them."""
    names = ", ".join(dict.fromkeys(body.name for body in read.body))
    note = (*read.note, f"{len(read.body)} bodies ({names}) taken as one solid of one material")
    vertex, facet = weld_doubles(np.concatenate([body.corner for body in read.body]))
    left = _without_pairs(facet)
    used, numbered = np.unique(left, return_inverse=True)
    vertex, numbered = vertex[used], numbered.reshape(-1, 3)
    if find_fault(vertex, numbered) is None:
        return Solid(vertex, numbered, read.kind, note)
    whole = _united([weld_doubles(body.corner) for body in read.body])
    if whole is None:
        raise InputError(f"{path}: mesh: bodies {names}: expected each closed and oriented outward")
    return Solid(*whole, read.kind, (*note, "united where they touch or overlap"))


def _united(bodies: list[Welded]) -> Welded | None:
    """Return the union of bodies: in the cross-section where all are drawn along y."""
    shift = np.cumsum([0, *(len(v) for v, _ in bodies[:-1])])
    vertex = np.concatenate([v for v, _ in bodies])
    facet = np.concatenate([f + s for (_, f), s in zip(bodies, shift, strict=True)])
    section = extruded_section(vertex, facet)
    if section is not None:
        return unite_section(section, float(vertex[:, 1].max()))
    part = np.repeat(np.arange(len(bodies)), [len(f) for _, f in bodies])
    return unite_bodies(vertex, facet, part)


def _without_pairs(facet: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return facets without those that lie on one another, turned against each other."""
    low = facet.argmin(axis=1)
    rolled = np.take_along_axis(facet, (low[:, None] + np.arange(3)) % 3, axis=1)
    sense = np.where(rolled[:, 1] < rolled[:, 2], 1, -1)
    number = np.unique(np.sort(facet, axis=1), axis=0, return_inverse=True)[1].ravel()
    return facet[np.bincount(number, sense)[number] != 0]
