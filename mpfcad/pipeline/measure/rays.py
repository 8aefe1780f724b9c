"""`write_rays`: the light of a case as a ray file, which appears whole or not at all."""

from pathlib import Path
from typing import Any

import mpfcad
from mpfcad.backlight.source.ray_layout import FORMS
from mpfcad.backlight.source.ray_write import About, Keep, check_ray_suffix, write_ray_file
from mpfcad.errors import InputError
from mpfcad.export import sha256
from mpfcad.mask.whole import whole_file
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
    if out.is_dir():
        raise InputError(f"--out: {out}: is a folder: expected a file")
    gate_of(case.lit, at)
    run = TraceRun(
        seed, threads or available_threads(), checkpoints=Checkpoints(), progress=progress.trace
    )
    found: list[RayResult] = []

    def collect(keep: Keep) -> float:
        found.append(collect_rays(case.lit, at, count, run, keep))
        return found[0].unit

    progress.stage(f"{case.name} in {case.lit.stack.name}: light that {_WORDS[at]}")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(out) as part:
            write_ray_file(part, suffix, _about(case, at, seed), collect)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror or error}") from None
    result = found[0]
    return {
        "schema": 1, "file": str(out), "form": FORMS[suffix], "sha256": sha256(out),
        "film": case.film, "stack": case.lit.stack.name, "at": at, "unit": "mm", "seed": seed,
        "rays": result.rays, "paths": result.paths, "flux_lm": describe_estimate(result.flux),
        "emitted_lm": case.lit.stack.source.flux,
    }  # fmt: skip


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
