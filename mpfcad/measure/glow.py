"""Paths of a meter that end on the reflector, with the mean of what others find from there.

Most of what a path costs, and of its noise, comes after it first meets a white reflector. What it
finds from there depends on the place alone, and where all films repeat with the lamps on the place
within a lamp pitch: one table serves all points (`optics/cavity/glow`). Of the reference stacks
each path then takes half the time and the harmonics of the luminance half the paths. The table's
own noise is common to all points. So much of it is traced that it adds little; the errors of points
and mean hold the rest.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.rounds import LEAST_PATHS, Lit, TraceRun, trace_lit, trace_rounds
from mpfcad.optics.repeat import repeats_with

if TYPE_CHECKING:
    from mpfcad.optics.base.recorder import Tally
    from mpfcad.optics.source import Source

#: Places of the table.
_PLACES = 64
#: Blocks of a pilot, of the table and of the meter.
_PILOT = 2, 4
#: What the table may add, in shares of their own variance, to any wave of the curve, to the mean.
_TO_WAVE, _TO_MEAN = 0.05, 3.0
#: Time of a path that ends on the reflector, over that of one that goes on; what must be saved.
_SHORT, _WORTH = 0.5, 0.8


@dataclass(frozen=True, eq=False)
class Glow:
    """A table that ends paths, and the errors that all points have from it.

    Attributes
    ----------
    lit
        the scene with the table
    error
        (n,) float64 [cd/m²], standard error of the table's places
    paths
        that it was traced with
    """

    lit: Lit
    error: NDArray[np.float64]
    paths: int

    def errors(self, tally: "Tally") -> tuple[NDArray[np.float64], float]:
        """Return what the table adds to a meter's errors [cd/m²]: at each point (p,), of the mean.

        The points' part is beside the mean's, and taken as independent from point to point.
        """
        shape, mean = _apart(_common(self.lit, tally, self.error**2))
        return np.sqrt(np.maximum(0.0, np.diag(shape))), float(np.sqrt(mean))


def find_glow(
    lit: Lit, source: "Source", run: TraceRun, plain: "Tally", blocks: float
) -> Glow | None:
    """Return a table for a meter; None where none can be, or it would save no time.

    `plain` is a tally of the meter without one, of which some `blocks` would be needed.
    """
    from mpfcad.optics.engine import BLOCK

    pilot = _pilot(lit, source, run)
    tally = trace_lit(pilot.lit, source, _PILOT[1], seed=run.seed, threads=run.threads)
    noise, before = _of_block(tally), _of_block(plain)
    if noise == 0.0 or before == 0.0:
        return None
    needed = max(2.0, blocks * noise / before)
    shape, mean = _apart(_common(pilot.lit, tally, pilot.error**2 * _PILOT[0]))
    wave = float(np.linalg.eigvalsh(shape)[-1])
    size = max(wave / _TO_WAVE, mean * len(shape) / _TO_MEAN) * needed / noise
    table = max(-(-LEAST_PATHS // (_PLACES * BLOCK)), int(np.ceil(size)))
    cost = table * _PLACES + _SHORT * needed * len(source.position)
    if cost > _WORTH * blocks * len(source.position):
        return None
    return _glow(lit, _table(lit, run, table))


def can_glow(lit: Lit) -> bool:
    """Return whether a scene has a white reflector under tubes without end, in one colour."""
    from mpfcad.optics.cavity.endless import BRDF, REFLECTANCE, SPECULAR_FRACTION
    from mpfcad.optics.element import CAVITY

    scene = lit.scene
    if lit.is_cell or lit.is_finite or scene.polarised or lit.spectral is not None:
        return False
    if len(scene.kind) == 0 or scene.kind[0] != CAVITY or scene.parameter[0, BRDF] >= 0:
        return False
    if scene.parameter[0, REFLECTANCE] * (1 - scene.parameter[0, SPECULAR_FRACTION]) <= 0:
        return False
    return repeats_with(lit.elements, lit.stack.period.across)


def _places(lit: Lit) -> "Source":
    """Return where the table's paths start: evenly over the pitch from a lamp's axis."""
    from mpfcad.optics.cavity.endless import LAMP_PITCH, LAMP_POSITION
    from mpfcad.optics.source import REFLECTOR, Source

    pitch, lamp = (float(lit.scene.parameter[0, i]) for i in (LAMP_PITCH, LAMP_POSITION))
    return Source(REFLECTOR, lamp + np.arange(_PLACES) / _PLACES * pitch, pitch / _PLACES)


def _pilot(lit: Lit, source: "Source", run: TraceRun) -> Glow:
    tally = trace_lit(lit, _places(lit), _PILOT[0], seed=run.seed, threads=run.threads)
    return _glow(lit, tally)


def _table(lit: Lit, run: TraceRun, blocks: int) -> "Tally":
    """Return the tally of a table of so many blocks or a few more."""
    from mpfcad.optics.engine import BLOCK

    run = replace(run, path_limit=blocks * _PLACES * BLOCK)
    return trace_rounds(
        lit, _places(lit), run, lambda tally: tally.blocks**-0.5, blocks**-0.5,
        "light at the reflector",
    )  # fmt: skip


def _glow(lit: Lit, tally: "Tally") -> Glow:
    table = np.append(tally.radiance, tally.radiance[0])
    scene = lit.scene._replace(glow=table)
    case = {**lit.case, "glow": table.tolist()}
    return Glow(replace(lit, scene=scene, case=case), tally.radiance_error, tally.total_paths)


def _of_block(tally: "Tally") -> float:
    """Return the mean variance of a point over a block [(cd/m²)²]."""
    return float(np.mean(tally.radiance_error**2) * tally.blocks)


def _common(lit: Lit, tally: "Tally", variance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the covariance (p, p) that a table with such variances gives a meter's points."""
    from mpfcad.optics.engine import landed_weights

    weight = landed_weights(lit.scene, tally)
    return (weight * variance) @ weight.T


def _apart(covariance: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return a covariance without the variance of its mean, and that variance."""
    one = covariance.mean(axis=0)
    shape = covariance - one - one[:, None] + one.mean()
    return shape, float(one.mean())
