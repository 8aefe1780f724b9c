"""A job's halftone: which pieces are printed, how their resin levels, and the film that is left."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import (
    Groove,
    Halftone,
    PieceLibrary,
    build_halftone,
    build_library,
    modulation_left,
)
from mpfcad.job import Job
from mpfcad.pipeline.plan.cell import LEVELS, PIECE, CellFrame
from mpfcad.pipeline.plan.departure import AS_MAPPED, PrintError
from mpfcad.pipeline.plan.printed.screen import flow_levelling
from mpfcad.pipeline.plan.size import check_places

#: Modulation of printed and bare pieces in turn below which no halftone is left.
LEAST_MODULATION = 0.1
#: How far beside its grooves a print is told of, in grooves: about what all places come to.
_ASIDE = 0.25
#: Parts of a levelling length in which the levelled film is held, at least.
_PARTS = 2


def halftone_of(job: Job, tone: NDArray[np.float64], where: str) -> Halftone:
    """Return the halftone of a job's map over a film's cell, (n, m) [1/mm].

    Raises
    ------
    InputError
        that begins with `where`, for a map beyond the two curvatures, or blocks wider than a cell.
    """
    table, groove = job.halftone, job.film.groove
    assert table is not None  # the caller has looked
    if not groove.takes_resin(table.curvature_per_mm):
        raise InputError(
            f"{where}: halftone.curvature_per_mm: {table.curvature_per_mm:g}: expected below "
            f"{groove.curvature_empty:g}, a groove with resin"
        )
    if table.grooves > len(tone):
        raise InputError(
            f"{where}: halftone.grooves: {table.grooves}: expected at most {len(tone)}, the "
            "grooves of the LEDs' cell"
        )
    try:
        return build_halftone(groove, table.curvature_per_mm, tone, table.grooves)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def clipped_tone(job: Job, tone: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a map within the two curvatures: what a print that departs has of it."""
    assert job.halftone is not None  # the caller has looked
    return np.clip(tone, job.halftone.curvature_per_mm, job.film.groove.curvature_empty)


@dataclass(frozen=True)
class Levelling:
    """How the resin of a halftone's pieces levels; lengths in mm.

    Attributes
    ----------
    piece
        length of a printed or bare piece
    parts
        of a piece, in which the levelled film is held
    length
        full width at half maximum of the Gauss curve
    """

    piece: float
    parts: int
    length: float

    @classmethod
    def of(cls, job: Job, piece: float, where: str) -> "Levelling":
        """Return that of a job whose pieces are so long [mm].

        Raises
        ------
        InputError
            that begins with `where`, when the resin does not run, or leaves no halftone.
        """
        table, groove = job.halftone, job.film.groove
        assert table is not None  # the caller has looked
        fill = float(groove.fill_fraction(table.curvature_per_mm))
        length = flow_levelling(job, groove, fill, where) or job.mask.levelling_length
        left = modulation_left(piece, length)
        if left < LEAST_MODULATION:
            raise InputError(
                f"{where}: halftone.piece_mm: {piece:.4g}: levelling over {length:.3g} mm leaves "
                f"{left:.2g} of the modulation: expected {LEAST_MODULATION:g} or more: pieces of "
                f"{_least_piece(length):.2g} mm, or no [halftone]"
            )
        part = job.cad.inside("piece_mm") or min(PIECE, length / _PARTS)
        return cls(piece, max(1, round(piece / part)), length)

    @property
    def modulation(self) -> float:
        """What is left of printed and bare pieces in turn, (max - min)/(max + min) of the fill."""
        return modulation_left(self.piece, self.length)


def _least_piece(levelling: float) -> float:
    """Return how long [mm] pieces must be for a halftone to be left."""
    from scipy.optimize import brentq

    low, high = 0.1 * levelling, 10 * levelling
    return float(brentq(lambda x: modulation_left(x, levelling) - LEAST_MODULATION, low, high))


def levelled_library(
    job: Job,
    halftone: Halftone,
    frame: CellFrame,
    where: str,
    error: PrintError = AS_MAPPED,
    *,
    turned: bool = False,
) -> PieceLibrary:
    """Return the film over one cell as it is once the resin has levelled.

    `error`: how its print departs, by the panel's axes; `turned` for a film that lies across.
    """
    m = halftone.printed.shape[1]
    piece = frame.size[1] / m
    level = Levelling.of(job, piece, where)
    check_places(len(halftone.printed), m * level.parts, piece / level.parts, where)
    groove, (x, y) = halftone.groove, error.shift
    wanted = halftone.levelled(
        piece,
        level.parts,
        level.length,
        shift=(y, -x) if turned else (x, y),
        fill=_fill(groove, halftone.curvature, error),
    )
    levels = LEVELS if job.cad.levels is None else job.cad.levels
    return build_library(groove, job.film.base, piece / level.parts, wanted, levels)


def _fill(groove: Groove, curvature: float, error: PrintError) -> float:
    """Return the fill of a printed piece whose print departs."""
    changed = min(max(curvature + error.curvature, 0.0), groove.curvature_empty)
    return min(1.0, float(groove.fill_fraction(changed)) * (1 + error.resin))


def describe_halftone(job: Job, halftone: Halftone, piece: float, where: str) -> dict[str, Any]:
    """Return a film's halftone in outside names; `piece` [mm]."""
    level, bare = Levelling.of(job, piece, where), halftone.groove.curvature_empty
    share = (bare - halftone.tone) / (bare - halftone.curvature)
    aside = halftone.groove.pitch * _ASIDE
    levelled, beside = (
        halftone.levelled(piece, level.parts, level.length, shift=(x, 0.0)) for x in (0.0, aside)
    )
    found = {
        "curvature_per_mm": halftone.curvature,
        "fill": halftone.fill,
        "piece_mm": piece,
        "grooves": halftone.side_by_side,
        "share_wanted": [float(share.min()), float(share.max())],
        "share": halftone.share,
        "levelling_length_mm": level.length,
        "modulation_left": level.modulation,
        "mean_curvature_per_mm": float(halftone.two_level.mean()),
        "levelled_mean_curvature_per_mm": float(levelled.mean()),
        "beside_mean_curvature_per_mm": float(beside.mean()),
    }
    return found | {"words": _words(found)}


def _words(found: dict[str, Any]) -> str:
    """Return a described halftone as a sentence."""
    low, high = found["share_wanted"]
    return (
        "halftone: pieces of {piece_mm:.4g} mm × {grooves} grooves bare or printed with C "
        "{curvature_per_mm:.4g} /mm (fill {fill:.2%})".format(**found)
        + f", {low:.0%} … {high:.0%} of them printed, {found['share']:.1%} in the mean; levelling "
        "over {levelling_length_mm:.3g} mm leaves {modulation_left:.0%} of printed and bare in "
        "turn and takes the mean C from {mean_curvature_per_mm:.4g} to "
        "{levelled_mean_curvature_per_mm:.4g} /mm, a print a quarter of a groove aside "
        "to {beside_mean_curvature_per_mm:.4g} /mm".format(**found)
    )
