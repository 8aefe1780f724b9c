"""Findings and plan -> verification.json: inputs with their tags, provenance, gates."""

from pathlib import Path
from typing import Any

import numpy as np

from mpfcad.backlight import PRISM_FILE
from mpfcad.backlight.stored import describe_stack, restore_stack
from mpfcad.export import sha256
from mpfcad.film import HalftoneField, Process
from mpfcad.job import FilmTable, Job
from mpfcad.mask import Mask
from mpfcad.mask.screen.levelled import LevelledWindow, levelled_window
from mpfcad.measure import CellResult, describe_eye
from mpfcad.measure.cell.visible import worst_harmonic
from mpfcad.pipeline.effort import TraceSetting
from mpfcad.pipeline.kind import kind_of
from mpfcad.pipeline.plan.cell_map import CELL_FILES
from mpfcad.pipeline.plan.halftone import describe_halftone
from mpfcad.pipeline.plan.plan import CURVATURE_FILE, Plan
from mpfcad.pipeline.plan.printed.printing import job_print_limits
from mpfcad.pipeline.plan.restored import stored_job
from mpfcad.pipeline.run.examine import Findings, traced_file
from mpfcad.pipeline.run.make import MARKERS, MASK_FORMATS, PICTURE, left_out
from mpfcad.pipeline.run.plain import Traced
from mpfcad.record import (
    Checks,
    build_gates,
    build_verification,
    colour_gate,
    confidence_gate,
    describe_colour,
)
from mpfcad.record.verdict import in_order
from mpfcad.report import Evidence

#: What the names of the films' files have after their first word.
FILMS = ("", "-crossed")
#: Job tables whose values are inputs of the result, and where their defaults come from.
DEFAULT_SOURCES = {
    "map": ("given", "the job"),
    "film": ("sourced", "Hsieh, MPF thesis: BEF of 25 µm × 50 µm, index-matched resin"),
    "mask": ("assumed", "default: usual screen-printing limits"),
    "cad": ("assumed", "default"),
    "halftone": ("assumed", "default"),
    "gates": ("assumed", "default: what usually prints (docs/process.md)"),
}
#: Defaults that come from somewhere else than the rest of their table.
OWN_SOURCES = {
    ("gates", name): ("sourced", f"Hsieh, MPF thesis: {words}")
    for name, words in (
        ("contrast_pass", "the conventional stack's own contrast"),
        ("contrast_marginal", "acceptance limit"),
    )
}


def build_record(
    folder: Path,
    plan: Plan,
    findings: Findings,
    setting: TraceSetting,
    provenance: dict[str, Any],
) -> dict[str, Any]:
    """Return verification.json of the files in `folder`."""
    job = plan.job
    hashes = file_hashes(folder)
    traced = traced_file(plan)
    checks = Checks(
        findings.mask,
        findings.step,
        findings.mesh,
        findings.agreement,
        findings.gates,
        findings.curvature_difference,
        findings.resin,
        findings.traced_sha256 == hashes[traced],
        findings.printing,
        findings.library,
        traced,
        _crossed_checks(plan, findings, hashes),
    )
    gates = build_gates(
        checks,
        findings.luminance,
        contrast_pass=job.gates.contrast_pass,
        contrast_marginal=job.gates.contrast_marginal,
        print_limits=job_print_limits(job),
    )
    if findings.confidence is not None and job.gates.confidence_min is not None:
        gates.insert(1, confidence_gate(findings.confidence, job.gates.confidence_min))
    colour = describe_findings_colour(plan, findings)
    if job.gates.colour_max is not None:
        gates = in_order([*gates, colour_gate(colour, job.gates.colour_max, traced)])
    halftones = describe_halftones(plan)
    words = [f"film{name}: {one['words']}" for name, one in zip(FILMS, halftones, strict=False)]
    return build_verification(
        name=job.name,
        gates=gates,
        checks=checks,
        seed=job.seed,
        distance=job.mask.viewing_distance_mm,
        luminance=findings.luminance,
        plain=findings.plain,
        baseline=findings.baseline,
        baseline_stack=job.baseline.preset if job.baseline else plan.stack.name,
        baseline_is_own=job.baseline is None,
        eye=_eye(plan, findings.luminance),
        confidence=findings.confidence,
        printed=findings.printed,
        survey=findings.survey,
        psf=findings.psf,
        facets=findings.facets,
        colour=colour,
        halftone=halftones,
        notes=[*left_out(plan), *words],
        inputs=list_inputs(plan),
        process=plan.process.describe() if plan.process else None,
        curvature=compare_curvature(plan, findings),
        provenance={
            "sha256": hashes,
            "traced": {
                "file": traced,
                "sha256": findings.traced_sha256,
                "offset_mm": plan.offset,
            },
            **provenance,
        },
        job={**stored_job(plan), "trace": setting.document()},
    )


