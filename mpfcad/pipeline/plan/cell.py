"""Jobs under LEDs: C(x, y) over the cell that repeats, of one film or of two that are crossed."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.film import (
    ALONG_ARRAY,
    CurvatureMap,
    CurvatureSeries,
    check_curvature,
    has_along,
    read_curvature_cell,
)
from mpfcad.job import Job, MapTable
from mpfcad.pipeline.plan.departure import AS_DESIGNED, CellMap, Departure, PrintError
from mpfcad.pipeline.plan.groove_map import read_map
from mpfcad.pipeline.plan.size import check_places

#: Curvatures of a library, and length of its pieces [mm], unless the job says.
LEVELS, PIECE = 64, 0.5
#: How far a cell may be from whole grooves [mm].
_ROOM = 1e-6


@dataclass(frozen=True)
class CellFrame:
    """Where a film's cells lie on its panel, by the film's own axes: x across its grooves.

    Attributes
    ----------
    panel
        extent of the panel [mm]
    size
        of the lattice's own cell [mm], over which the map repeats
    origin
        place of an LED [mm], from the panel's lower left corner
    repeat
        cells that are traced together, along x and y
    """

    panel: tuple[float, float]
    size: tuple[float, float]
    origin: tuple[float, float]
    repeat: tuple[int, int] = (1, 1)

    @classmethod
    def of(cls, stack: Stack) -> "CellFrame":
        """Return the frame of the film in the job's place."""
        size, whole = stack.source.cell, stack.period
        n, m = (round(all_of / one) for all_of, one in zip(whole, size, strict=True))
        return cls((stack.panel_width, stack.panel_length), size, stack.origin, (n, m))

    @property
    def turned(self) -> "CellFrame":
        """The frame of a film turned by 90°: its x is the panel's y, its y goes against x."""
        (width, length), (across, along), (x, y) = self.panel, self.size, self.origin
        n, m = self.repeat
        return CellFrame((length, width), (along, across), (y, width - x), (m, n))

    def places(self, pitch: float, piece: float, where: str) -> tuple[int, int]:
        """Return the number of grooves across a cell, and of pieces along it.

        Raises
        ------
        InputError
            that begins with `where`, for a cell of no whole number of grooves, or too many pieces.
        """
        count = round(self.size[0] / pitch)
        if count < 1 or abs(count * pitch - self.size[0]) > _ROOM:
            raise InputError(
                f"{where}: film.pitch_um: {pitch * 1e3:g}: the LEDs' cell is {self.size[0]:g} mm "
                "across its grooves: expected a whole number of grooves"
            )
        found = count, max(1, round(self.size[1] / piece))
        check_places(*found, piece, where)
        return found


def wanted_over(
    at: CellMap, frame: CellFrame, pitch: float, piece: float, where: str, *, turned: bool = False
) -> NDArray[np.float64]:
    """Return C at the middle of each piece of a cell, (n, m) float64 [1/mm], by the film's axes.

    `at` has the panel's axes; `turned` for a film that lies across, whose frame is `frame`.
    """
    count, pieces = frame.places(pitch, piece, where)
    u, v = (np.arange(count) + 0.5) / count, (np.arange(pieces) + 0.5) / pieces
    return np.ascontiguousarray(at(1 - v, u).T) if turned else at(u, v)


def piece_length(job: Job) -> float:
    """Return about how long pieces of one C are [mm]; of a halftone as printed; of cells a cell.

    Raises
    ------
    InputError
        when a length is given for cells.
    """
    given = job.cad.inside("piece_mm")
    if job.has_cells:
        if given is not None:
            raise InputError(
                f"job: cad.piece_mm: {job.cad.piece_mm:g}: expected to be left out for cells"
            )
        return job.film.groove.pitch
    return job.halftone.piece_mm if job.halftone is not None else given or PIECE


