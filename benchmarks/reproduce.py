"""Every published figure of the thesis beside ours: writes docs/reproduction.md.

`python benchmarks/reproduce.py [--quick] [--page] [--out FILE]`. Traces the thesis's films with the
presets `thesis-32in-*` and the fitted ones, `thesis-fitted-*`, writes `thesis/results.json` and of
it, and of the fits `thesis/fit-*.json` (`mpfcad fit thesis/fit-*.toml`), the page and its picture.
Finished traces are kept in `exports/reproduction/`, named for the code that made them and all that
they depend on: a run that was stopped goes on where it was, and nothing old is taken for new.
About 10 CPU-minutes; `--quick` half, with wider intervals; `--page` traces nothing.
"""

import argparse
import json
import sys
from pathlib import Path

from thesis.by_curvature import HARMONICS
from thesis.fill_case import fill_cases
from thesis.film_case import CACHE, EMPTY, PRINTED, Case, describe, file_hash, keep
from thesis.page import page
from thesis.picture import draw_curvature
from thesis.two_fits import NAMES

ROOT = Path(__file__).parents[1]
HERE = Path(__file__).parent / "thesis"
RESULTS = HERE / "results.json"
PAGE = ROOT / "docs" / "reproduction.md"
SETS = ("thesis-32in", "thesis-fitted")
#: Half-width of the contrast's interval, and the most paths.
EFFORT = {"standard": (0.002, 4_000_000), "quick": (0.004, 1_500_000)}
JOB = ROOT / "masks" / "patterned-16mm.toml"


def uniform_cases(values: str) -> list[Case]:
    """Return the thesis's uniform films in the stacks of one set of values."""
    films = [("conventional", "filled", EMPTY), ("bef", "filled", EMPTY)]
    films += [("mpf", "ideal", c) for c in (50.0, 57.0, 60.0, 65.0, 70.0, 81.0)]
    films += [("mpf-plate", "ideal", c) for c in (50.0, 60.0, 67.0, 81.0)]
    films += [("mpf", "filled", c) for c in (45.13, 60.0)]
    films += [("mpf-plate", "filled", PRINTED)]
    return [Case(f"{s} {p} {c:g}", f"{values}-{s}", p, c) for s, p, c in films]


def trace_case(stack, mesh, offset: float, effort: tuple) -> dict:
    """Return contrast, mean luminance [cd/m²] and harmonics, each as [value, low, high]."""
    from mpfcad.measure import TraceRun, light_film, luminance_over_pitch

    half_width, limit = effort
    lit = light_film(stack, mesh, offset)
    found = luminance_over_pitch(lit, TraceRun(path_limit=limit), half_width_goal=half_width)
    mean = found.fit.mean.value
    # The coefficients are the mean, then cosine and sine of each order.
    cosines = [found.fit.amplitude(2 * order - 1) for order in range(1, HARMONICS + 1)]
    return {
        "contrast": [found.contrast.value, found.contrast.low, found.contrast.high],
        "luminance_cd_m2": [
            found.mean_luminance.value, found.mean_luminance.low, found.mean_luminance.high
        ],
        "harmonics": [[a.value / mean, a.low / mean, a.high / mean] for a in cosines],
        "paths": found.paths,
    }  # fmt: skip


def trace_uniform(case: Case, effort: tuple) -> dict:
    """Return the figures of a uniform film, from disk if they are there."""
    stack = case.stack()
    identity = [*case.identity(stack), effort]
    return keep("case", identity, lambda: trace_case(stack, case.mesh(), 0.0, effort))


def trace_patterned(values: str, effort: tuple) -> dict:
    """Return the figures of the patterned film of 16 mm, made as its job makes it."""
    from mpfcad.backlight import read_stack
    from mpfcad.cad import write_stl
    from mpfcad.job import read_job
    from mpfcad.pipeline.plan.plan import read_plan

    plan = read_plan(read_job(JOB), JOB)
    stack = read_stack(f"{values}-mpf", thickness=plan.stack.thickness)
    path = CACHE / "patterned-16mm.stl"
    CACHE.mkdir(parents=True, exist_ok=True)
    write_stl(plan.piece, path, plan.job.cad.angle_tolerance)
    identity = [describe(stack), file_hash(path), plan.offset, effort]
    return keep("case", identity, lambda: trace_case(stack, path, plan.offset, effort))


def run(name: str) -> dict:
    """Return the figures of every case in every set, at an effort of `EFFORT`."""
    effort, results = EFFORT[name], {}
    for values in SETS:
        results[values] = {}
        for case in [*uniform_cases(values), *fill_cases(values)]:
            sys.stderr.write(f"{values}: {case.name}\n")
            results[values][case.name] = trace_uniform(case, effort)
        sys.stderr.write(f"{values}: patterned-16mm\n")
        results[values]["patterned-16mm"] = trace_patterned(values, effort)
    half_width, limit = effort
    return {
        "effort": name, "half_width_goal": half_width, "path_limit": limit, "set": results
    }  # fmt: skip


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="fewer paths")
    parser.add_argument("--page", action="store_true", help="only write the page again")
    parser.add_argument("--out", type=Path, default=PAGE, help="the page [docs/reproduction.md]")
    given = parser.parse_args()
    if not given.page:
        results = run("quick" if given.quick else "standard")
        RESULTS.write_text(json.dumps(results, indent=1) + "\n", "utf-8")
    results = json.loads(RESULTS.read_text("utf-8"))
    fits = {n: json.loads((HERE / f"fit-{n}.json").read_text("utf-8")) for n in NAMES}
    picture = given.out.with_suffix(".svg")
    given.out.write_text(page(results, fits, picture.name), "utf-8")
    picture.write_text(draw_curvature(results), "utf-8")


if __name__ == "__main__":
    main()
