"""Which way up a trace lies: both readings fitted by the same model, tip, waviness and gain.

A row of grooves turned upside down is a row of grooves of another shape: resin's round valleys
become round tips, which a blunt stylus makes, too. So neither the sharper nor the rounder side
tells, and the likelihood of the two readings is compared, each with the tip that suits it best.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from mpfcad.film.groove import Groove, Profile
from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import MOST_OFF, TraceModel
from mpfcad.film.stylus.residual import SAID, misfit_share
from mpfcad.film.stylus.solve import Fitted, fit_model
from mpfcad.film.stylus.tip import StylusTip
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.units import um

Way = Literal["up", "down", "either", "neither"]
#: Prism widths, and heights in each, that tell which way up a trace lies.
_WIDTHS, _A_WIDTH = 8, 50
#: By how much ln(likelihood ratio)·2 must differ, as of independent heights: six deviations.
_CERTAIN = 36.0
#: A reading that leaves more of the relief than this is none. One that leaves more than `SAID` is
#: one only where the other leaves so many times as much.
_NONE, _WORSE = 0.08, 1.5
#: Tips that tell it; between them the prism tips' own rounding, which is sought, does as well.
_TIPS = (StylusTip(2 * um), StylusTip(5 * um), StylusTip(12.5 * um))
#: A tip that leaves so many times the misfit of the best is too large, and so are larger ones.
_TOO_LARGE = 2.0


@dataclass(frozen=True, eq=False)
class Reading:
    """A trace taken one way: its best fit, and minus twice its log-likelihood is `loss`/noise²."""

    fit: Fitted
    residual: NDArray[np.float64]
    share: float

    @property
    def curvature(self) -> float:
        """C [1/mm] that it gives."""
        return self.fit.curvature


@dataclass(frozen=True)
class Lie:
    """Which way a trace lies, and both readings."""

    way: Way
    up: Reading
    down: Reading

    @property
    def fits(self) -> bool:
        """Whether one of them leaves no more than noise, or hardly more."""
        return self.share <= SAID

    @property
    def leans_up(self) -> bool:
        """Whether tips up leaves the less of both, and no more than a groove's meniscus may."""
        return self.up.share < self.down.share and self.up.share <= _NONE

    @property
    def share(self) -> float:
        """The less of what both leave of the relief."""
        return min(self.up.share, self.down.share)

    @property
    def misfit(self) -> float:
        """The less of both mean absolute residuals [mm]."""
        return min(self.up.fit.misfit, self.down.fit.misfit)

    @property
    def words(self) -> str:
        """Return both readings, and what each leaves."""
        up, down = _percent(self.up.share), _percent(self.down.share)
        return (
            f"tips up, C = {self.up.curvature:.3g} /mm leaves {up} of the relief, "
            f"upside down, C = {self.down.curvature:.3g} /mm leaves {down}"
        )


def lie_of(
    x: NDArray[np.float64],
    z: NDArray[np.float64],
    groove: Groove,
    profile: Profile = "filled",
    tip: StylusTip | None = None,
) -> Lie:
    """Return which way up heights (n,) [mm] lie, by the usual tips where the stated one fits not.

    `either`: both readings fit, and noise does not tell them apart. `neither`: the better one
    leaves more than noise, and the other hardly more than it.
    """
    thin = _thinned(x, z, groove)
    steepest = groove.wall_slope * (1 + MOST_OFF)
    if tip is not None:
        told = _compared(
            *(_read(thin, sign, groove, profile, tip.told(steepest)) for sign in (1, -1))
        )
        # A stated tip that leaves more than noise may be another's, in a header.
        if told.share == 0:
            return told
    tips = [None, *(tip.told(steepest) if tip else []), *_TIPS]
    return _compared(*(_read(thin, sign, groove, profile, tips) for sign in (1, -1)))


def _thinned(x: NDArray[np.float64], z: NDArray[np.float64], groove: Groove) -> StylusTrace:
    """Return the middle prism widths, of as many heights as tell their shape."""
    step = float(np.median(np.diff(x)))
    stride = max(1, int(groove.pitch / step / _A_WIDTH))
    trace = StylusTrace(x[::stride], z[::stride], "")
    return trace.middle(min(max(trace.widths(groove.pitch), 1), _WIDTHS) * groove.pitch)


def _read(
    trace: StylusTrace, sign: int, groove: Groove, profile: Profile,
    tips: Sequence[StylusTip | None],
) -> Reading:  # fmt: skip
    """Return the best reading of a trace whose heights are turned by a sign."""
    widths = max(trace.widths(groove.pitch), 1)
    x = trace.position - float(np.mean(trace.position))
    best: tuple[Fitted, TraceModel] | None = None
    for tip in tips:
        model = TraceModel.of(x, sign * trace.height, groove, profile, tip, widths)
        fit = fit_model(model)
        if best is None or fit.misfit < best[0].misfit:
            best = fit, model
        elif tip is not None and fit.misfit > _TOO_LARGE * best[0].misfit:
            break
    assert best is not None
    fit, model = best
    return Reading(fit, model.residual(fit.value), misfit_share(fit))


def _compared(up: Reading, down: Reading) -> Lie:
    """Return which of two readings the heights are likelier of."""
    best = min((up, down), key=lambda reading: reading.fit.misfit)
    noise = best.fit.noise
    inner = best.fit.model.residual(best.fit.value)
    behind = (_loss(down, noise) - _loss(up, noise)) / correlation_sum(inner)
    less, more = sorted((up.share, down.share))
    if less > _NONE or (less > SAID and more < _WORSE * less):
        return Lie("neither", up, down)
    # Priors alone turn no trace: tips that are flat are unlikely, and fit the better.
    if abs(behind) < _CERTAIN or (behind < 0 and up.share < down.share):
        return Lie("either", up, down)
    return Lie("up" if behind > 0 else "down", up, down)


def _percent(share: float) -> str:
    return f"{100 * share:.2g}%"


def _loss(reading: Reading, noise: float) -> float:
    """Return the robust sum of squares over noise², priors included; spikes count little."""
    fit = reading.fit
    square = np.sum(18 * (np.sqrt(1 + (reading.residual / (3 * noise)) ** 2) - 1))
    return float(square + np.sum(fit.model.prior(fit.value) ** 2))
