"""The order of a job's screen: how the artwork is handed over, and what is refused before work."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from mpfcad.errors import InputError
from mpfcad.export import sha256, write_text
from mpfcad.film import Process
from mpfcad.job import Job
from mpfcad.mask import Mask, Phototool, refuse_large
from mpfcad.mask.screen.order import (
    OrderTerms,
    artwork_size,
    describe_order,
    order_lines,
    screen_line,
)
from mpfcad.pipeline.plan.printed.mask_need import mask_need, refuse_files
from mpfcad.pipeline.plan.printed.picture import refuse_picture
from mpfcad.pipeline.plan.printed.screen import moire_setting
from mpfcad.record.printing import RATIO_LIMIT
from mpfcad.units import mm, um

#: Formats that hold closed drawings of any pattern, and of patterns with one array a groove.
CLOSED_ANY, CLOSED_LATTICE = ("gbr", "svg", "tif"), ("oas", "gds", "gbr", "svg", "tif")
INCH = 25.4 * mm
#: The order sheet, and the coupons of its step wedge.
ORDER, COUPONS = "order.pdf", "coupons.csv"


def phototool(job: Job, mask: Mask, process: Process) -> Phototool:
    """Return how a job wants its artwork, the order's lines in it."""
    tool = bare_phototool(job)
    order = describe_order(mask, process, tool, order_terms(job))
    return Phototool(
        tool.polarity, tool.mirror, tool.emulsion_side, tool.furniture, tool.dpi,
        order_lines(order),
    )  # fmt: skip


def bare_phototool(job: Job) -> Phototool:
    """Return how a job wants its artwork, without the order's lines."""
    table = job.mask
    return Phototool(
        table.polarity, table.mirror, table.emulsion_side, tuple(table.furniture), table.tif_dpi
    )


def order_terms(job: Job) -> OrderTerms:
    """Return what a job decides of its order."""
    frame = job.mask.frame_mm
    return OrderTerms(
        revision=job.mask.revision,
        squeegee=job.mask.squeegee,
        frame=None if frame is None else (frame[0], frame[1]),
        mesh_angle=moire_setting(job.mask).mesh_angle,
        emulsion=_stated_emulsion(job),
        curvature_tolerance=job.gates.ripple_curvature_per_mm,
    )


def _stated_emulsion(job: Job) -> float | None:
    mesh = job.mask.mesh
    return mesh.emulsion if mesh is not None and "emulsion_um" in mesh.model_fields_set else None


def job_order(job: Job, mask: Mask, process: Process) -> dict[str, Any]:
    """Return the facts of a job's order."""
    return describe_order(mask, process, bare_phototool(job), order_terms(job))


def write_job_order(
    folder: Path,
    order: dict[str, Any],
    printability: str | None,
    formats: Sequence[str],
    masks: Path | None = None,
    film: str = "",
) -> None:
    """Write order.pdf and the list of coupons for `mpfcad calibrate`.

    `masks` is where the mask files are whose hashes the sheet states; None: in `folder`.
    """
    from mpfcad.mask.screen.order import coupon_table
    from mpfcad.mask.screen.order_picture import read_artwork
    from mpfcad.mask.screen.order_sheet import write_order

    names, source = [f"mask{film}.{suffix}" for suffix in formats], masks or folder
    hashes = {name: sha256(source / name) for name in names}
    artwork = read_artwork(source, names)
    write_order(folder / named(ORDER, film), order, printability, hashes, artwork)
    if order["coupon_aperture_ratio"]:
        write_text(folder / named(COUPONS, film), coupon_table(order))


def named(file: str, film: str) -> str:
    """Return the name of a file of a film, `film` what comes before its ending."""
    return file.replace(".", f"{film}.")


def refuse_mask_formats(
    job: Job, mask: Mask, formats: Sequence[str], where: str, folder: Path
) -> None:
    """Refuse formats that cannot hold the mask, and a frame too small, before anything is made.

    `folder` is where the files will be: its disk counts.

    Raises
    ------
    InputError
        naming the job's field, and what would do.
    """
    line = screen_line(mask.rules.mesh, order_terms(job))
    artwork = artwork_size(mask, replace(bare_phototool(job), notes=(line,)))
    _refuse_frame(job, artwork, where)
    if "tif" in formats:
        refuse_picture(artwork, job.mask.tif_dpi, mask.is_lattice, where, folder)
    lattice = mask.rules.pattern in ("slot", "dot", "staggered", "angled") and not list(
        mask.tile_arrays
    )
    if job.mask.polarity == "closed":
        able = CLOSED_LATTICE if lattice else CLOSED_ANY
        unable = [name for name in formats if name not in able]
        if unable:
            raise InputError(
                f"{where}: mask.polarity: closed: {unable[0]} cannot hold what is closed of "
                f"pattern {mask.rules.pattern!r}: expected 'open', or mask.formats of "
                f"{', '.join(able)}"
            )
    refuse_large(mask, formats, bare_phototool(job), where)
    refuse_files(mask_need(mask, formats), where, folder)
    pixel = INCH / job.mask.tif_dpi
    if "tif" in formats and pixel / mask.length > RATIO_LIMIT:
        dpi = INCH / (RATIO_LIMIT * mask.length)
        raise InputError(
            f"{where}: mask.formats: tif: a pixel of {pixel / um:.3g} µm is "
            f"{pixel / mask.length:.2g} of the panel's length {mask.length:g} mm: expected at most "
            f"{RATIO_LIMIT:g}: a panel of {pixel / RATIO_LIMIT:.3g} mm or more, or mask.tif_dpi "
            f"{math.ceil(dpi)} or more"
        )
    if mask.rules.pattern == "error-diffused":
        side = smallest_dot(mask)
        share = side**2 / (mask.pitch * mask.length)
        if share > RATIO_LIMIT:
            length = side**2 / (mask.pitch * RATIO_LIMIT)
            raise InputError(
                f"{where}: mask.pattern: error-diffused: one dot of {side / um:.3g} µm is "
                f"{share:.2g} of a groove of {mask.length:g} mm: expected at most {RATIO_LIMIT:g}: "
                f"a panel of {length:.3g} mm or more, a smaller mask.dot_um, or another pattern"
            )


def _refuse_frame(job: Job, artwork: tuple[float, float], where: str) -> None:
    frame = job.mask.frame_mm
    if frame is not None and any(side < art for side, art in zip(frame, artwork, strict=True)):
        shown, least = (" x ".join(f"{side:g}" for side in size) for size in (frame, artwork))
        raise InputError(
            f"{where}: mask.frame_mm: {shown}: expected more than the artwork with its furniture, "
            f"{least} mm"
        )


def smallest_dot(mask: Mask) -> float:
    """Return the side of an error-diffused mask's dots [mm]."""
    side, _ = mask.smallest_features
    assert side is not None  # every dithered mask has its dot
    return side
