"""What a weave can be: opening and thickness against thread count and thread."""

from typing import Literal

from mpfcad.errors import InputError
from mpfcad.units import um

Material = Literal["polyester", "steel", "calendered steel"]
#: Threads per cm, and threads [mm], that are woven for screens: the catalogue has 43 to 197, and 11
#: to 80 µm; other trades reach further.
COUNT_RANGE, THREAD_RANGE = (5.0, 400.0), (0.005, 0.4)
#: How far opening + thread may be from 1/n, in threads. The catalogue's stated openings are within
#: 0.05 threads of it, ink volumes of SEFAR PET 1500 mean up to 0.15 less (`mesh.THREAD_WIDTH`): up
#: to twice as much passes, for counts are rounded to whole threads, too.
OPENING_RANGE = (-0.3, 0.1)
#: Thickness in threads: two that cross, at most as thick as woven plus a tenth for the measurement;
#: at least flattened by half, by a calender to four tenths. The catalogue's stated ones are 1.48 to
#: 1.58.
THICKNESS_RANGE: dict[Material, tuple[float, float]] = {
    "polyester": (1.0, 2.2),
    "steel": (1.0, 2.2),
    "calendered steel": (0.8, 2.2),
}


def check_weave(
    threads_per_cm: float,
    thread: float,
    opening: float | None,
    thickness: float | None,
    material: Material,
    where: str,
) -> None:
    """Refuse what no weave has; `thread`, `opening` and `thickness` in mm, None: not stated.

    Raises
    ------
    InputError
        that begins with `where` and the field, with the value and what is expected.
    """
    _check_range(threads_per_cm, COUNT_RANGE, f"{where}threads_per_cm")
    _check_range(thread / um, (THREAD_RANGE[0] / um, THREAD_RANGE[1] / um), f"{where}thread_um")
    cell = 10 / threads_per_cm
    woven = f"of {threads_per_cm:g} threads/cm"
    if cell <= thread:
        raise InputError(
            f"{where}thread_um: {thread / um:g}: a mesh {woven} leaves nothing open: expected "
            f"threads thinner than {cell / um:.4g} µm"
        )
    if opening is not None:
        low, high = (max(0.0, cell - thread + share * thread) for share in OPENING_RANGE)
        if not low <= opening <= high:
            raise InputError(
                f"{where}opening_um: {opening / um:g}: expected {low / um:.3g} … {high / um:.3g}: "
                f"opening and thread ({thread / um:g} µm) make {cell / um:.4g} µm {woven}"
            )
    if thickness is not None:
        low, high = (share * thread for share in THICKNESS_RANGE[material])
        if not low <= thickness <= high:
            raise InputError(
                f"{where}thickness_um: {thickness / um:g}: expected {low / um:.3g} … "
                f"{high / um:.3g}: {low / thread:g} to {high / thread:g} threads of "
                f"{thread / um:g} µm ({material})"
            )


def _check_range(value: float, limits: tuple[float, float], where: str) -> None:
    if not limits[0] <= value <= limits[1]:
        raise InputError(f"{where}: {value:g}: expected {limits[0]:g} … {limits[1]:g}")
