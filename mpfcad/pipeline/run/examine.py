"""Finds out what the files of an export are worth: everything is read back from the folder.

`run_job` and `verify_export` both call `examine`, so what is verified is what was shipped.
"""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight import Stack, read_stack
from mpfcad.cad import Agreement, MeshCheck, StepCheck
from mpfcad.cad.check.library import LibraryCheck
from mpfcad.export import sha256
from mpfcad.film import Groove, PrismFilm
from mpfcad.gate import Gate
from mpfcad.mask import Mask, MaskCheck
from mpfcad.mask.screen.printing import Printing
from mpfcad.measure import (
    CellResult,
    Checkpoints,
    ColourResult,
    Lit,
    Survey,
    TraceRun,
    light_film,
    refuse_sheetless,
    screen_colour,
    survey_directions,
)
from mpfcad.pipeline.confidence.find import find_confidence
from mpfcad.pipeline.confidence.printed import find_printed
from mpfcad.pipeline.effort import TraceSetting, available_threads
from mpfcad.pipeline.estimator import note_estimator
from mpfcad.pipeline.kind import Print, kind_of
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.plan.printed.printing import plan_printing
from mpfcad.pipeline.progress import Progress
from mpfcad.pipeline.psf import describe_psf, has_zones
from mpfcad.pipeline.run.facet import facet_convergence
from mpfcad.pipeline.run.file_check import FileFindings, Solid, examine_files, examine_foreign
from mpfcad.pipeline.run.make import write_mask_pictures
from mpfcad.pipeline.run.plain import Traced, trace_luminance, trace_plain
from mpfcad.record import ResinCheck, describe_estimator

#: Standard error of u', v' of a point at which the trace of its colour ends, over the goal of the
#: contrast.
COLOUR_GOAL = 0.25
#: The thesis's own reference.
BASELINE_PRESET = "thesis-32in-conventional"
#: Standard error at which the maps of single LEDs end, over the half-width of the contrast.
_BIN_GOAL = 4.0


@dataclass(frozen=True, eq=False)
class FilmFindings:
    """What the files of one film turned out to be; `Findings` says what each is.

    Attributes
    ----------
    files
        its masks and CAD files
    sha256
        hash of the file that was traced
    """

    files: FileFindings
    curvature_difference: float | None
    resin: ResinCheck | None
    sha256: str
    wanted_ratio: NDArray[np.float64] | None
    printing: Printing | None


@dataclass(frozen=True, eq=False)
class Findings:
    """What the files of an export turned out to be.

    Attributes
    ----------
    mask
        check of each mask file by its name; empty without a mask
    step, mesh
        checks of film.step and film.stl; None where the file does not read back as one
    agreement
        film.step against film.stl; None unless both do
    gates
        of the files
    curvature_difference
        largest |C of the mask - C of the facets| [1/mm] over the grooves of the piece; for a film
        without mask the map's C stands in for the mask's; where curvatures vary along the grooves,
        that of their means in the mask from the map's, plus that of the facets from the map's;
        None of a measured surface
    resin
        resin by the masks and in film.stl; None without a mask
    traced_sha256
        hash of the mesh file as it was traced
    wanted_ratio
        (n,) float64, mean aperture ratio that each groove of the panel should have; None without
        mask
    luminance, plain, baseline
        of this film (None where film.stl cannot be traced), of its prisms without resin in the same
        backlight, and of a plain BEF in the job's `[baseline]`; without one again of its prisms
    printing
        what the screen prints; None without a mask
    confidence
        how likely the limits are met, in outside names; None where the job does not ask for it
    printed
        the same over what the process does not know of its print; None where that is not known,
        and where the confidence holds it already
    survey
        of this film's luminance over direction; None where the path limit has no room for it
    facets
        how a few grooves' mesh closes in on the film, in outside names; None of a film in one piece
    colour
        over the pitch; None without bands
    library
        check of film.3mf, a film of instances
    crossed
        of the files of the printed film that lies across, if there is one
    psf
        what one LED and one zone do, in outside names; None of a board without zones
    """

    mask: dict[str, MaskCheck]
    step: StepCheck | None
    mesh: MeshCheck | None
    agreement: Agreement | None
    gates: list[Gate]
    curvature_difference: float | None
    resin: ResinCheck | None
    traced_sha256: str
    wanted_ratio: NDArray[np.float64] | None
    luminance: Traced | None
    plain: Traced
    baseline: Traced
    printing: Printing | None = None
    confidence: dict[str, Any] | None = None
    printed: dict[str, Any] | None = None
    survey: Survey | None = None
    facets: list[dict[str, Any]] | None = None
    library: LibraryCheck | None = None
    crossed: FilmFindings | None = None
    psf: dict[str, Any] | None = None
    colour: ColourResult | None = None