def read_cell_maps(
    job: Job, job_file: Path, stack: Stack, departure: Departure = AS_DESIGNED
) -> list[NDArray[np.float64]]:
    """Return C over the cell of each printed film, (n, m) float64 [1/mm], by the film's own axes.

    The first is that of the job's place; a second lies across it, the job's `[crossed]`. Of
    `departure`, each film's print counts here.

    Raises
    ------
    InputError
        when a map is wrong, or the film is not grooves as designed.
    """
    where = str(job_file)
    _refuse(job, stack, where)
    groove, frame = job.film.groove, CellFrame.of(stack)
    pitch, piece = groove.pitch, piece_length(job)
    made = frame.size, groove, job.film.profile
    for film in departure.films:
        _check_error(film, job, where)

    def printed(number: int, table: MapTable) -> CellMap:
        film = departure.of_map(number, halftone=job.halftone is not None)
        return film.on(_read(job, job_file, table, stack), *made)

    found = [wanted_over(printed(0, job.map), frame, pitch, piece, where)]
    if job.crossed is not None:
        across = printed(1, job.crossed if job.crossed.is_given else job.map)
        found.append(wanted_over(across, frame.turned, pitch, piece, where, turned=True))
    return [_within(wanted, job, where) for wanted in found]


def read_along_map(
    job: Job, job_file: Path, stack: Stack, departure: Departure = AS_DESIGNED
) -> NDArray[np.float64] | None:
    """Return C along y over the cell, as `read_cell_maps` that along x; None where it is the same.

    Raises
    ------
    InputError
        when the map is wrong, or the film is no mould's cells.
    """
    if not states_along(job, job_file):
        return None
    where, frame, groove = str(job_file), CellFrame.of(stack), job.film.groove
    wanted = _read(job, job_file, job.map, stack, along=True)
    at = departure.film(0).on(wanted, frame.size, groove, job.film.profile)
    return _within(wanted_over(at, frame, groove.pitch, groove.pitch, where), job, where)


def states_along(job: Job, job_file: Path) -> bool:
    """Return whether a job's map has a C of its own along y.

    Raises
    ------
    InputError
        when its film is no mould's cells under LEDs.
    """
    map_file = job.map.file if job.map.extent == "cell" else None
    stated = job.map.states_along or (job.crossed is not None and job.crossed.states_along)
    if not stated and not (map_file is not None and has_along(job_file.parent / map_file)):
        return False
    if job.film.cell == "groove" or job.film.profile != "ideal":
        raise InputError(
            f"{job_file}: map: C along y apart from that along x: film.cell {job.film.cell}, "
            f"profile {job.film.profile}: expected pyramids or dishes of profile 'ideal', a mould's"
        )
    return True


def _within(wanted: NDArray[np.float64], job: Job, where: str) -> NDArray[np.float64]:
    """Return curvatures that a film can have.

    Raises
    ------
    InputError
        that begins with `where`, for others.
    """
    most = job.film.groove.curvature_most(job.film.profile)
    low, high = float(wanted.min()), float(wanted.max())
    if not np.isfinite(wanted).all() or low < 0 or high > most * (1 + 1e-12):
        raise InputError(
            f"{where}: map: C {low:.4g} … {high:.4g} /mm over the cell: expected 0 … {most:.6g} /mm"
        )
    return np.minimum(wanted, most)


def _refuse(job: Job, stack: Stack, where: str) -> None:
    """Raise for what a film under LEDs is not made with."""
    cells = job.has_cells
    if job.film.profile != "filled" and not cells:
        raise InputError(
            f"{where}: film: under LEDs a film is held as pieces of grooves: expected profile "
            "'filled', without imperfections"
        )
    if not job.film.model_copy(update={"cell": "groove"}).is_plain:
        raise InputError(f"{where}: film: expected a film as designed, without imperfections")
    for name in ("crossed", "halftone"):
        if cells and getattr(job, name) is not None:
            raise InputError(
                f"{where}: {name}: film.cell {job.film.cell}: expected to be left out: cells are "
                "patterned both ways"
            )
    if stack.needs_prism:
        raise InputError(f"{where}: resin: expected one as the prisms, clear, under LEDs")
    _refuse_confidence(job, where)


def _refuse_confidence(job: Job, where: str) -> None:
    what = f"film.cell {job.film.cell}" if job.halftone is None else "[halftone]"
    if job.wants_confidence and what != "film.cell groove":
        raise InputError(
            f"{where}: confidence: {what}: under LEDs is for films of grooves without halftones so "
            "far: expected to be left out: `mpfcad sweep` tells what thickness, LEDs and others do"
        )


