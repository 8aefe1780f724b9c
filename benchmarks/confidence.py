"""The told confidence beside traces with drawn inputs: which share meets the limits.

`python benchmarks/confidence.py [JOB] [--draws N] [--paths N] [--json]`. Draws all inputs of a job
at once from their widths, traces the film in each draw with random numbers of its own, and counts
the contrasts within the limits; the confidence's response tells the same share. Noise of a trace
raises its contrast, so the told contrasts get the noise of the same traces. About a CPU second a
draw of 0.25 million paths, and a minute and a half before the first.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
JOB = ROOT / "masks" / "patterned-16mm.toml"
#: Seed of the draws, and of the first draw's trace: none of the program's own.
SEED = 20_000


def traced_and_told(job: Path, draws: int, paths: int) -> dict:
    """Return traced contrasts, and those that the response tells with and without noise."""
    from mpfcad.confidence import correlation, draw_steps
    from mpfcad.job import read_job
    from mpfcad.measure import TraceRun, luminance_over_pitch
    from mpfcad.pipeline.confidence.find import variants_of
    from mpfcad.pipeline.confidence.runs import POINTS, Runs, reading_of
    from mpfcad.pipeline.effort import available_threads
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.progress import SILENT
    from mpfcad.pipeline.run.make import write_cad

    threads = available_threads()
    plan = read_plan(read_job(job), job)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        write_cad(plan, folder, ("stl",), SILENT)
        with variants_of(plan, folder) as variants:
            lit = variants.light({})
            own = luminance_over_pitch(
                lit, TraceRun(seed=1, path_limit=4_000_000, threads=threads), half_width_goal=0.002
            )
            reading, factors = reading_of(own), variants.factors()
            asked = plan.job.confidence_table
            runs = Runs(variants, factors, reading, 1, threads, SILENT)
            response = runs.respond(asked.paths_million)
            between = correlation(factors, asked.covariance_of())
            steps = draw_steps(factors, between, SEED, draws)
            blocks = max(2, round(paths / (POINTS * 512)))
            found, spread = [], 0.0
            for number, row in enumerate(steps, 1):
                one = Runs(variants, factors, reading, SEED + number, threads, SILENT)
                read, error = one.trace(row, blocks)
                found.append(read)
                spread = spread + error / draws
                if number % 20 == 0:
                    print(f"draw {number} of {draws}", file=sys.stderr, flush=True)
            many = draw_steps(factors, between, SEED + 1, 4000)
            return _compared(response, reading, many, np.array(found), spread) | {
                "factors": len(factors),
                "as_stated": own.contrast.value,
                "first_cosine": _rms(response, steps, np.array(found), spread),
            }


def _compared(response, reading, steps, found, spread) -> dict:
    best = response.shrunk()
    told = best.start + steps @ best.slope + steps**2 @ best.bend
    rng = np.random.Generator(np.random.Philox(SEED))
    value, vector = np.linalg.eigh(spread)
    noise = rng.standard_normal(told.shape) @ (vector * np.sqrt(np.maximum(value, 0))).T
    return {
        "traced": _contrast(found, reading.fine),
        "told": _contrast(told, reading.fine),
        "told_noisy": _contrast(told + noise, reading.fine),
    }


def _rms(response, steps, found, spread) -> dict:
    told = response.start + steps @ response.slope + steps**2 @ response.bend
    off = found[:, 0] - told[:, 0]
    return {
        "off": float(np.std(off)),
        "bias": float(off.mean()),
        "noise": float(spread[0, 0] ** 0.5),
    }


def _contrast(found, fine) -> list[float]:
    curve = 1 + found @ fine.T
    high, low = curve.max(axis=1), curve.min(axis=1)
    return ((high - low) / (high + low)).tolist()


def shares(found: dict, limits: tuple[float, ...]) -> list[dict]:
    """Return, for each limit, the share traced with its interval, and the shares told."""
    from scipy.stats import binomtest

    rows = []
    for limit in limits:
        inside = int(np.sum(np.array(found["traced"]) <= limit))
        ends = binomtest(inside, len(found["traced"])).proportion_ci(method="wilson")
        rows.append({
            "limit": limit,
            "traced": inside / len(found["traced"]),
            "ci95": [float(ends.low), float(ends.high)],
            "told_with_noise": float(np.mean(np.array(found["told_noisy"]) <= limit)),
            "told": float(np.mean(np.array(found["told"]) <= limit)),
        })  # fmt: skip
    return rows


def main() -> int:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("job", nargs="?", type=Path, default=JOB)
    parser.add_argument("--draws", type=int, default=400)
    parser.add_argument("--paths", type=int, default=400_000)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    found = traced_and_told(asked.job, asked.draws, asked.paths)
    rows = shares(found, (0.012, 0.018, 0.03))
    if asked.json:
        print(json.dumps({"shares": rows, **found}, indent=1))
        return 0
    for row in rows:
        print(
            f"contrast within {row['limit']}: traced {row['traced']:.3f} "
            f"[{row['ci95'][0]:.3f}, {row['ci95'][1]:.3f}] of {asked.draws}; "
            f"told with such noise {row['told_with_noise']:.3f}, without {row['told']:.3f}"
        )
    one = found["first_cosine"]
    print(f"first cosine: traced less told {one['bias']:+.4f} ± {one['off']:.4f}, "
          f"noise of a trace {one['noise']:.4f}; {found['factors']} inputs")  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
