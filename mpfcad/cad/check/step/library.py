"""Read the STEP assembly of a library and a window back with OCCT, and compare it with them."""

from pathlib import Path

import numpy as np

from mpfcad.cad.check.step.body import (
    EXTENT_LIMIT,
    VOLUME_LIMIT,
    StepCheck,
    bounding_box,
    check_solids,
    enclosed_volume,
)
from mpfcad.cad.check.step.read import read_instances
from mpfcad.cad.check.step.text import MILLIMETRE, read_units
from mpfcad.cad.file.library import piece_name
from mpfcad.cad.step.library import library_places, window_extent
from mpfcad.errors import ExportError
from mpfcad.film import CellLibrary, PieceLibrary
from mpfcad.gate import Gate, worst_of_each, yes_no
from mpfcad.units import um

#: Largest error [mm] of a place.
PLACE_LIMIT = 1e-9


def check_library_step(path: Path, library: PieceLibrary | CellLibrary) -> StepCheck:
    """Return what the file holds: each piece as a valid solid of its volume, at all its places.

    Raises
    ------
    ExportError
        when it is not in mm, or a piece is missing or stands elsewhere.
    """
    path = Path(path)
    units = read_units(path)
    if units != MILLIMETRE:
        raise ExportError(f"{path.name}: length units {sorted(units)}: expected all millimetres")
    cells = isinstance(library, CellLibrary)
    found = read_instances(path, repair=cells)
    expected = {
        piece_name(library, number): (library.piece(number).volume, places)
        for number, places in library_places(library).items()
    }
    if set(found) != set(expected):
        raise ExportError(f"{path.name}: bodies {sorted(found)}: expected {sorted(expected)}")
    invalid, gates, volumes, worst = [], [], {}, 0.0
    for name, shapes in found.items():
        volume, places = expected[name]
        _check_places(path, name, shapes, np.array(places))
        invalid += [] if check_solids(path, name, shapes[0], 1) else [name]
        each = enclosed_volume(shapes[0])
        detail = f"{path.name}: {name}"
        error = abs(each / volume - 1)
        worst = max(worst, error)
        gates.append(Gate("step_volume_error", error, VOLUME_LIMIT, detail=detail))
        volumes[name] = each * len(shapes)
    low, high = _extent(found, expected)
    wanted = window_extent(library)
    off = max(float(np.abs(a - b).max()) for a, b in zip((low, high), wanted, strict=True))
    why = f"{path.name}: {', '.join(invalid)}: OCCT finds this body not valid"
    figures = (
        yes_no("step_valid", not invalid, why),
        *worst_of_each(gates),
        Gate("step_extent_error_um", off / um, EXTENT_LIMIT / um, detail=path.name),
    )
    counts = {name: len(shapes) for name, shapes in found.items()}
    corners = (tuple(map(float, low)), tuple(map(float, high)))
    return StepCheck(not invalid, volumes, worst, *corners, "mm", counts, figures)  # type: ignore[arg-type]


def _extent(
    found: dict[str, list], expected: dict[str, tuple[float, list[tuple[float, float]]]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners [mm] of the box round all instances: round one of each, and its places."""
    corners = []
    for name, shapes in found.items():
        move = shapes[0].Location().Transformation().TranslationPart()
        places = np.array(expected[name][1])
        for corner in bounding_box({name: shapes[0]}):
            at = corner - (move.X(), move.Y(), 0.0)
            corners += [
                at + np.append(places.min(axis=0), 0),
                at + np.append(places.max(axis=0), 0),
            ]
    return np.min(corners, axis=0), np.max(corners, axis=0)


def _check_places(path: Path, name: str, shapes: list, wanted: np.ndarray) -> None:
    """Refuse instances that do not stand where the piece does."""
    moves = [shape.Location().Transformation().TranslationPart() for shape in shapes]
    at = np.array([(move.X(), move.Y()) for move in moves])
    if len(at) != len(wanted):
        raise ExportError(f"{path.name}: {name}: {len(at)} instances: expected {len(wanted)}")
    ordered = [places[np.lexsort(places.round(9).T)] for places in (at, wanted)]
    off = float(np.abs(ordered[0] - ordered[1]).max())
    if off > PLACE_LIMIT:
        raise ExportError(f"{path.name}: {name}: an instance is {off:.2g} mm off its place")
