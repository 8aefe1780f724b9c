"""Backlights with hidden values that another renderer shows: how often a fit's intervals hold.

`python benchmarks/hidden.py [--draws N] [--first K] [--renderer R] [--million M] [--json]`. Every
value of the README's backlight is drawn from its width. Mitsuba (the extra `benchmark`; LLVM 19
serves, 16 does not, DRJIT_LIBLLVM_PATH names it) traces the luminance over the lamps of a plain
prism film, a uniform film and the job's film. `mpfcad fit` gets these curves and two ratios of
their means; it has to find the values, and the contrast and luminance of a film that it was not
given. Printed are the errors in units of the stated standard errors. About two CPU minutes a
backlight.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from tracer.look import look, write_seen

ROOT = Path(__file__).parents[1]
JOB = ROOT / "masks" / "patterned-16mm.toml"
#: Seed of the first backlight; none of the program's own.
SEED = 40_000
#: Error of a meter's ratio of two luminances, beside that of the rendering.
RATIO = 0.002
#: What is measured, and the film that is predicted.
GIVEN, NEW = ("bef", "uniform", "printed"), "new"
FIT = """
name = "hidden"

[stack]
preset = "thesis-32in-mpf"
thickness_mm = 16.0

[case.bef]

[case.uniform]
curvature_per_mm = 60.0

[case.printed]
film = "{job}"

[case.new]
curvature_per_mm = 50.0

[[predict]]
case = "new"
of = "contrast"

[[predict]]
case = "new"
over = "bef"
of = "luminance"
"""
CURVE = """
[[measurement]]
case = "{case}"
of = "curve"
file = "{case}.csv"
lamp_at_mm = 0.0
"""
OVER = """
[[measurement]]
case = "{case}"
over = "bef"
of = "luminance"
value = {value}
sigma = {sigma}
"""


def draw_values(stack, rng):
    """Return every value of a backlight drawn from its width."""
    from mpfcad.backlight.width import limits_of, width_of

    found = {}
    for name, quantity in stack.quantity.items():
        sigma = width_of(stack, name).sigma
        if sigma > 0:
            found[name] = float(
                np.clip(quantity.value + sigma * rng.standard_normal(), *limits_of(stack, name))
            )
    return found


def run_backlight(number: int, folder: Path, asked) -> dict:
    """Return what a fit told of a hidden backlight, beside the truth."""
    from mpfcad.job.fit import read_fit
    from mpfcad.pipeline import FitSetting, fit_backlight
    from mpfcad.pipeline.fit import tracer
    from mpfcad.pipeline.fit.case import build_cases, read_backlight

    tracer.ROUND_PATHS["quick"] = asked.fit_million

    rng = np.random.Generator(np.random.Philox(SEED + number))
    file, made = folder / "fit.toml", folder / "made"
    made.mkdir()
    text = FIT.format(job=JOB)
    file.write_text(text + OVER.format(case="uniform", value=1.0, sigma=1.0), "utf-8")
    stack = read_backlight(read_fit(file), file)
    truth = draw_values(stack, rng)
    cases = build_cases(read_fit(file), file, stack, made)
    seen = {}
    for seed, (name, case) in enumerate(cases.items(), SEED + 10 * number):
        lit = case.light(truth)
        paths = asked.million * 1e6
        seen[name] = look(asked.renderer, lit, case.mesh, case.offset, paths, seed)
    for name in GIVEN:
        write_seen(seen[name], stack.period.across, folder / f"{name}.csv")
        text += CURVE.format(case=name)
    for name in GIVEN[1:]:
        ratio, error = seen[name].over(seen["bef"])
        value = ratio * (1 + RATIO * rng.standard_normal())
        text += OVER.format(case=name, value=value, sigma=float(np.hypot(error, RATIO * ratio)))
    file.write_text(text, "utf-8")
    record = fit_backlight(read_fit(file), file, folder / "out", FitSetting("quick"))
    contrast, over = seen[NEW].contrast(), seen[NEW].over(seen["bef"])
    real = [(contrast.value, contrast.half_width / 1.96), over]
    return {
        "number": number,
        "chi2_probability": record["probability"],
        "settled": record["settled"],
        "values": [
            {
                "name": row["name"], "true": truth[row["name"]], "found": row["value"],
                "sigma": row["sigma"], "left": row["left"],
                "z": (row["value"] - truth[row["name"]]) / row["sigma"],
            }
            for row in record["values"]
        ],
        "predicted": [
            {
                "name": row["name"], "ci95": row["ci95"], "rendered": value, "error": error,
                "z": (row["value"] - value) / float(np.hypot(row["sigma"], error)),
            }
            for row, (value, error) in zip(record["predictions"], real, strict=True)
        ],
    }  # fmt: skip


def show(rows: list[dict]) -> None:
    """Print how often the 95 % intervals hold."""
    values = [value for row in rows for value in row["values"]]
    held = [value for value in values if value["left"] < 0.8]
    for what, some in (
        ("all values", values), ("values of which the data leave less than 0.8 of the width", held),
        ("predictions of a film that was not measured", [p for r in rows for p in r["predicted"]]),
    ):  # fmt: skip
        z = np.array([one["z"] for one in some])
        inside = int(np.count_nonzero(np.abs(z) < 1.96))
        print(f"{what}: {inside} of {len(z)} held, z {z.mean():.2f} ± {z.std():.2f}")


def main() -> int:
    """Fit each hidden backlight and print how often the intervals hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=6)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--renderer", choices=("mitsuba", "own"), default="mitsuba")
    parser.add_argument("--million", type=float, default=1.0, help="rendered paths a film")
    parser.add_argument(
        "--fit-million", type=float, default=6.0, help="paths of a round of the fit"
    )
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    rows = []
    for number in range(asked.first, asked.first + asked.draws):
        with tempfile.TemporaryDirectory() as temporary:
            rows.append(run_backlight(number, Path(temporary), asked))
        print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    if asked.json:
        print(json.dumps(rows, indent=1))
    else:
        show(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
