"""The assumed values of the 32-inch backlight, fitted to the published figures of the thesis.

`python benchmarks/fit_stack.py [--quick] [--json] [--out FILE]`. Traces 12 films in 24 stacks whose
values are all moved at once and in 8 at the centre, fits response surfaces to them, and those to
`thesis/published.toml`. Finished traces are kept in `exports/reproduction/`: a run that was stopped
goes on where it was. About 15 CPU-minutes; `--quick` half.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from thesis.film_case import EMPTY, POINTS, trace_points
from thesis.fit import REACH, fit_values, read_targets
from thesis.range_of_curvature import by_curvature
from thesis.response import HARMONICS, fit_surface, read_curve
from thesis.trial import FACTORS, FAMILIES, cases, screening_design, values_at

RESULT = Path(__file__).parent / "thesis" / "fit.json"
BLOCKS, REPEATS = 20, 2
CENTRES = 8
#: Of the first trial at the fitted values; beyond all others.
ANCHOR_SEED = 1001
#: One path's standard deviation over the mean (docs/tracing.md's blocks of 512 paths a point).
PATH_SPREAD = 1.8
#: Singular values below it hold nothing.
HELD = 0.1


def trial_codes(quick: bool) -> np.ndarray:
    """Return the codes of all trials, (n, 11): the design, then its centre, and all again."""
    once = np.vstack([screening_design(), np.zeros((CENTRES, len(FACTORS)))])
    return once if quick else np.vstack([once] * REPEATS)


def trace_trials(codes: np.ndarray, blocks: int, first: int = 1) -> dict[str, tuple]:
    """Return (codes, curvatures, readings) of each family; trial i has seed `first` + i."""
    found = {family: ([], [], []) for family in FAMILIES}
    for i, code in enumerate(codes):
        sys.stderr.write(f"\rtrial {i + 1} of {len(codes)} ")
        sys.stderr.flush()
        reference = 0.0
        for family in FAMILIES:
            for case in cases(family):
                traced = trace_points(case, values_at(code), blocks, first + i)
                reading = read_curve(
                    np.array(traced["luminance_cd_m2"]), np.array(traced["standard_error_cd_m2"])
                )
                if family == "conventional":
                    reference = reading[0]
                else:
                    # Relative to the conventional stack of the same trial.
                    reading[0] -= reference
                entry = (code, case.curvature, reading)
                for store, value in zip(found[family], entry, strict=True):
                    store.append(value)
    sys.stderr.write("\n")
    return {family: tuple(map(np.array, store)) for family, store in found.items()}


def fit_surfaces(trials: dict[str, tuple], blocks: int) -> dict:
    """Return the response surface of each family."""
    noise = PATH_SPREAD * np.sqrt(2 / (blocks * 512 * POINTS))
    return {family: fit_surface(*trial, noise) for family, trial in trials.items()}


def sensitivity(surfaces: dict, targets: list) -> list[dict]:
    """Return each target's change for one step up of each value, with its standard error."""
    rows, step = [], np.eye(len(FACTORS))

    def slope(of, target, i):
        return (target.ours(of, step[i]) - target.ours(of, -step[i])) / 2

    drawn = {name: surface.draws(40, 2) for name, surface in surfaces.items()}
    for target in targets:
        for i, factor in enumerate(FACTORS):
            spread = np.std([slope({target.family: s}, target, i) for s in drawn[target.family]])
            rows.append(
                {"target": target.name, "value": factor.name,
                 "change": slope(surfaces, target, i), "standard_error": float(spread)}
            )  # fmt: skip
    return rows


def turns(surfaces: dict, near: dict, fitted: np.ndarray) -> list[dict]:
    """Return how luminance goes with curvature where the thesis has it fall, and what moves it."""

    def ratio(of, code, family, high, low):
        return float(np.exp(of[family](code, high)[0] - of[family](code, low)[0]))

    rows, step = [], np.eye(len(FACTORS))
    for what in (("mpf", 70.0, 60.0), ("plate", 81.0, 67.0)):
        change = [(ratio(surfaces, s, *what) - ratio(surfaces, -s, *what)) / 2 for s in step]
        most = int(np.argmax(np.abs(change)))
        rows.append(
            {"family": what[0], "curvatures_per_mm": what[1:],
             "at_centre": ratio(surfaces, 0 * fitted, *what), "fitted": ratio(near, fitted, *what),
             "moved_most_by": FACTORS[most].name, "change": change[most]}
        )  # fmt: skip
    return rows


