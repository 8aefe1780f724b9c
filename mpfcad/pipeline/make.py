"""Writes the files of a plan into a folder; what they are worth is examined from the files."""

from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.job import Job
from mpfcad.mask import Mask
from mpfcad.pipeline.plan import CURVATURE_FILE, Plan
from mpfcad.pipeline.progress import Progress
from mpfcad.pipeline.screen import mask_rules

MASK_FORMATS = ("oas", "gds")
CAD_FORMATS = ("step", "stl")


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


def write_masks(mask: Mask, folder: Path, formats: tuple[str, ...], progress: Progress) -> None:
    """Write mask.oas, mask.gds."""
    from mpfcad.mask import write_mask

    for name in formats:
        progress.stage(f"writing mask.{name}")
        write_mask(mask, folder / f"mask.{name}")


def write_cad(plan: Plan, folder: Path, formats: tuple[str, ...], progress: Progress) -> None:
    """Write film.step, film.stl."""
    from mpfcad.cad import write_step, write_stl

    if "step" in formats:
        progress.stage("writing film.step")
        write_step(plan.piece, folder / "film.step")
    if "stl" in formats:
        progress.stage("writing film.stl")
        write_stl(plan.piece, folder / "film.stl", plan.job.cad.angle_tolerance)


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
