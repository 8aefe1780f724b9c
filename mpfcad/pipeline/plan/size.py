"""How large a job and its files become: what would need more than can be had is refused early.

Estimates are upper bounds; a refusal says which value would fit.
"""

import math

from mpfcad.errors import InputError
from mpfcad.job import Job

#: Largest mesh [triangles]: about 200 bytes each in memory while it is made and checked.
_TRIANGLES = 4e7
#: Places of pieces over a cell: each array of them is then 400 MB.
_PLACES = 50_000_000


def groove_count(width: float, pitch: float) -> int:
    """Return how many whole grooves of `pitch` [mm] cover `width` [mm]."""
    return math.ceil(width / pitch - 1e-9)


def most_triangles(job: Job, groove_count: int) -> int:
    """Return how many triangles the mesh of so many grooves has at most."""
    # A groove's parabola turns by at most a right angle, in chords of two facets; ends are closed.
    return math.ceil(groove_count * 4 * (90 / (2 * job.cad.angle_tolerance_deg) + 4))


def refuse_mesh(job: Job, groove_count: int, where: str) -> None:
    """Refuse a mesh of a piece of so many grooves that would not fit the memory.

    Raises
    ------
    InputError
        naming the facet angle and the smallest that fits.
    """
    tolerance = job.cad.angle_tolerance_deg
    triangles = most_triangles(job, groove_count)
    if triangles > _TRIANGLES:
        room = _TRIANGLES / (4 * groove_count) - 4
        fits = f"at least {90 / (2 * room):.2g}" if room > 9 else "a smaller piece"
        raise InputError(
            f"{where}: cad.angle_tolerance_deg: {tolerance:g}: up to {triangles / 1e6:.0f} million "
            f"triangles in {groove_count} grooves: expected {fits} (or cad.extent = 'pitch')"
        )


def check_places(count: int, pieces: int, piece: float, where: str) -> None:
    """Refuse more places of pieces, so long [mm], over a cell than memory holds.

    Raises
    ------
    InputError
        that begins with `where`.
    """
    if count * pieces > _PLACES:
        raise InputError(
            f"{where}: piece_mm: {piece:.4g}: {count} × {pieces:.4g} pieces over the LEDs' cell: "
            f"expected at most {_PLACES:.0e}: longer pieces, or a smaller cell"
        )
