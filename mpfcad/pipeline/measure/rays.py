"""`write_rays`: the light of a case as a ray file, which appears whole or not at all."""

from pathlib import Path
from typing import Any

import mpfcad
from mpfcad.backlight.source.ray_layout import FORMS
from mpfcad.backlight.source.ray_write import (
    BEGINNINGS,
    About,
    Keep,
    check_ray_suffix,
    write_ray_file,
)
from mpfcad.boundary.out import asked_file, check_out
from mpfcad.errors import InputError
from mpfcad.export import sha256
from mpfcad.measure import Checkpoints, TraceRun
from mpfcad.measure.rays import At, RayResult, collect_rays, gate_of
from mpfcad.pipeline.effort import available_threads
from mpfcad.pipeline.measure.case import Case
from mpfcad.pipeline.progress import SILENT, Progress

_WORDS = {"screen": "leaves the screen", "film": "comes up to the film"}


def write_rays(
    case: Case,
    out: Path,
    at: At,
    count: int,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress = SILENT,
) -> dict[str, Any]:
    """Write `count` rays of a case's light to a ray file, by its ending; return a record.

    Raises
    ------
    InputError
        when the ending is unknown, the file cannot be written, or the stack has no such place.
    """
    from mpfcad.record import describe_estimate

    out = Path(out)
    suffix = check_ray_suffix("--out", out)
    check_out("--out", out, BEGINNINGS[suffix])
    _refuse_source(case, out)
    gate_of(case.lit, at)
    run = TraceRun(
        seed, threads or available_threads(), checkpoints=Checkpoints(), progress=progress.trace
    )
    found: list[RayResult] = []

    def collect(keep: Keep) -> float:
        found.append(collect_rays(case.lit, at, count, run, keep))
        return found[0].unit

    progress.stage(f"{case.name} in {case.lit.stack.name}: light that {_WORDS[at]}")
    with asked_file(out) as part:
        write_ray_file(part, suffix, _about(case, at, seed), collect)
    result = found[0]
    return {
        "schema": 1, "file": str(out), "form": FORMS[suffix], "sha256": sha256(out),
        "film": case.film, "stack": case.lit.stack.name, "at": at, "unit": "mm", "seed": seed,
        "rays": result.rays, "paths": result.paths, "flux_lm": describe_estimate(result.flux),
        "emitted_lm": case.lit.stack.source.flux,
    }  # fmt: skip


def _refuse_source(case: Case, out: Path) -> None:
    """Refuse to replace a file that the light source is read from."""
    sources = case.lit.stack.spec.describe().get("files", {})
    if out.is_file() and sha256(out) in sources.values():
        raise InputError(f"--out: {out}: is the light source's own file: expected another file")


def _about(case: Case, at: At, seed: int) -> About:
    """Return what the file says of itself."""
    stack = case.lit.stack
    size = stack.source.lit_size
    return About(
        f"{case.name} in {stack.name}",
        f"mpfcad {mpfcad.__version__}",
        f"{stack.title}. Light that {_WORDS[at]}, in lm. Places in mm about the panel's middle, x "
        f"across the {stack.source.word}s, z = 0 there, light toward +z. "
        f"{size.across:g} x {size.along:g} mm. Seed {seed}.",
    )
