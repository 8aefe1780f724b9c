"""The confidence that an export under LEDs states, beside traces with drawn inputs.

`python benchmarks/confidence_led.py EXPORT JOB [--draws N] [--paths N] [--json]`: the export of
`mpfcad run JOB --confidence`. Draws all its inputs at once from their widths and traces the films
in each draw: prints are moved in the map, not by pieces, and written with their resin. All draws
have one seed, and so has a trace with the inputs as stated. What the export's slopes and second
orders add to that trace is *told*. Some two CPU seconds a draw.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from confidence import shares

#: Seed of the draws and of their traces: none of the program's own.
SEED = 20_000
LIMITS = (0.012, 0.018, 0.03)


def traced_and_told(export: Path, job_file: Path, draws: int, paths: int) -> dict:
    """Return what draws of the inputs have, traced, and as the export tells it."""
    from mpfcad.confidence import draw_steps
    from mpfcad.job import read_job
    from mpfcad.measure.cell.series import CellSeries
    from mpfcad.pipeline.confidence.cell_variant import MOVES, cell_variants_of
    from mpfcad.pipeline.plan.plan import read_plan

    job = read_job(job_file)
    plan = read_plan(job, job_file)
    record = json.loads((export / "verification.json").read_text())
    stated = {one["name"]: one for one in record["confidence"]["inputs"]}
    with cell_variants_of(plan, export) as variants:
        factors = [f for f in variants.factors() if f.name in stated]
        nominal = _trace(variants, {}, record, paths)
    steps = draw_steps(factors, np.eye(len(factors)), SEED, draws)
    found = []
    for number, row in enumerate(steps, 1):
        found.append(_drawn(job, job_file, export, factors, row, record, paths, MOVES))
        if number % 10 == 0:
            print(f"draw {number} of {draws}", file=sys.stderr, flush=True)
    order = _order(record)
    slope = np.array([stated[f.name]["effect_of_sigma"] for f in factors])
    none = np.zeros(slope.shape[1])
    bend = np.array([stated[f.name]["second_order"] or none for f in factors])
    told = nominal + steps @ slope + steps**2 @ bend
    place = np.arange(24) / 24
    u, v = (part.ravel() for part in np.meshgrid(place, place, indexing="ij"))
    fine = CellSeries(order, np.zeros(len(order)), np.zeros((0, 0)), 1.0, 0.0).at(u, v)[:, 1:]
    contrast = {name: _contrast(rows, fine) for name, rows in (("traced", found), ("told", told))}
    return {
        **contrast, "told_noisy": contrast["told"], "factors": len(factors),
        "terms": _terms(order[1:], np.array(found), told, nominal),
    }  # fmt: skip


def _order(record: dict) -> np.ndarray:
    """Return the terms whose effects the export states: its own, and sines where they are."""
    from mpfcad.pipeline.confidence.cell_runs import sines

    order = np.array(record["fit"]["order"])
    count = len(record["confidence"]["inputs"][0]["effect_of_sigma"])
    return order if len(order) == count + 1 else np.concatenate([order, sines(order)])


def _drawn(job, job_file, export, factors, row, record, paths, moves) -> np.ndarray:
    """Return the terms of one draw, from films that are mapped, printed and written anew."""
    from mpfcad.pipeline.confidence.cell_variant import cell_variants_of
    from mpfcad.pipeline.plan.departure import Departure, PrintError
    from mpfcad.pipeline.plan.plan import read_plan

    shift = np.zeros((2, 2))
    rest = {}
    for factor, z in zip(factors, row, strict=True):
        if factor.name in moves:
            move = moves[factor.name]
            shift[move.film, move.axis] = z * factor.sigma
        else:
            rest[factor] = float(z)
    films = tuple(PrintError(shift=(float(x), float(y))) for x, y in shift)
    plan = read_plan(job, job_file, Departure(films))
    with cell_variants_of(plan, export) as variants:
        return _trace(variants, rest, record, paths)


def _trace(variants, steps, record, paths) -> np.ndarray:
    from mpfcad.measure import trace_terms
    from mpfcad.measure.cell.estimator import Estimator
    from mpfcad.pipeline.effort import available_threads

    lit = variants.light(steps)
    value, _, _ = trace_terms(
        lit, _order(record), paths, SEED, available_threads(), Estimator.forward
    )
    return value[1:] / value[0]


def _contrast(found, fine) -> list[float]:
    curve = 1 + np.asarray(found) @ fine.T
    high, low = curve.max(axis=1), curve.min(axis=1)
    return ((high - low) / (high + low)).tolist()


def _terms(order, found, told, nominal) -> list[dict]:
    """Return of each term how far draws move it, and by how much what is told is off."""
    rows = []
    for number, (i, j) in enumerate(order.tolist()):
        off = found[:, number] - told[:, number]
        rows.append({
            "term": [i, j],
            "traced_sd": float(np.std(found[:, number])),
            "told_sd": float(np.std(told[:, number])),
            "off_rms": float(np.sqrt(np.mean(off**2))),
            "bias": float(off.mean()),
            "correlation": float(np.corrcoef(found[:, number], told[:, number])[0, 1]),
        })  # fmt: skip
    return sorted(rows, key=lambda row: -row["told_sd"])


def main() -> int:
    """Print shares of draws within limits, and the terms that move most."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("export", type=Path)
    parser.add_argument("job", type=Path)
    parser.add_argument("--draws", type=int, default=60)
    parser.add_argument("--paths", type=int, default=130_000)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    found = traced_and_told(asked.export, asked.job, asked.draws, asked.paths)
    rows = shares(found, LIMITS)
    if asked.json:
        print(json.dumps({"shares": rows, **found}, indent=1))
        return 0
    for row in rows:
        low, high = row["ci95"]
        print(
            f"contrast within {row['limit']}: traced {row['traced']:.3f} [{low:.3f}, {high:.3f}] "
            f"of {asked.draws}; told {row['told']:.3f}"
        )
    for row in found["terms"][:6]:
        print(
            f"term {row['term']}: draws move it by {row['traced_sd']:.4f} traced, "
            f"{row['told_sd']:.4f} told; off by {row['off_rms']:.4f}, bias {row['bias']:+.4f}, "
            f"correlation {row['correlation']:.2f}"
        )
    print(f"{found['factors']} inputs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