def describe_findings_colour(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    """Return the colour of a film in light of bands; None without bands or a trace."""
    if findings.colour is None or plan.stack.bands is None:
        return None
    return describe_colour(findings.colour, plan.stack.bands.wavelength)


def describe_halftones(plan: Plan) -> list[dict[str, Any]]:
    """Return the halftone of each film in outside names; none of a job without."""
    found = []
    for film in plan.films:
        field = None if film.field_film is None else film.field_film.field
        if isinstance(field, HalftoneField):
            found.append(describe_halftone(film.job, field.halftone, field.piece, film.where))
    return found


def _eye(plan: Plan, found: Traced | None) -> dict[str, Any] | None:
    """Return the eye's threshold for stripes of the lamp pitch, or of a cell's worst harmonic."""
    if found is None:
        return None
    pitch, distance = plan.stack.period.across, plan.job.mask.viewing_distance_mm
    if isinstance(found, CellResult):
        worst = worst_harmonic(found.series, found.size, distance)
        pitch = pitch if worst is None else worst.wavelength
    return describe_eye(pitch, distance, found.mean_luminance.value)


def _crossed_checks(plan: Plan, findings: Findings, hashes: dict[str, str]) -> Checks | None:
    """Return what the files of the film that lies across are, if there is one."""
    found = findings.crossed
    if found is None or plan.crossed is None:
        return None
    files, traced = found.files, traced_file(plan.crossed)
    return Checks(
        files.mask, files.step, files.mesh, files.agreement, files.gates,
        found.curvature_difference, found.resin, found.sha256 == hashes[traced], found.printing,
        files.library, traced,
    )  # fmt: skip


def compare_curvature(plan: Plan, findings: Findings) -> dict[str, Any] | None:
    """Return the piece's curvatures as wanted and as each mask file gives them; None without mask.

    The largest difference is that over all grooves of the panel and all files.
    """
    if plan.process is None or not findings.mask:
        return None
    piece = slice(plan.first_groove, plan.first_groove + plan.piece.groove_count)
    wanted = plan.panel.curvature
    if plan.printed.varies_along and findings.wanted_ratio is not None:
        # What the mask has of a groove is one ratio: the curvature that its mean would give.
        wanted = plan.process.curvature(findings.wanted_ratio)
    found = {
        name: plan.process.curvature(check.aperture_ratio) for name, check in findings.mask.items()
    }
    return {
        "first_groove": plan.first_groove,
        "wanted_per_mm": [float(value) for value in wanted[piece]],
        "recovered_per_mm": {
            name: [float(value) for value in values[piece]] for name, values in found.items()
        },
        "difference_max_per_mm": max(
            float(np.abs(values - wanted).max()) for values in found.values()
        ),
    }


def gather_evidence(folder: Path, plan: Plan, mask: Mask | None, findings: Findings) -> Evidence:
    """Return what the report shows besides verification.json."""
    piece = slice(plan.first_groove, plan.first_groove + plan.piece.groove_count)
    check = next(iter(findings.mask.values()), None)
    return Evidence(
        folder=folder,
        # As the export states it: a layer's file goes by its name in there.
        stack=restore_stack(describe_stack(plan.stack)),
        panel=plan.panel,
        piece=plan.piece,
        kind=kind_of(plan.drawn, plan.job.cad),
        first_groove=plan.first_groove,
        lamp_position=plan.lamp_position,
        mask_period=plan.job.mask.period if mask is None else mask.period,
        aperture_ratio=None if check is None else check.aperture_ratio[piece],
        levelled=_level(folder, plan, mask, findings),
        traced=traced_file(plan),
    )


def _level(
    folder: Path, plan: Plan, mask: Mask | None, findings: Findings
) -> LevelledWindow | None:
    """Return grooves about the one that ripples most, read from the first mask file."""
    if mask is None or plan.process is None or findings.printing is None or not findings.mask:
        return None
    return levelled_window(
        folder / next(iter(findings.mask)), plan.process, mask.pitch, mask.period,
        findings.printing.levelling_length, findings.printing.ripple_groove,
    )  # fmt: skip


def file_hashes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of every file that was made before verification.json, by name."""
    masks = [
        f"mask{film}.{suffix}" for film in FILMS for suffix in (*MASK_FORMATS, PICTURE, MARKERS)
    ]
    films = ["film.step", "film.stl", *(f"film{film}.3mf" for film in FILMS)]
    meshes = (PRISM_FILE, *(path.name for path in sorted(folder.glob("stack-*.stl"))))
    made = (*masks, *films, *meshes, CURVATURE_FILE, *CELL_FILES)
    return {name: sha256(folder / name) for name in made if (folder / name).is_file()}


def list_inputs(plan: Plan) -> list[dict[str, Any]]:
    """Return every input of the result, each tagged `given`, `sourced` or `assumed`."""
    inputs = [
        entry
        for table in DEFAULT_SOURCES
        for entry in _table_inputs(plan.job, table)
        if table != "mask" or plan.is_printable
    ]
    if plan.process is not None:
        inputs.append(_process_input(plan.job, plan.process))
    stack = [{**entry, "name": f"stack.{entry['name']}"} for entry in plan.stack.inputs()]
    return inputs + stack


def _table_inputs(job: Job, table: str) -> list[dict[str, Any]]:
    model = getattr(job, table)
    if model is None:
        return []
    stated = model.model_fields_set if table in job.model_fields_set else set()
    return [
        {"name": f"{table}.{key}", "value": value, **_origin(model, table, key, stated)}
        for key, value in model.model_dump(mode="json").items()
        if value is not None
        and not (table == "film" and key in FilmTable.UNUSUAL and key not in stated)
    ]


def _origin(model: Any, table: str, key: str, stated: set[str]) -> dict[str, str]:
    """Return tag and source of a value: stated, default, or of a groove from two others."""
    tag, source = OWN_SOURCES.get((table, key), DEFAULT_SOURCES[table])
    if key in stated:
        return {"tag": "given", "source": "the job"}
    if table == "film" and key == model.derived_field and stated & set(FilmTable.GROOVE):
        others = [name for name in FilmTable.GROOVE if name != key]
        if set(others) <= stated:
            tag = "given"
        return {"tag": tag, "source": f"follows from {' and '.join(others)}"}
    return {"tag": tag, "source": source}


def _process_input(job: Job, process: Process) -> dict[str, Any]:
    given = job.process.calibration is not None
    factor = process.transfer_factor
    return {
        "name": "process.transfer_factor" if factor is not None else "process.table",
        "value": factor if factor is not None else f"{len(process.knot_ratio)} rows",
        "tag": "given" if given else "sourced",
        "source": " Note: ".join([process.source, "; ".join(process.caveats)]),
    }
