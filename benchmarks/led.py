"""One LED scene in Mitsuba: the crossed printed films of a job, luminance at several places.

    python benchmarks/led.py [--own] [--paths N] [--million N]

Mitsuba comes from the extra `benchmark`, and needs LLVM (19 serves, 16 does not;
DRJIT_LIBLLVM_PATH names it).
The films are those of masks/mini-led-4mm.toml at 2° a facet: ours are traced from their 3MF files,
Mitsuba's are windows of the same libraries as closed meshes. One LED stands between mirrors half a
pitch beside it, which is a lattice without end. The LED is flat and Lambertian, the reflector
mirrors part of the light, the plate is clear. The last column is for one place alone, in CPU
seconds, though ours has all places for them; both are compiled before.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from tracer.led_scene import PLACES, SPOT, mitsuba_led
from tracer.race import spent

from mpfcad.cad.file.library_window import check_window, write_window
from mpfcad.job import read_job
from mpfcad.measure import TraceRun, light_film, luminance_over_cell
from mpfcad.pipeline.effort import NO_GOAL
from mpfcad.pipeline.plan.plan import read_plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad

#: A quarter of the job's backlight, under the same films: Mitsuba moves each ray on by 9e-5 of the
#: largest coordinate, which must be small beside a facet. The LED is large, so that Mitsuba's rays,
#: which meet it by chance, are not scattered too much.
OVERRIDE = {
    "led_pitch_across_mm": 1.0, "led_pitch_along_mm": 1.0, "led_width_mm": 0.5,
    "led_length_mm": 0.5, "led_height_mm": 0.0, "thickness_mm": 0.4, "plate_thickness_mm": 0.15,
}  # fmt: skip
#: Of the job's own board: its LED flat on the reflector, as in the other scene.
FLAT = {"led_height_mm": 0.0}
JOB = Path(__file__).parent.parent / "masks" / "mini-led-4mm.toml"


def films(folder: Path, override: dict[str, float]):
    """Write both films of the job and return the plan and a window of 2 × 2 cells of each."""
    job = read_job(JOB)
    update = {
        "cad": job.cad.model_copy(update={"angle_tolerance_deg": 2.0}),
        "stack": job.stack.model_copy(update={"override": override}),
    }
    plan = read_plan(job.model_copy(update=update), JOB)
    write_cad(plan, folder, ("3mf",), SILENT)
    windows = []
    for film in plan.films:
        library, path = film.drawn.repeated((2, 2)), folder / f"window{film.suffix}.stl"
        write_window(library, path, film.job.cad.angle_tolerance, "window")
        check_window(path, library)
        windows.append(path)
    return plan, windows


def ours(plan, folder: Path, paths: int):
    """Return (value, standard error) at each place, of the mean over a spot, and the elements."""
    lit = light_film(plan.lit_stack(folder), folder / "film.3mf")
    found = luminance_over_cell(lit, TraceRun(1, 1, paths), half_width_goal=NO_GOAL)
    size, bins = found.size[0], len(found.luminance)
    middle = (np.arange(bins) + 0.5) / bins * size - size / 2
    rows = []
    for place in PLACES:
        near = [np.abs(middle - at * size) < SPOT * size / 2 for at in place]
        part = np.ix_(*near)
        value, error = found.luminance[part], found.standard_error[part]
        rows.append((value.mean(), np.sqrt((error**2).sum()) / value.size))
    return rows, lit.elements


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--own", action="store_true", help="the job's own board, of 4 mm")
    options.add_argument("--million", type=float, default=8.0, help="our paths")
    options.add_argument("--paths", type=int, default=1_000_000, help="Mitsuba's at each place")
    chosen = options.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        plan, windows = films(folder, FLAT if chosen.own else OVERRIDE)
        ours(plan, folder, 1)  # compiles
        (rows, elements), own = spent(ours, plan, folder, round(chosen.million * 1e6))
        print(f"ours, all places at once: {own:.0f} CPU s")
        tracers, total, squares = mitsuba_led(elements, windows), 0.0, 0.0
        tracers[0](1000, 1)  # compiles
        print("place/P  ours [cd/m2]  ±  Mitsuba  ±  σ apart  its time over ours to equal error")
        scene = zip(PLACES, rows, tracers, strict=True)
        # A seed for each place: with one for all, their noise is shared.
        for seed, (place, (value, error), trace) in enumerate(scene, start=1):
            (other, noise), cpu = spent(trace, chosen.paths, seed)
            total += cpu
            away = (other - value) / np.hypot(error, noise)
            squares += away**2
            ratio = cpu * noise**2 / (own * error**2)
            both = f"{value:.0f}  {error:.0f}  {other:.0f}  {noise:.0f}"
            print(f"{place}  {both}  {away:+.2f}  {ratio:.1f}")
        print(f"chi2 {squares:.1f} of {len(PLACES)}; Mitsuba: {total:.0f} CPU s")


if __name__ == "__main__":
    main()
