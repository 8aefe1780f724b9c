"""Writes the files of a plan into a folder; what they are worth is examined from the files."""

import time
from collections.abc import Sequence
from pathlib import Path

from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.errors import InputError
from mpfcad.film import PanelFilm, Process
from mpfcad.gate import demand
from mpfcad.job import Job
from mpfcad.mask import Mask, MaskCheck, MaskRules, Phototool
from mpfcad.mask.format.write import FORMATS
from mpfcad.mask.screen.order import artwork_size
from mpfcad.mask.told import Told
from mpfcad.pipeline.kind import Check, kind_of
from mpfcad.pipeline.plan.height import HEIGHT_FORMATS
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.printed.mask_need import refuse_mask_need
from mpfcad.pipeline.plan.printed.picture import Picture
from mpfcad.pipeline.plan.printed.screen import job_levelling, mask_rules
from mpfcad.pipeline.plan.size import groove_count
from mpfcad.pipeline.progress import Progress

#: Seconds between two lines that say how far a long file is.
INTERVAL = 10.0
MASK_FORMATS = tuple(FORMATS)
CAD_FORMATS = ("step", "stl", "3mf", "ply", "csv", *HEIGHT_FORMATS)
#: Endings of the picture of a mask, and of the markers of what is too narrow in it.
PICTURE, MARKERS = "png", "lyrdb"


def plan_mask(plan: Plan) -> Mask | None:
    """Return the mask of a plan; None for a film that no print can make.

    Raises
    ------
    InputError
        naming the grooves whose aperture or web would be too small.
    """
    if plan.process is None:
        return None
    return mask_of(plan.job, plan.printed, plan.process, plan.where)


def mask_of(job: Job, film: PanelFilm, process: Process, where: str) -> Mask:
    """Return the mask of a job's film.

    Raises
    ------
    InputError
        naming the grooves whose aperture or web would be too small, or what would fit.
    """
    from mpfcad.mask import build_mask

    rules = job_rules(job, film, process, where)
    # As many bytes as OASIS needs: what other formats take is asked where they are.
    refuse_mask_need(film, process, rules, ("oas",), where)
    return build_mask(film, process, rules, job.name, where)


def job_rules(job: Job, film: PanelFilm, process: Process, where: str) -> MaskRules:
    """Return the rules of a job's mask, levelling worked out for its least filled groove.

    Raises
    ------
    InputError
        that begins with `where`, for a mesh that there is not, or a resin that does not run.
    """
    curvature = film.content[-1]
    wet = curvature[film.groove.takes_resin(curvature)]
    smallest = float(process.aperture_ratio_of_curvature(wet).min(initial=1.0))
    levelling = job_levelling(job, process, film.groove, smallest, where)
    return mask_rules(job.mask, where, levelling)


def write_curvature(plan: Plan, folder: Path) -> None:
    """Write curvature.csv, one row a groove of the panel, or curvature.npz of a map C(x, y)."""
    for film in plan.films:
        film.write_curvature(folder)


def write_masks(
    mask: Mask, tool: Phototool, folder: Path, names: Sequence[str], progress: Progress
) -> None:
    """Write mask.oas, mask.gds and the like."""
    from mpfcad.mask import write_mask

    for name in names:
        words = f"writing {name}{_picture_words(mask, tool, name)}"
        progress.stage(words)
        write_mask(mask, folder / name, tool, _told(progress, words))


def _picture_words(mask: Mask, tool: Phototool, name: str) -> str:
    """Return how long a large TIFF will take, as text."""
    if not name.endswith(".tif"):
        return ""
    return Picture.of(artwork_size(mask, tool), tool.dpi, mask.is_lattice).words


def _told(progress: Progress, words: str) -> Told:
    """Return who shows the share of a long file, every `INTERVAL` seconds."""
    last = time.monotonic()

    def tell(share: float) -> None:
        nonlocal last
        if time.monotonic() - last >= INTERVAL and share < 1:
            last = time.monotonic()
            progress.stage(f"{words}: {share:.0%}")

    return tell


def check_masks(
    mask: Mask, tool: Phototool, folder: Path, names: Sequence[str], progress: Progress
) -> dict[str, MaskCheck]:
    """Return the check of each mask file by its name; its gates judge it.

    Raises
    ------
    ExportError
        when a file does not read back as such a mask.
    """
    from mpfcad.mask import check_mask

    checks = {}
    for name in names:
        words = f"checking {name}"
        progress.stage(words)
        checks[name] = check_mask(folder / name, mask, tool, _told(progress, words))
    return checks


def write_mask_pictures(
    folder: Path,
    checks: dict[str, MaskCheck],
    mask: Mask | None,
    source: Path | None = None,
    stem: str = "mask",
) -> None:
    """Write mask.lyrdb, the markers of what is too narrow, and mask.png, from the first file.

    `checks` are those of one mask's files, which begin with `stem`; `source` is where they are,
    None: in `folder`.
    """
    from mpfcad.mask import write_markers, write_preview

    if not checks or mask is None:
        return
    name = next((n for n, check in checks.items() if check.windows), next(iter(checks)))
    write_preview(folder / f"{stem}.{PICTURE}", (source or folder) / name, checks[name], mask)
    windows = checks[name].windows
    if windows:
        write_markers(folder / f"{stem}.{MARKERS}", name, windows)


