"""The loop after the print, closed in made-up factories: how often the next film passes.

`python benchmarks/loop.py [JOB] [--draws N] [--first K] [--renderer R] [--json]`. A factory is a
backlight and a printing process drawn from the widths of the job; nobody tells the program which.
Its first print is that of the job. A meter measures the print over two lamp pitches, coupons tell
the process, and `mpfcad correct --solids auto` writes the next job, which the same factory prints.
Each print lies elsewhere against the lamps. About two CPU minutes a factory.

With `--renderer mitsuba` (the extra `benchmark`; LLVM 19 serves, 16 does not,
DRJIT_LIBLLVM_PATH names it) the factory's light is traced by Mitsuba from the STL of the print:
its points are what is measured.
"""

import argparse
import json
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from tracer.look import PLACES, Seen, look, write_seen

ROOT = Path(__file__).parents[1]
JOB = ROOT / "masks" / "patterned-16mm.toml"
#: Seed of the first factory; none of the program's own.
SEED = 30_000
#: Errors of the instruments: a point of the meter, a coupon's curvature [1/mm].
METER, STYLUS = 0.002, 0.5
COUPONS = (0.06, 0.10, 0.16, 0.24, 0.34, 0.46, 0.60, 0.75, 0.90)
#: Places along two lamp pitches.
MEASURED = 49
#: Lamps of Mitsuba's row: a film beside its place is not its own mirror image about one.
LAMPS = 3


@dataclass(frozen=True, eq=False)
class Factory:
    """A backlight and a process that only prints and measurements show.

    Attributes
    ----------
    steps
        (k,) of the inputs of the job [sigma]; names and the inputs themselves beside them
    log_fill
        deviation of ln(fill) at `ratio`, (m,) float64
    rng
        of its laying and its instruments
    """

    factors: list
    steps: NDArray[np.float64]
    ratio: NDArray[np.float64]
    log_fill: NDArray[np.float64]
    rng: np.random.Generator

    def fill(self, process, ratio, thinner=1.0):
        """Return what fill fraction apertures give here, where the job's process says another.

        `thinner`: solids of the resin over those of the process.
        """
        off = np.interp(ratio, self.ratio, self.log_fill)
        return np.clip(process.fill_fraction(ratio) * thinner * np.exp(off), 0, 0.999)


def draw_factory(variants, process, seed: int) -> Factory:
    """Return a factory drawn from the widths of a job and its process."""
    rng = np.random.Generator(np.random.Philox(seed))
    factors = variants.factors()
    steps = np.array([
        float(f.within(np.array(z)))
        for f, z in zip(factors, rng.standard_normal(len(factors)), strict=True)
    ])  # fmt: skip
    ratio = np.linspace(0.005, 1.0, 200)
    modes = process.fill_modes(ratio)
    return Factory(factors, steps, ratio, rng.standard_normal(len(modes)) @ modes, rng)


def printed(factory: Factory, variants, plan, process, folder: Path):
    """Return the scene of the film that the factory makes of a mask, its mesh and place [mm]."""
    from mpfcad.cad import write_stl
    from mpfcad.measure import light_film

    change = {
        f.name: float(z * f.sigma) for f, z in zip(factory.factors, factory.steps, strict=True)
    }
    piece, groove = plan.piece, plan.piece.groove
    ratio = plan.process.aperture_ratio_of_curvature(piece.curvature)
    thinner = plan.job.process.solids_fraction / variants.plan.job.process.solids_fraction
    fill = factory.fill(process, ratio, thinner)
    made = replace(groove, depth=groove.depth + change["depth_um"] / 1000)
    # As in the confidence: the resin of an area is stated, so the share of the groove.
    film = replace(
        piece, groove=made, base=piece.base + change["base_um"] / 1000,
        curvature=made.curvature_of_fill(fill),
    )  # fmt: skip
    path = folder / "printed.stl"
    write_stl(film, path, plan.angle_tolerance)
    stack = variants.stack
    values = {
        name: replace(stack.quantity[name], value=stack.quantity[name].value + by)
        for name, by in change.items() if name in stack.quantity
    }  # fmt: skip
    sigma = next(f.sigma for f in factory.factors if f.name == "registration_mm")
    shift = plan.offset + factory.rng.normal(0, sigma)
    return light_film(stack.with_values(values), path, shift), path, shift


def lit_up(factory: Factory, scene, renderer: str, paths: float):
    """Return a print's contrast, with its interval, and what shows of it over the pitch."""
    from mpfcad.measure import TraceRun, luminance_over_pitch
    from mpfcad.pipeline.effort import available_threads

    lit, path, shift = scene
    seed = int(factory.rng.integers(1 << 32))
    if renderer == "mitsuba":
        seen = look(renderer, lit, path, shift, paths, seed >> 15, LAMPS)
        return seen.contrast(), seen
    run = TraceRun(seed=seed, path_limit=8_000_000, threads=available_threads())
    light = luminance_over_pitch(lit, run, half_width_goal=0.001)
    # The noise of the trace is no error of the meter.
    return light.contrast, Seen(PLACES, light.central_curve, 0 * PLACES)