def run(quick: bool) -> dict:
    """Return the whole result as plain values."""
    codes = trial_codes(quick)
    surfaces = fit_surfaces(trace_trials(codes, BLOCKS), BLOCKS)
    targets = read_targets()
    found = fit_values(surfaces, targets, len(FACTORS))
    # Luminance is not quite linear: traced again where the first fit ends, and fitted again there.
    there = np.tile(found.code, (CENTRES, 1))
    anchor = trace_trials(there, BLOCKS, first=ANCHOR_SEED)
    near = {name: surface.anchored(*anchor[name]) for name, surface in surfaces.items()}
    fit = fit_values(near, targets, len(FACTORS))
    centre = np.zeros(len(FACTORS))
    names = [factor.name for factor in FACTORS]
    return {
        "trials": len(codes),
        "paths_a_trace": BLOCKS * 512 * POINTS,
        "reach": REACH,
        "values": [
            {
                "name": factor.name, "centre": factor.centre,
                "low_step": factor.value(-1), "high_step": factor.value(1),
                "fitted": factor.value(fit.code[i]), "code": fit.code[i],
                "interval": [factor.value(c) for c in fit.interval[i]],
                "data_interval_code": fit.data_interval[i].tolist(), "held": fit.held[i],
            }
            for i, factor in enumerate(FACTORS)
        ],
        "directions": [
            {"singular": s, "combination": dict(zip(names, d.tolist(), strict=True))}
            for s, d in zip(fit.singular, fit.direction, strict=True)
            if s > HELD
        ],
        "targets": [
            {
                "name": t.name, "published": t.value, "kind": t.kind, "residual": fit.residual[i],
                "standard_error": float(fit.error[i]),
                "residual_at_centre": t.residual(t.ours(surfaces, centre), 0.0),
                "at_centre": t.ours(surfaces, centre), "fitted": t.ours(near, fit.code),
            }
            for i, t in enumerate(targets)
        ],
        "by_curvature": {
            name: {family: by_curvature(of[family], at) for family in ("mpf", "plate")}
            for name, of, at in (("centre", surfaces, centre), ("fitted", near, fit.code))
        },
        "conventional_cd_m2": float(np.exp(near["conventional"](fit.code, EMPTY)[0])),
        "misfit": {name: s.misfit.tolist() for name, s in surfaces.items()},
        "turns": turns(surfaces, near, fit.code),
        "sensitivity": sensitivity(surfaces, targets),
        "harmonics": HARMONICS,
    }  # fmt: skip


def show(result: dict) -> None:
    """Print the result as tables."""
    print(f"{'value':30} {'centre':>9} {'fitted':>9} {'95 % with prior':>20}  data alone   held")
    for row in result["values"]:
        low, high = row["interval"]
        alone = " … ".join(
            "free" if abs(c) >= result["reach"] else f"{c:+.2f}" for c in row["data_interval_code"]
        )
        print(f"{row['name']:30} {row['centre']:9.4g} {row['fitted']:9.4g} "
              f"{low:9.4g} … {high:8.4g}  {alone:18}  {row['held']:.2f}")  # fmt: skip
    print(f"\n{'published figure':48} {'published':>9} {'centre':>8} {'fitted':>8} {'off by σ':>8}")
    for row in result["targets"]:
        sign = {"equal": " ", "at_most": "≤", "at_least": "≥"}[row["kind"]]
        print(f"{row['name']:48} {sign}{row['published']:8.4f} {row['at_centre']:8.4f} "
              f"{row['fitted']:8.4f} {row['residual']:8.2f}")  # fmt: skip
    print("\ncombinations (steps), the best held first")
    for row in result["directions"]:
        parts = sorted(row["combination"].items(), key=lambda item: -abs(item[1]))[:5]
        print(f"  ±{1 / row['singular']:7.2f}  "
              + " ".join(f"{weight:+.2f} {name}" for name, weight in parts))  # fmt: skip


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="half of the trials")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("--out", type=Path, help="also write the JSON into a file")
    given = parser.parse_args()
    result = run(given.quick)
    text = json.dumps(result, indent=1, ensure_ascii=False)
    if given.out:
        given.out.write_text(text + "\n", "utf-8")
    if given.json:
        print(text)
    else:
        show(result)


if __name__ == "__main__":
    main()