def write_cad(plan: Plan, folder: Path, formats: Sequence[str], progress: Progress) -> None:
    """Write film.step, film.stl, film.3mf, film.ply, and height maps, of each film."""
    from mpfcad.cad.file.height import write_heights

    for film in plan.films:
        drawing = kind_of(film.drawn, film.job.cad)
        for suffix in formats:
            path = folder / film.file("film", suffix)
            progress.stage(f"writing {path.name}")
            if suffix in HEIGHT_FORMATS:
                write_heights(drawing.grid(), path, film.job.name)
            else:
                drawing.write(path, film.job.name)


def left_out(plan: Plan) -> list[str]:
    """Return what of each film's resin is too thin for its CAD files, one sentence a film."""
    words = [(film, kind_of(film.drawn, film.job.cad).left_out()) for film in plan.films]
    return [f"film{film.suffix}: {text}" for film, text in words if text]


def mask_names(plan: Plan, formats: Sequence[str]) -> list[str]:
    """Return the names of a film's mask files in some formats."""
    return [plan.file("mask", suffix) for suffix in formats]


def check_cad(
    plan: Plan, folder: Path, formats: Sequence[str], progress: Progress
) -> list[Check | Agreement]:
    """Return the check of each CAD file in `folder`, and of STEP against STL.

    Raises
    ------
    ExportError
        when a file does not read back as such a body.
    """
    from mpfcad.cad.file.height import check_heights

    found: list[Check | Agreement] = []
    for film in plan.films:
        drawing = kind_of(film.drawn, film.job.cad)
        checks: dict[str, Check] = {}
        for suffix in formats:
            path = folder / film.file("film", suffix)
            progress.stage(f"checking {path.name}")
            if suffix in HEIGHT_FORMATS:
                check_heights(path, drawing.grid())
                continue
            check = drawing.check(path)
            if check is not None:
                checks[suffix] = check
        found += checks.values()
        step = checks.get("step")
        if isinstance(step, StepCheck) and isinstance(checks.get("stl"), MeshCheck):
            progress.stage("comparing film.step with film.stl")
            files = folder / film.file("film", "step"), folder / film.file("film", "stl")
            found.append(drawing.compare(*files, sum(step.bodies.values())))
    return found


def write_tiles(plan: Plan, folder: Path, progress: Progress) -> list[str]:
    """Write and check film-01.stl, film-02.stl, … of one lamp pitch each; return their names.

    Each has as many whole grooves as cover the pitch (the last what is left) and its own x from 0,
    so that float32 is as fine in the last tile as in the first; the header states where it lies.

    Raises
    ------
    ExportError
        when a tile does not read back as what it should hold.
    """
    kind = kind_of(plan.drawn, plan.job.cad)
    count = groove_count(plan.stack.period.across, plan.piece.groove.pitch)
    names: list[str] = []
    for first in range(0, plan.piece.groove_count, count):
        tile = kind.tile(first, count)
        if tile is None:
            break
        names.append(f"film-{len(names) + 1:02}.stl")
        progress.stage(f"writing {names[-1]}")
        place = f"x0 = {first * kind.film.groove.pitch:.6g} mm"
        tile.write(folder / names[-1], f"{place}, {plan.job.name}")
        check = tile.check(folder / names[-1])
        demand(check.gates if check is not None else ())
    return names


def refuse_formats(plan: Plan, formats: Sequence[str], where: str) -> None:
    """Refuse CAD formats that the kind of film is not written in, and height maps too large.

    Raises
    ------
    InputError
        naming the format, or `cad.stl` for tiles of cells.
    """
    from mpfcad.cad.file.height import refuse_points

    kind = kind_of(plan.drawn, plan.job.cad)
    allowed = kind.formats
    unknown = [name for name in formats if name not in allowed]
    if unknown:
        raise InputError(
            f"--format: {unknown[0]}: expected some of {', '.join(allowed)} for such a film"
        )
    if plan.job.cad.stl == "tiles" and kind.tile(0, 1) is None:
        raise InputError(
            f"{where}: cad.stl: tiles: expected 'whole' for cells and maps that vary along grooves"
        )
    for film in plan.films:
        for suffix in (name for name in formats if name in HEIGHT_FORMATS):
            grid = kind_of(film.drawn, film.job.cad).grid()
            refuse_points(grid, film.file("film", suffix), f"{where}: ")


def refuse_unprintable(job: Job, where: str) -> None:
    """Refuse to make a mask of an `ideal` film, or of cells.

    Raises
    ------
    InputError
        when the film's profile is `ideal`, or its cells are no grooves.
    """
    if job.film.cell != "groove" and not job.is_printed:
        raise InputError(
            f"{where}: film.cell: {job.film.cell}: the process is calibrated for grooves, so there "
            "is no mask: expected 'groove', or filled pyramids with a map over a cell of LEDs"
        )
    if job.film.profile != "filled":
        raise InputError(
            f"{where}: film.profile: ideal: resin cannot fill below the walls, so there is no "
            f"mask: expected 'filled'"
        )