def measure(factory: Factory, seen: Seen, pitch: float, file: Path, renderer: str) -> None:
    """Write what a meter reads of a print over two lamp pitches, or of a rendering over one."""
    noise = METER * factory.rng.standard_normal(MEASURED)
    if renderer == "mitsuba":
        value = seen.luminance * (1 + noise[: len(PLACES)])
        write_seen(Seen(PLACES, value, np.hypot(seen.error, METER * value)), pitch, file)
        return
    place = np.linspace(0, 2, MEASURED)
    true = np.interp(place % 1, seen.position, seen.luminance)
    lines = [f"{p * pitch:.4f},{v:.2f}" for p, v in zip(place, true * (1 + noise), strict=True)]
    file.write_text("\n".join(["position_mm,luminance_cd_m2", *lines, ""]), "utf-8")


def coupons(factory: Factory, plan, file: Path) -> None:
    """Write the calibration that coupons of the print give: curvatures with a stylus's error."""
    from mpfcad.film import PRIOR_RELEASE, Coupon, prior_belief, write_tone_process
    from mpfcad.pipeline.plan.printed.process import screen_mesh
    from mpfcad.units import um

    process, groove, job = plan.process, plan.job.film.groove, plan.job
    mesh, solids = screen_mesh(job.mask.mesh, "loop"), job.process.solids_fraction
    found, empty = [], groove.curvature_of_fill(0.0)
    for ratio in COUPONS:
        true = float(groove.curvature_of_fill(factory.fill(process, ratio)))
        read = true + STYLUS * factory.rng.standard_normal()
        if 1 < read < empty - 2 * STYLUS:
            ends = read - 1.96 * STYLUS, read + 1.96 * STYLUS
            found.append(Coupon(ratio, read, f"{ratio:g}", *ends))
    screen = {
        "mesh": mesh.name, "volume_cm3_m2": round(mesh.volume / um, 6), "solids_fraction": solids,
    }  # fmt: skip
    prior = prior_belief(solids * mesh.transfer_factor(groove, PRIOR_RELEASE))
    write_tone_process(file, found, groove, prior, screen)


def run_factory(job: Path, seed: int, folder: Path, asked) -> dict:
    """Return the contrasts of a factory's prints and what was predicted of them."""
    from mpfcad.job import read_job
    from mpfcad.pipeline.confidence.find import variants_of
    from mpfcad.pipeline.correct.printed import correct_print
    from mpfcad.pipeline.judge import Judging
    from mpfcad.pipeline.plan.plan import read_plan
    from mpfcad.pipeline.progress import SILENT
    from mpfcad.pipeline.run.make import write_cad
    from mpfcad.pipeline.run.run import run_job

    plan = read_plan(read_job(job), job)
    write_cad(plan, folder, ("stl",), SILENT)
    with variants_of(plan, folder) as variants:
        process, pitch = plan.process, plan.stack.period.across
        factory = draw_factory(variants, process, seed)
        coupons(factory, plan, folder / "coupons.toml")
        found, interval, told, limit = [], [], [], plan.job.gates.contrast_pass
        for number in range(asked.corrections + 1):
            scene = printed(factory, variants, plan, process, folder)
            contrast, seen = lit_up(factory, scene, asked.renderer, asked.million * 1e6)
            found.append(contrast.value)
            interval.append([contrast.low, contrast.high])
            if number == asked.corrections or found[-1] <= limit:
                break
            export = folder / f"export-{number}"
            run_job(read_job(job), job, export, effort="quick")
            measure(factory, seen, pitch, folder / f"measured-{number}.csv", asked.renderer)
            out = folder / f"next-{number}"
            record = correct_print(
                export, folder / f"measured-{number}.csv", Judging(lamp=0.0), out,
                process_file=folder / "coupons.toml", solids="auto",
            )  # fmt: skip
            told.append({
                "contrast": record["predicted_lamp_mura_contrast"]["value"],
                "ci95": record["predicted_lamp_mura_contrast"]["ci95"],
                "confidence": record["confidence"],
                "solids_fraction": record["solids_fraction"]["next"],
                "share_at_limits": record["share_at_limits"],
            })  # fmt: skip
            job = out / f"{record['name']}.toml"
            plan = read_plan(read_job(job), job)
    return {
        "seed": seed,
        "limit": limit,
        "contrast": found,
        "ci95": interval,
        "told": told,
        "log_fill": float(np.mean(factory.log_fill)),
    }


def main() -> int:
    """Print each factory's contrasts, and how many passed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("job", nargs="?", type=Path, default=JOB)
    parser.add_argument("--draws", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--corrections", type=int, default=2)
    parser.add_argument("--renderer", choices=("own", "mitsuba"), default="own")
    parser.add_argument("--million", type=float, default=3.0, help="Mitsuba's paths a print")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    rows = []
    for number in range(asked.first, asked.first + asked.draws):
        with tempfile.TemporaryDirectory() as temporary:
            rows.append(run_factory(asked.job, SEED + number, Path(temporary), asked))
        print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    passed = sum(row["contrast"][-1] <= row["limit"] for row in rows)
    print(json.dumps(rows, indent=1) if asked.json else f"{passed} of {len(rows)} within the limit")
    return 0


if __name__ == "__main__":
    sys.exit(main())