def examine(
    folder: Path,
    plan: Plan,
    masks: Sequence[Mask | None],
    setting: TraceSetting,
    threads: int | None,
    checkpoints: Checkpoints,
    progress: Progress,
    *,
    foreign: bool = False,
) -> Findings:
    """Check and trace the files in `folder`, `masks` those of the plan's films.

    What a file misses is in its gates. `foreign` files, not written by this very run, are read in
    a process that may crash.
    """
    read = examine_foreign if foreign else examine_files
    films = [
        _judge_film(folder, film, mask, read(folder, film, mask, progress))
        for film, mask in zip(plan.films, masks, strict=True)
    ]
    own, crossed = films[0], films[1] if len(films) > 1 else None
    run = TraceRun(
        plan.job.seed, threads or available_threads(), setting.path_limit, checkpoints,
        progress.trace, judged=True,
    )  # fmt: skip
    luminance = survey = colour = psf = None
    if all(film.files.solid is not None for film in films):
        traced = traced_file(plan)
        progress.stage(f"tracing {traced}")
        lit = light_film(plan.lit_stack(folder), folder / traced, plan.offset)
        if lit.spot.is_rounded:
            progress.note(lit.spot.note)
        if has_zones(lit) and lit.spectral is None:
            refuse_sheetless(lit)
        luminance = trace_luminance(lit, run, setting.half_width_goal)
        if isinstance(luminance, CellResult):
            note_estimator(describe_estimator(luminance), progress)
        if not lit.is_cell:
            progress.stage(f"tracing {traced} over directions")
            survey = survey_directions(lit, run)
        if lit.spectral is not None:
            progress.stage(f"tracing {traced} for its colour")
            goal = setting.half_width_goal * COLOUR_GOAL
            colour = screen_colour(lit, run, goal, directions=False)
        if has_zones(lit) and lit.spectral is None:
            progress.stage(f"tracing {traced}, each LED by itself")
            psf = describe_psf(lit, run, _BIN_GOAL * setting.half_width_goal)
    progress.stage("tracing the film without resin")
    plain = trace_plain(plan, folder, run, setting.half_width_goal)
    baseline = plain
    if plan.job.baseline is not None:
        preset = plan.job.baseline.preset
        progress.stage(f"tracing a plain BEF in {preset}")
        lit = light_baseline(plan.job.cad.angle_tolerance, preset, plan.stack.polarised)
        baseline = trace_luminance(lit, run, setting.half_width_goal)
    confidence = printed = None
    if luminance is not None and plan.job.wants_confidence:
        confidence = find_confidence(folder, plan, luminance, run.threads, progress)
    elif luminance is not None:
        printed = find_printed(folder, plan, luminance, run.threads, progress)
    found = own.files
    return Findings(
        found.mask, found.step, found.mesh, found.agreement, found.gates,
        own.curvature_difference, own.resin, own.sha256, own.wanted_ratio, luminance, plain,
        baseline, own.printing, confidence, printed,
        survey, None if found.mesh is None else facet_convergence(plan), found.library, crossed,
        psf,
        colour,
    )  # fmt: skip


def traced_file(plan: Plan) -> str:
    """Return the name in an export of the file of a film that is traced."""
    kind = kind_of(plan.drawn, plan.job.cad)
    return plan.file("film", kind.run_formats[-1])


