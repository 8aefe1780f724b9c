"""A point of a sweep under LEDs: where its films lie, how its board is, and its trace."""

import math
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpfcad.backlight import Stack
from mpfcad.errors import InputError
from mpfcad.job.sweep import LED_AXES
from mpfcad.pipeline.effort import NO_GOAL
from mpfcad.pipeline.plan.departure import Departure, PrintError
from mpfcad.pipeline.plan.plan import Plan
from mpfcad.pipeline.progress import SILENT
from mpfcad.pipeline.run.make import write_cad
from mpfcad.units import deg

if TYPE_CHECKING:
    from mpfcad.measure import Lit

Coordinate = dict[str, Any]
#: What the axes of the film in the job's place and of that across begin with.
_FILMS = ("", "crossed_")


def departure_of(stack: Stack, coordinate: Coordinate, where: str) -> Departure:
    """Return how a point's films and board depart from its job.

    A film that is turned or stretched about the panel's middle is moved most at its corners; what
    is judged is the upper right one. The turn of the grooves themselves is left out: its cosine is
    1 within 1e-5 up to 0.25°.

    Raises
    ------
    InputError
        that begins with `where`, for an axis that LEDs do not have, or a count that is not whole.
    """
    wrong = [axis for axis in coordinate if "." not in axis and axis not in LED_AXES]
    if wrong:
        raise InputError(
            f"{where}: axis {wrong[0]}: LEDs light the stack: expected table.field of a job or one "
            f"of {', '.join(LED_AXES)}"
        )
    if coordinate.get("resin_percent", 0.0) <= -100:
        raise InputError(
            f"{where}: axis resin_percent: {coordinate['resin_percent']:g}: leaves no resin: "
            "expected above -100"
        )
    whole = {axis: _whole(coordinate, axis, where) for axis in ("led_repeat", "led_seed")}
    dead, repeat = _whole(coordinate, "dead_led", where), whole["led_repeat"]
    return Departure(
        tuple(_film(stack, coordinate, name) for name in _FILMS),
        None if repeat is None else (repeat, repeat),
        whole["led_seed"],
        None if dead is None else (dead,) if dead else (),
    )


def _film(stack: Stack, coordinate: Coordinate, film: str) -> PrintError:
    """Return how a film departs, `film` the beginning of its axes' names."""
    corner = stack.panel_width / 2, stack.panel_length / 2
    turn = math.tan(coordinate.get(f"{film}turn_deg", 0.0) * deg)
    stretch = coordinate.get("stretch_percent", 0.0) / 100
    turned = -turn * corner[1], turn * corner[0]
    shift = [
        coordinate.get(f"{film}shift_{axis}_mm", 0.0)
        - coordinate.get(f"board_shift_{axis}_mm", 0.0)
        + turned[i]
        + stretch * corner[i]
        for i, axis in enumerate("xy")
    ]
    return PrintError(
        (shift[0], shift[1]),
        coordinate.get("resin_percent", 0.0) / 100,
        coordinate.get("pattern_percent", 0.0) / 100,
        coordinate.get("curvature_error_per_mm", 0.0),
    )


def _whole(coordinate: Coordinate, axis: str, where: str) -> int | None:
    """Return the whole number on an axis; None where there is no such axis."""
    if axis not in coordinate:
        return None
    value, least = coordinate[axis], 1 if axis == "led_repeat" else 0
    if value != int(value) or value < least:
        raise InputError(
            f"{where}: axis {axis}: {value:g}: expected a whole number of {least} or more"
        )
    return int(value)


def trace_cell_point(
    plan: Plan, departure: Departure, half_width: float, path_limit: int, threads: int
) -> dict[str, Any]:
    """Return the figures of a plan under LEDs, in outside names, and each film's shift [mm]."""
    from mpfcad.measure import TraceRun, luminance_over_cell
    from mpfcad.record import describe_cell

    with tempfile.TemporaryDirectory() as temporary:
        lit = _light(plan, Path(temporary))
        run = TraceRun(seed=plan.job.seed, threads=threads, path_limit=path_limit)
        found = luminance_over_cell(lit, run, half_width_goal=half_width or NO_GOAL)
    shifts = [departure.film(number).shift for number in range(len(plan.films))]
    distance = plan.job.mask.viewing_distance_mm
    return {
        "local_shift_mm": max(math.hypot(*shift) for shift in shifts),
        "film_shift_mm": [list(shift) for shift in shifts],
        **describe_cell(found, plan.job.seed, distance),
    }


def compile_for_cell(plan: Plan) -> None:
    """Compile what traces a plan under LEDs, if it is not there yet."""
    from mpfcad.measure import compile_cell_tracer

    with tempfile.TemporaryDirectory() as temporary:
        compile_cell_tracer(_light(plan, Path(temporary)))


def _light(plan: Plan, folder: Path) -> "Lit":
    """Return a plan's films, written into a folder and read back, in its stack."""
    from mpfcad.measure import light_film
    from mpfcad.pipeline.kind import kind_of

    traced = kind_of(plan.drawn, plan.job.cad).run_formats[-1]
    write_cad(plan, folder, (traced,), SILENT)
    return light_film(plan.lit_stack(folder), folder / plan.file("film", traced), plan.offset)
