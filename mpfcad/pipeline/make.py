"""Writes the files of a plan into a folder; what they are worth is examined from the files."""

from collections.abc import Sequence
from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.job import Job, MaskTable
from mpfcad.mask import Mask, MaskCheck, Phototool
from mpfcad.pipeline.plan import CURVATURE_FILE, Plan, groove_count
from mpfcad.pipeline.progress import Progress
from mpfcad.pipeline.screen import mask_rules

MASK_FORMATS = ("oas", "gds", "dxf", "gbr", "svg", "tif")
CAD_FORMATS = ("step", "stl", "3mf", "ply")
#: What `run` makes: the CAD file and the mesh that is traced.
RUN_CAD_FORMATS = ("step", "stl")
MASK_PICTURE, MASK_MARKERS = "mask.png", "mask.lyrdb"


def plan_mask(plan: Plan) -> Mask | None:
    """Return the mask of a plan; None for a film that no print can make.

    Raises
    ------
    InputError
        naming the grooves whose aperture or web would be too small.
    """
    from mpfcad.mask import build_mask

    if plan.process is None:
        return None
    rules = mask_rules(plan.job.mask, plan.job.name)
    return build_mask(plan.panel, plan.process, rules, plan.job.name)


def write_curvature(plan: Plan, folder: Path) -> None:
    """Write curvature.csv: one row a groove of the panel."""
    plan.write_curvature(folder / CURVATURE_FILE)


def phototool(table: MaskTable) -> Phototool:
    """Return how a job wants its artwork."""
    from mpfcad.mask import Phototool

    return Phototool(
        table.polarity, table.mirror, table.emulsion_side, tuple(table.furniture), table.tif_dpi
    )


def write_masks(
    mask: Mask, tool: Phototool, folder: Path, formats: Sequence[str], progress: Progress
) -> None:
    """Write mask.oas, mask.gds and the like."""
    from mpfcad.mask import write_mask

    for name in formats:
        progress.stage(f"writing mask.{name}")
        write_mask(mask, folder / f"mask.{name}", tool)


def check_masks(
    mask: Mask, tool: Phototool, folder: Path, formats: Sequence[str], progress: Progress
) -> dict[str, MaskCheck]:
    """Return the check of each mask file by its name.

    Raises
    ------
    ExportError
        when a file does not read back as what it should hold.
    """
    from mpfcad.mask import check_mask

    checks = {}
    for name in (f"mask.{suffix}" for suffix in formats):
        progress.stage(f"checking {name}")
        checks[name] = check_mask(folder / name, mask, tool)
    return checks


def write_mask_pictures(folder: Path, checks: dict[str, MaskCheck]) -> None:
    """Write mask.lyrdb, the markers of what is too narrow, and mask.png, from the first file."""
    from mpfcad.mask import write_markers, write_preview

    if not checks:
        return
    name = next((n for n, check in checks.items() if check.windows), next(iter(checks)))
    write_preview(folder / MASK_PICTURE, folder / name, checks[name])
    if checks[name].windows:
        write_markers(folder / MASK_MARKERS, name, checks[name].windows)


def write_cad(plan: Plan, folder: Path, formats: tuple[str, ...], progress: Progress) -> None:
    """Write film.step, film.stl, film.3mf, film.ply."""
    from mpfcad.cad import write_3mf, write_ply, write_step, write_stl

    name, table = plan.job.name, plan.job.cad
    meshes = {"stl": write_stl, "3mf": write_3mf, "ply": write_ply}
    for suffix in formats:
        path = folder / f"film.{suffix}"
        progress.stage(f"writing {path.name}")
        if suffix == "step":
            write_step(plan.piece, path, name=name, bodies=table.bodies)
        else:
            meshes[suffix](plan.piece, path, table.angle_tolerance, name=name)


def check_cad(plan: Plan, folder: Path, formats: tuple[str, ...], progress: Progress) -> None:
    """Check the CAD files in `folder`, and STEP against STL where both are there.

    Raises
    ------
    ExportError
        when a file does not read back as what it should hold.
    """
    from mpfcad.cad import check_3mf, check_agreement, check_ply, check_step, check_stl

    for suffix in formats:
        path = folder / f"film.{suffix}"
        progress.stage(f"checking {path.name}")
        if suffix == "step":
            step = check_step(path, plan.piece, bodies=plan.job.cad.bodies)
        elif suffix == "stl":
            check_stl(path, plan.piece, plan.job.cad.angle_tolerance)
        else:
            {"3mf": check_3mf, "ply": check_ply}[suffix](path, plan.piece)
    if {"step", "stl"} <= set(formats):
        progress.stage("comparing film.step with film.stl")
        volume = sum(step.bodies.values())
        check_agreement(folder / "film.step", folder / "film.stl", volume)


def write_tiles(plan: Plan, folder: Path, progress: Progress) -> list[str]:
    """Write and check film-01.stl, film-02.stl, … of one lamp pitch each; return their names.

    Each has as many whole grooves as cover the pitch (the last what is left) and its own x from 0,
    so that float32 is as fine in the last tile as in the first; the header states where it lies.

    Raises
    ------
    ExportError
        when a tile does not read back as what it should hold.
    """
    from mpfcad.cad import check_stl, write_stl

    piece, tolerance = plan.piece, plan.job.cad.angle_tolerance
    count = groove_count(plan.stack.lamp_pitch, piece.groove.pitch)
    names = []
    for first in range(0, piece.groove_count, count):
        tile = piece.cut(first, count, piece.length)
        names.append(f"film-{len(names) + 1:02}.stl")
        progress.stage(f"writing {names[-1]}")
        place = f"x0 = {first * piece.groove.pitch:.6g} mm"
        write_stl(tile, folder / names[-1], tolerance, name=f"{place}, {plan.job.name}")
        check_stl(folder / names[-1], tile, tolerance)
    return names


def refuse_unprintable(job: Job, where: str) -> None:
    """Refuse to make a mask of an `ideal` film.

    Raises
    ------
    InputError
        when the film's profile is `ideal`.
    """
    if job.film.profile != "filled":
        raise InputError(
            f"{where}: film.profile: ideal: resin cannot fill below the walls, so there is no "
            f"mask: must be 'filled'"
        )