def _judge_film(folder: Path, plan: Plan, mask: Mask | None, found: FileFindings) -> FilmFindings:
    """Return what the files of one film, as they read back, are worth beside each other."""
    digest = sha256(folder / traced_file(plan))
    wanted = None if mask is None else mask.wanted_ratio
    printing = None
    if mask is not None and plan.process is not None:
        printing = plan_printing(plan.job, mask, plan.process)
    difference = resin = None
    if found.solid is not None:
        difference = compare_curvature(plan, found.mask, found.solid, wanted)
        resin = compare_resin(plan, found.mask, found.solid, wanted)
    return FilmFindings(found, difference, resin, digest, wanted, printing)


def compare_curvature(
    plan: Plan,
    masks: Mapping[str, MaskCheck],
    mesh: MeshCheck | Solid,
    wanted_ratio: NDArray[np.float64] | None,
) -> float | None:
    """Return max |C of the mask - C of the facets| [1/mm] over the piece's grooves.

    None of a measured surface, and where no mask reads back.
    """
    given = _printed(plan, masks, wanted_ratio)
    if mesh.curvature is None or (plan.process is not None and given is None):
        return None
    kind, piece = kind_of(plan.drawn, plan.job.cad), _grooves(plan)
    return kind.curvature_difference(mesh.curvature, plan.panel.curvature[piece], given)


def compare_resin(
    plan: Plan,
    masks: Mapping[str, MaskCheck],
    mesh: MeshCheck | Solid,
    wanted_ratio: NDArray[np.float64] | None,
) -> ResinCheck | None:
    """Return the resin that the masks give the piece, and that of the mesh; None without a mask."""
    given = _printed(plan, masks, wanted_ratio)
    if given is None:
        return None
    return kind_of(plan.drawn, plan.job.cad).resin(mesh.volume, given)


def _printed(
    plan: Plan, masks: Mapping[str, MaskCheck], wanted_ratio: NDArray[np.float64] | None
) -> Print | None:
    """Return what the masks give the piece's grooves; None where no mask reads back."""
    if plan.process is None or wanted_ratio is None or not masks:
        return None
    piece = _grooves(plan)
    ratio = {name: check.aperture_ratio[piece] for name, check in masks.items()}
    return Print(plan.process, ratio, wanted_ratio[piece])


def _grooves(plan: Plan) -> slice:
    return slice(plan.first_groove, plan.first_groove + plan.piece.groove_count)


def light_baseline(
    angle_tolerance: float, preset: str = BASELINE_PRESET, polarised: bool = False
) -> Lit:
    """Return a plain BEF, written to a file and read back, in a stack; polarised light or not."""
    from mpfcad.cad import write_stl

    stack = replace(read_stack(preset), polarised=polarised)
    with tempfile.TemporaryDirectory() as temporary:
        mesh = Path(temporary) / "bef.stl"
        write_stl(baseline_film(stack), mesh, angle_tolerance)
        return light_film(stack.with_bare(mesh), mesh)


def baseline_film(stack: Stack) -> PrismFilm:
    """Return the plain BEF of the thesis over one lamp pitch, or one groove under LEDs."""
    from mpfcad.pipeline.plan.size import groove_count

    groove = Groove(0.050, 0.025)
    count = 1 if stack.period.along > 0 else groove_count(stack.period.across, groove.pitch)
    empty = np.full(count, groove.curvature_empty)
    return PrismFilm(groove, base=0.2, length=2.0, profile="filled", curvature=empty)


def write_pictures(
    plan: Plan,
    masks: Sequence[Mask | None],
    findings: Findings,
    folder: Path,
    source: Path | None = None,
) -> None:
    """Write the picture of each film's mask and its markers; `source` as `write_mask_pictures`."""
    checks = [findings.mask]
    if findings.crossed is not None:
        checks.append(findings.crossed.files.mask)
    for film, mask, found in zip(plan.films, masks, checks, strict=True):
        write_mask_pictures(folder, found, mask, source, f"mask{film.suffix}")
