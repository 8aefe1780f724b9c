"""The confidence that an export under LEDs states, beside traces with drawn inputs.

`python benchmarks/confidence_led.py EXPORT JOB [--draws N] [--paths N] [--json]`: the export of
`mpfcad run JOB --confidence`. Draws all its inputs at once from their widths and traces the films
in each draw with random numbers of its own: prints are moved in the map, not by pieces, and written
with their resin. *Told*: the export's own series with its slopes and second orders at the same
draws; noise of such a trace raises contrasts, so what is told gets it too. Some four CPU seconds a
draw.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from confidence import shares

#: Seed of the draws and of their traces: none of the program's own.
SEED = 20_000
LIMITS = (0.018, 0.03, 0.04, 0.05)


def traced_and_told(export: Path, job_file: Path, draws: int, paths: int) -> dict:
    """Return what draws of the inputs have, traced, and as the export tells it."""
    from mpfcad.confidence import draw_steps
    from mpfcad.job import read_job
    from mpfcad.pipeline.confidence.cell_variant import cell_variants_of
    from mpfcad.pipeline.plan.plan import read_plan

    job = read_job(job_file)
    record = json.loads((export / "verification.json").read_text())
    stated = {one["name"] for one in record["confidence"]["inputs"]}
    with cell_variants_of(read_plan(job, job_file), export) as variants:
        factors = [f for f in variants.factors() if f.name in stated]
    steps = draw_steps(factors, np.eye(len(factors)), SEED, draws)
    order = _order(record)
    found, spread = [], 0.0
    for number, row in enumerate(steps, 1):
        drawn = _drawn(job, job_file, export, factors, row)
        value, covariance = _trace(*drawn, order, paths, SEED + number)
        found.append(value)
        spread = spread + covariance / draws
        if number % 10 == 0:
            print(f"draw {number} of {draws}", file=sys.stderr, flush=True)
    return compared(record, [f.name for f in factors], steps, np.array(found), spread)


def compared(record: dict, names: list, steps, found, spread) -> dict:
    """Return traced contrasts, those told with noise and without, and the terms that move."""
    order = _order(record)
    best = _response(record, names, order).shrunk()
    told = best.start + steps @ best.slope + steps**2 @ best.bend
    rng = np.random.Generator(np.random.Philox(SEED))
    value, vector = np.linalg.eigh(spread)
    noise = rng.standard_normal((50, *told.shape)) @ (vector * np.sqrt(np.maximum(value, 0))).T
    noisy = (told + noise).reshape(-1, told.shape[1])
    return {
        "traced": _contrast(found, best.basis), "told": _contrast(told, best.basis),
        "told_noisy": _contrast(noisy, best.basis), "factors": len(names),
        "terms": _terms(order[1:], found, told, np.sqrt(np.diag(spread))),
    }  # fmt: skip


def _response(record: dict, names: list, order):
    """Return the response that an export states; of the second order no noise is in it."""
    from mpfcad.confidence import Response
    from mpfcad.measure.cell.series import CellSeries

    one = {i["name"]: i for i in record["confidence"]["inputs"]}
    slope = np.array([one[name]["effect_of_sigma"] for name in names])
    spread = np.array([np.diag(np.square(one[name]["standard_error"])) for name in names])
    bend = np.array([one[name]["second_order"] or 0 * slope[0] for name in names])
    own = np.array(record["fit"]["coefficient_cd_m2"])
    start = np.concatenate([own[1:] / own[0], np.zeros(len(order) - len(own))])
    place = np.arange(24) / 24
    u, v = (part.ravel() for part in np.meshgrid(place, place, indexing="ij"))
    fine = CellSeries(order, np.zeros(len(order)), np.zeros((0, 0)), 1.0, 0.0).at(u, v)[:, 1:]
    none = np.zeros((len(start),) * 2)
    return Response(start, none, slope, spread, bend, 0 * spread, fine)


def _order(record: dict) -> np.ndarray:
    """Return the terms whose effects the export states: its own, and sines where they are."""
    from mpfcad.pipeline.confidence.cell_runs import sines

    order = np.array(record["fit"]["order"])
    count = len(record["confidence"]["inputs"][0]["effect_of_sigma"])
    return order if len(order) == count + 1 else np.concatenate([order, sines(order)])


def _drawn(job, job_file, export, factors, row):
    """Return the plan of one draw, its prints moved in their maps, and the other inputs' steps."""
    from mpfcad.pipeline.confidence.cell_variant import MOVES
    from mpfcad.pipeline.plan.departure import Departure, PrintError
    from mpfcad.pipeline.plan.plan import read_plan

    shift, rest = np.zeros((2, 2)), {}
    for factor, z in zip(factors, row, strict=True):
        if factor.name in MOVES:
            move = MOVES[factor.name]
            shift[move.film, move.axis] = z * factor.sigma
        else:
            rest[factor] = float(z)
    films = tuple(PrintError(shift=(float(x), float(y))) for x, y in shift)
    return read_plan(job, job_file, Departure(films)), export, rest


def _trace(plan, export, steps, order, paths, seed):
    """Return the terms over their mean, and their covariance."""
    from mpfcad.measure import trace_terms
    from mpfcad.measure.cell.estimator import Estimator
    from mpfcad.pipeline.confidence.cell_variant import cell_variants_of
    from mpfcad.pipeline.effort import available_threads

    with cell_variants_of(plan, export) as variants:
        value, covariance, _ = trace_terms(
            variants.light(steps), order, paths, seed, available_threads(), Estimator.forward
        )
    return value[1:] / value[0], covariance[1:, 1:] / value[0] ** 2


def _contrast(found, fine) -> list[float]:
    curve = 1 + np.asarray(found) @ fine.T
    high, low = curve.max(axis=1), curve.min(axis=1)
    return ((high - low) / (high + low)).tolist()


def _terms(order, found, told, noise) -> list[dict]:
    """Return of each term how far draws move it, and by how much what is told is off."""
    off = found - told
    rows = [
        {
            "term": pair,
            "traced_sd": float(np.std(found[:, n])),
            "told_sd": float(np.std(told[:, n])),
            "off_rms": float(np.sqrt(np.mean(off[:, n] ** 2))),
            "bias": float(off[:, n].mean()),
            "noise": float(noise[n]),
        }
        for n, pair in enumerate(order.tolist())
    ]
    return sorted(rows, key=lambda row: -row["told_sd"])


def main() -> int:
    """Print shares of draws within limits, and the terms that move most."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("export", type=Path)
    parser.add_argument("job", type=Path)
    parser.add_argument("--draws", type=int, default=60)
    parser.add_argument("--paths", type=int, default=400_000)
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
            f"of {asked.draws}; told with such noise {row['told_with_noise']:.3f}, without "
            f"{row['told']:.3f}"
        )
    for row in found["terms"][:6]:
        print(
            f"term {row['term']}: draws move it by {row['traced_sd']:.4f} traced, "
            f"{row['told_sd']:.4f} told; off by {row['off_rms']:.4f}, mean {row['bias']:+.4f}, "
            f"noise of a trace {row['noise']:.4f}"
        )
    print(f"{found['factors']} inputs")
    return 0


if __name__ == "__main__":
    sys.exit(main())
