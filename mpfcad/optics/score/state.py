"""What a path keeps to tell how its light follows the values of the scene: score functions.

A path of density p and weight w that finds the light c w adds to the derivative by a value θ

    c w Σ (∂ ln p/∂θ + ∂ ln w/∂θ),

the sum over its events up to there (the likelihood ratio: Rubinstein, "Sensitivity analysis and
performance extrapolation for computer simulation models", Operations Research 37, 1989). The sums
are plain counts and lengths: of a reflectance the number of reflections over it, of a scattering
coefficient the number of scatterings over it less the length flown. The terms of ln p have mean 0
at each event whatever came before; times the weight there they are a control (`control`) that takes
off the noise of the light to come.

Each kind of element has scores in a fixed order, `SCORES` columns at most. A trace without scores
hands None to the kernels: a type of its own, so that nothing of this is compiled into it.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.base import lanes
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes_array import aligned

#: The scores of a cavity: reflectance of lamps and reflector, its mirrored share.
AT_LAMP, AT_REFLECTOR, MIRRORED = range(3)
#: Of a plate.
SCATTERED, ABSORBED, TURNED = range(3)
#: Of a sheet: its lobes' widths, the wide one's share, transmission, index.
ALONG, ACROSS, WIDE, SHARE, PASSED, FACES = range(6)
#: Of a film.
SOAKED = 0
#: The most scores that an element has.
SCORES = 6
_CAVITY_SCORES = 3


class Score(NamedTuple):
    """The scores of paths under way, s slots, and what they come to; k scores of all elements.

    Attributes
    ----------
    total
        (s, k) float64, sums over the events of each slot's path
    first
        (e+1,) int64, the number of each element's first score
    step, drawn, gain
        (SCORES,) float64, of one passage: what it adds to the sums; of this what has mean 0; the
        light found in it times what it had added by then
    lane
        (16, 8) float64, the same of sixteen rays in the cavity
    light
        (p, k) float64, sum over all paths of light times score, a point
    control
        (2, p, k) float64, sum of the weights times the scores of mean 0; of rays that come to the
        element from above, from below
    """

    total: NDArray[np.float64]
    first: NDArray[np.int64]
    step: NDArray[np.float64]
    drawn: NDArray[np.float64]
    gain: NDArray[np.float64]
    lane: NDArray[np.float64]
    light: NDArray[np.float64]
    control: NDArray[np.float64]

    @classmethod
    def empty(cls, first: NDArray[np.int64], points: int, slots: int) -> "Score":
        """Return the scores of no path."""
        count = int(first[-1])
        step, drawn, gain = np.zeros((3, SCORES))
        return cls(
            np.zeros((slots, count)), first, step, drawn, gain,
            aligned((lanes.WIDE, 8), np.float64), np.zeros((points, count)),
            np.zeros((2, points, count)),
        )  # fmt: skip


@kernel
def begin_scores(score, slots):
    """Start the paths of slots."""
    if score is not None:
        for i in range(len(slots)):
            score.total[slots[i]] = 0.0


@kernel
def weigh(score, column, step):
    """Add ∂ ln w/∂θ at an event that changes the weight."""
    if score is not None:
        score.step[column] += step


@kernel
def soak(score, absorption, survival):
    """Add the score of a film that has let through exp(-absorption · length)."""
    if score is not None:  # noqa: SIM102, a type is told apart by this alone
        if absorption > 0.0 and survival > 0.0:
            score.step[SOAKED] += math.log(survival) / absorption


@kernel
def draw(score, column, step):
    """Add ∂ ln p/∂θ at an event drawn with the density p."""
    if score is not None:
        score.step[column] += step
        score.drawn[column] += step


@kernel
def draw_weighed(score, column, step, weight):
    """Add ∂ ln p/∂θ at an event within a passage on which the path has changed its weight."""
    if score is not None:
        score.step[column] += step
        score.drawn[column] += weight * step


@kernel
def shine(score, radiance):
    """Count light found within the cavity, by the scores of this passage up to there."""
    if score is not None:
        for j in range(_CAVITY_SCORES):
            score.gain[j] += radiance * score.step[j]


@kernel
def shine_by(score, column, slope):
    """Count by how much light that is found follows a value itself."""
    if score is not None:
        score.gain[column] += slope


@kernel
def settle(score, wave, slot, e, weight, found):
    """Put a slot's passage through element e to its path, and clear it for the next.

    `weight` is what multiplies the scores of mean 0; `found` all light of the passage.
    """
    if score is not None:
        point = wave.path[slot] % len(score.light)
        found_before(score, slot, point, found)
        first, up = score.first[e], wave.upward[slot]
        for j in range(score.first[e + 1] - first):
            score.total[slot, first + j] += score.step[j]
            score.light[point, first + j] += score.gain[j]
            score.control[up, point, first + j] += weight * score.drawn[j]
            score.step[j], score.drawn[j], score.gain[j] = 0.0, 0.0, 0.0


@kernel
def found_before(score, slot, point, found):
    """Count light by the sums of its path."""
    if found != 0.0:
        for k in range(score.light.shape[1]):
            score.light[point, k] += found * score.total[slot, k]


@kernel
def see(score, wave, slot, found):
    """Count light that a slot's path finds where it ends."""
    if score is not None:
        found_before(score, slot, wave.path[slot] % len(score.light), found)


@kernel
def settle_lanes(score, wave, slots):
    """Put the passages of up to sixteen slots through the cavity, in `lane`, to their paths."""
    if score is not None:
        for i in range(len(slots)):
            for j in range(_CAVITY_SCORES):
                score.step[j] = score.lane[i, j]
                score.gain[j] = score.lane[i, _CAVITY_SCORES + j]
            score.drawn[MIRRORED] = score.lane[i, 2 * _CAVITY_SCORES]
            settle(score, wave, slots[i], 0, 1.0, wave.lane_flow[i, 0])