def even_cells(job: Job, departure: Departure, count: int, where: str) -> NDArray[np.float64]:
    """Return C of each row of equal pyramids or dishes over a panel of LEDs, (count,) [1/mm].

    Raises
    ------
    InputError
        that begins with `where`, for what such a film does not have: a pattern, a film across.
    """
    curvature, cell = job.map.curvature_per_mm, job.film.cell
    if curvature is None:
        raise InputError(f"{where}: map: film.cell {cell}: expected one curvature_per_mm")
    for name in ("crossed", "halftone"):
        if getattr(job, name) is not None:
            raise InputError(f"{where}: {name}: film.cell {cell}: expected to be left out")
    _refuse_confidence(job, where)
    if any(film != PrintError() for film in departure.films):
        raise InputError(
            f"{where}: film.cell {cell}: is not printed: expected no axis of registration or print"
        )
    check_curvature(curvature, job.film.groove, job.film.profile, f"{where}: map.curvature_per_mm")
    return np.full(count, curvature)


def _check_error(film: PrintError, job: Job, where: str) -> None:
    most = job.film.groove.curvature_empty
    if film.resin and job.film.profile != "filled":
        raise InputError(
            f"{where}: axis resin_percent: {film.resin * 100:g}: profile {job.film.profile}: a "
            "mould makes the film: expected curvature_error_per_mm"
        )
    if abs(film.curvature) >= most:
        raise InputError(
            f"{where}: axis curvature_error_per_mm: {film.curvature:g}: no C is left within "
            f"0 … {most:g} /mm: expected less"
        )


def refuse_cell_map(job: Job, where: str) -> None:
    """Refuse under tubes what only a cell of LEDs has.

    Raises
    ------
    InputError
        when the job has it.
    """
    cell_only = job.map.series_per_mm is not None or job.map.states_along
    tables = [name for name in ("crossed", "halftone") if getattr(job, name) is not None]
    if cell_only or job.map.extent == "cell" or tables:
        raise InputError(
            f"{where}: {[*tables, 'map'][0]}: is over a cell of LEDs, and tubes light the stack: "
            "expected map.file, rows or curvature_per_mm, extent 'pitch' or 'panel', and no "
            "[crossed] or [halftone]"
        )


def _read(
    job: Job, job_file: Path, table: MapTable, stack: Stack, *, along: bool = False
) -> CellMap:
    """Return the map of a table over the cell, by the panel's axes; `along`: of C along y."""
    series = table.series_along_per_mm if along else table.series_per_mm
    if series is not None:
        return CurvatureSeries(np.array(series, np.float64)).at
    if table.extent == "panel":
        raise InputError(
            f"{job_file}: map.extent: panel: expected 'cell' (C(x, y) from an LED) or 'pitch' "
            "(across the grooves) under LEDs"
        )
    if table.extent == "cell":
        if table.file is None:
            raise InputError(f"{job_file}: map.extent: cell: expected map.file, an NPZ")
        cell = read_curvature_cell(
            job_file.parent / table.file,
            profile=job.film.profile,
            groove=job.film.groove,
            size=stack.source.cell,
            **({"table": ALONG_ARRAY} if along else {}),
        )
        return cell.at
    if along:
        own = table.curvature_along_per_mm
        return lambda u, v: np.full((len(u), len(v)), own)
    return _across(read_map(job, job_file, stack, table), stack.source.cell.across)


def _across(found: CurvatureMap, period: float) -> CellMap:
    """Return a map across the grooves alone over the cell."""

    def at(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        row = found.on_grooves(u * period, period, 0.0)
        return np.repeat(np.asarray(row)[:, None], len(v), axis=1)

    return at


def turned_job(job: Job) -> Job:
    """Return the job of the film that lies across, for what is said of its own files."""
    return job.model_copy(update={"name": f"{job.name}-crossed"})


def crossed_layer(stack: Stack, where: str) -> str:
    """Return the layer in whose place the film that lies across stands.

    Raises
    ------
    InputError
        that begins with `where`, when the stack has no prism film turned by 90°.
    """
    for name, layer in stack.own.items():
        turned = stack.kind_of(name) == "film" and layer.file is None and not stack.is_slot(name)
        if turned and abs(stack[f"{name}.rotation_deg"] - 90) < 1e-9:
            return name
    raise InputError(
        f"{where}: stack {stack.name} has no film across: expected a layer of kind bef with "
        "rotation_deg 90"
    )


def with_crossed(stack: Stack, mesh: Path) -> Stack:
    """Return a stack with the film of a mesh file in the place of that across."""
    name = crossed_layer(stack, stack.name)
    layer = replace(stack.own[name], kind="film", file=str(mesh))
    return replace(stack, own={**stack.own, name: layer})
