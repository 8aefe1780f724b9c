"""Options of commands: a file holds the arguments, a line each; work itself is not begun."""

import io
import math
import os
from collections.abc import Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from unittest import mock

from mpfcad.cli import run_app
from mpfcad.errors import InputError

from .kind import Reader
from .written import JOB, written

#: By command: its arguments, and where its work begins.
COMMANDS = {
    "rays": (
        "thesis-32in-mpf --out a.dat --at film --rays 100 --thickness-mm 20 --seed 3 --threads 1",
        "mpfcad.pipeline.measure.rays.collect_rays",
    ),
    "measure": (
        "film.stl --stack thesis-32in-mpf --thickness-mm 20 --offset-mm 0.1 --what contrast "
        "--effort quick --seed 3 --out out",
        "mpfcad.pipeline.measure_film",
    ),
    "trace": (
        "film.stl --stack thesis-32in-mpf --thickness-mm 20 --offset-mm 0.1 --effort quick",
        "mpfcad.measure.luminance_over_pitch",
    ),
    "judge": (
        "m.csv --pitch-mm 32.69 --lamp-at-mm 0.5 --unit mm --pixel-mm 0.1 --crop 1,2,30,40 "
        "--rotation-deg 5 --limit 0.01 --marginal 0.02 --cd-m2-per-count 1.5",
        "mpfcad.pipeline.judge._judge_stripes",
    ),
    "calibrate": (
        "m.csv --aperture 0.3 --pitch-um 50 --depth-um 25 --unit um,um --columns 1,2 "
        "--tip-radius-um 2 --tip-angle-deg 60 --widths 2 --solids 0.5 --upright",
        "mpfcad.film.read_stylus_trace",
    ),
    "mask": (
        "job.toml --format oas,gds --mesh 120-34 --mesh-angle-deg 10 --emulsion-um 5 "
        "--pattern slot --period-um 1000 --solids 0.5 --polarity open --revision A",
        "mpfcad.pipeline.make_planned_mask",
    ),
    "bsdf": (
        "film.stl --index 1.5 --basis klems-full --rays 100 --seed 3 --format klems,csv",
        "mpfcad.optics.bsdf_film.trace_film_bsdf",
    ),
    "cad": ("job.toml --format step,stl,dat --out out", "mpfcad.pipeline.run.run.write_cad"),
    "compare": (
        "film.stl thesis-32in-mpf --effort quick --seed 3 --out out",
        "mpfcad.pipeline.compare_cases",
    ),
}


def _numbers(value: object) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif isinstance(value, dict | list | tuple):
        for each in value.values() if isinstance(value, dict) else value:
            yield from _numbers(each)
    elif is_dataclass(value) and type(value).__name__ in ("Judging", "Measuring", "Photo"):
        for field in fields(value):
            yield from _numbers(getattr(value, field.name))


def _begun(*arguments: object, **options: object) -> None:
    """Stand in for the work: end it in order, unless it was given a number that is none."""
    assert all(map(math.isfinite, _numbers((arguments, options)))), "work with nan or inf"
    raise SystemExit(0)


@contextmanager
def _place(folder: Path) -> Iterator[None]:
    """Stand in a folder with the files that the arguments name."""
    here = folder / "here"
    here.mkdir(exist_ok=True)
    if not (here / "film.stl").exists():
        (here / "film.stl").write_bytes(written("stl")[0])
        (here / "job.toml").write_text(JOB)
        (here / "m.csv").write_text("position_mm,luminance\n" + "0,1\n0.1,2\n" * 20)
    with chdir(here):
        yield


def _run(command: str, work: str, path: Path) -> None:
    arguments = [os.fsdecode(line) for line in path.read_bytes().replace(b"\0", b"").split(b"\n")]
    error = io.StringIO()
    with (
        _place(path.parent),
        mock.patch(work, _begun),
        redirect_stdout(io.StringIO()),
        redirect_stderr(error),
    ):
        code = run_app([command, *arguments])
    if code == 0:
        return
    lines = [line for line in error.getvalue().splitlines() if line.startswith("mpfcad: ")]
    if code != 2 or len(lines) != 1 or len(lines[0]) > 300 or not lines[0].isprintable():
        raise RuntimeError(f"exit code {code}: {lines}")
    raise InputError(f"{path.name}: {lines[0][8:]}"[:280])


def readers() -> list[Reader]:
    """Return a reader of the options of each command."""
    return [
        Reader(
            f"options-{name}", ".arguments", partial(_run, name, work),
            (text.replace(" ", "\n").encode(),), costly=True,
        )
        for name, (text, work) in COMMANDS.items()
    ]  # fmt: skip
