"""Whether a trace shows grooves at all, and alike: what the fit leaves of their shapes."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.groove import Groove
from mpfcad.film.stylus.correlation import correlation_sum
from mpfcad.film.stylus.model import CENTRE, FILL, OWN_FILL, PITCH, TraceModel
from mpfcad.film.stylus.residual import SAID, shape_misfit
from mpfcad.film.stylus.solve import Fitted, solve
from mpfcad.film.stylus.trace import StylusTrace
from mpfcad.film.stylus.upright import lie_of
from mpfcad.units import um

#: A trace whose residual exceeds this share of its own standard deviation shows no such groove.
UNEXPLAINED = 0.5
#: Standard deviations of the grooves' C, as shares of their mean or of half of what just covers the
#: walls, if that is more, that are said, and refused.
_DIFFER, _UNLIKE = 0.08, 0.2
#: Grooves that differ by chance alone have a sum of squares as this share of χ².
_CHANCE = 0.999
#: A groove is looked at that leaves more [mm] and so many times what a good one does; it is odd
#: where without it, and at most this share of them, so much less is left of all.
_LEAVES, _TIMES, _ODD, _LESS = 0.1 * um, 2.0, 1 / 3, 0.5
#: Shares of the relief by which the grooves' mean shape may differ from the model before it is
#: asked whether upside down it fits as well, and before it is refused in any case. A meniscus of a
#: circle's shape differs by up to 5 %, and far more upside down; a sine by 2 … 26 %, either way.
_ASKED, _REFUSED = 0.04, 0.08
#: Share of a groove that a file must show of it to count as the file's first.
_SEEN = 0.05


@dataclass(frozen=True)
class GrooveNumbers:
    """The grooves of a file, numbered from 1 by rising x; parts at its ends count as grooves.

    Attributes
    ----------
    left, pitch
        of groove 1: its left tip, and its width [mm]
    ends
        least and largest x of the file [mm]
    middle
        x of the file where a fit's positions are 0 [mm]
    """

    left: float
    pitch: float
    ends: tuple[float, float]
    middle: float

    @classmethod
    def of(cls, trace: StylusTrace, fit: Fitted, middle: float) -> "GrooveNumbers":
        """Return the numbers of all grooves of a trace by the place of those that were fitted."""
        first, last, pitch = trace.position[0], trace.position[-1], float(fit.value[PITCH])
        tip = middle + fit.value[CENTRE] - pitch / 2
        left = tip + np.floor((first - tip) / pitch + _SEEN) * pitch
        return cls(float(left), pitch, (float(first), float(last)), middle)

    def words(self, centre: NDArray[np.float64]) -> str:
        """Return which grooves have centres at positions of a fit, (m,) [mm], and where they lie.

        Such as `grooves 2, 3 and 6 of 9 (x 51 … 151 and 251 … 301 µm)`.
        """
        count = int(np.ceil((self.ends[1] - self.left) / self.pitch - _SEEN))
        number = np.floor((centre + self.middle - self.left) / self.pitch).astype(int)
        # A sliver at an end of the file counts with the groove beside it.
        number = np.unique(np.clip(number, 0, count - 1))
        runs = np.split(number, np.flatnonzero(np.diff(number) > 1) + 1)
        low, high = self.ends
        places = [
            f"{max(self.left + run[0] * self.pitch, low) / um:.0f} … "
            f"{min(self.left + (run[-1] + 1) * self.pitch, high) / um:.0f}"
            for run in runs
        ]
        names = [str(k + 1) for k in number]
        return (
            f"groove{'s' if len(names) > 1 else ''} {_listed(names)} of {count} "
            f"(x {_listed(places)} µm)"
        )


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def _centres(model: TraceModel, value: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return where the centres of a model's grooves lie, (grooves,) [mm]."""
    first = np.floor((model.x.min() - value[CENTRE]) / value[PITCH] + 0.5)
    centres: NDArray[np.float64] = value[CENTRE] + value[PITCH] * (first + np.arange(model.grooves))
    return centres


def check_shape(
    trace: StylusTrace, fit: Fitted, groove: Groove, numbers: GrooveNumbers
) -> list[str]:
    """Return what is to be said of a trace whose shape is not quite a groove's.

    Raises
    ------
    InputError
        when it shows none of this pitch and depth.
    """
    relief = float(np.std(fit.model.levelled(fit.value)))
    if not _is_explained(fit):
        raise InputError(
            f"{trace.name}: z_um: residual {fit.rms / um:.3g} µm rms of {relief / um:.3g} µm of "
            f"relief: expected a trace that shows grooves of pitch {groove.pitch / um:g} µm and "
            f"depth {groove.depth / um:g} µm"
        )
    said = _differing(trace, fit, numbers)
    off = shape_misfit(fit)
    options = (groove, fit.model.profile, trace.tip)
    if off > _REFUSED * relief or (
        off > _ASKED * relief and lie_of(trace.position, trace.height, *options).way != "up"
    ):
        raise InputError(
            f"{trace.name}: z_um: the grooves' mean shape is {off / um:.3g} µm rms off walls and "
            f"parabola, {off / relief:.0%} of {relief / um:.3g} µm of relief: expected a trace "
            f"across grooves of pitch {groove.pitch / um:g} µm and depth {groove.depth / um:g} µm"
        )
    if off > SAID * relief:
        said.append(
            f"the grooves' mean shape is {off / um:.2g} µm rms off walls and parabola, "
            f"{off / relief:.1%} of the relief, more than noise: are these such grooves?"
        )
    return said


def _is_explained(fit: Fitted) -> bool:
    return fit.rms <= UNEXPLAINED * float(np.std(fit.model.levelled(fit.value)))


def _differing(trace: StylusTrace, fit: Fitted, numbers: GrooveNumbers) -> list[str]:
    """Return what is to be said of grooves of different fill.

    Raises
    ------
    InputError
        where they differ so much that their mean is that of none.
    """
    each = fit.curvature_of_each
    if fit.model.grooves < OWN_FILL:
        return []
    mean, spread = float(np.mean(each)), float(np.std(each))
    share = spread / max(mean, fit.model.groove.curvature_covered / 2)
    if share < _DIFFER or not _differ(fit):
        return []
    far = int(np.argmax(np.abs(each - mean)))
    name = numbers.words(_centres(fit.model, fit.value)[fit.whole][[far]])
    words = (
        f"the grooves' C are {each.min():.3g} … {each.max():.3g} /mm, ± {spread:.2g} /mm from "
        f"groove to groove; {name} is farthest from the mean"
    )
    if share > _UNLIKE:
        raise InputError(f"{trace.name}: z_um: {words}: expected grooves alike, of one coupon")
    return [words]


def _differ(fit: Fitted) -> bool:
    """Return whether grooves of one fill fit worse than noise allows."""
    from scipy.stats import chi2

    alike = replace(fit.model, grooves=1)
    start = np.append(fit.value[:FILL], np.mean(fit.fills))
    found = solve(alike, start, fit.noise, close=1e-5)
    left = fit.model.residual(fit.value)
    rise = np.sum(alike.residual(found) ** 2) - np.sum(left**2)
    return bool(rise > chi2.ppf(_CHANCE, len(fit.fills)) * fit.noise**2 * correlation_sum(left))


@dataclass(frozen=True, eq=False)
class OddGrooves:
    """The trace without grooves that are none of the others' kind, and what is said of them."""

    rest: StylusTrace
    words: str


def odd_grooves(
    used: StylusTrace,
    fit: Fitted,
    refit: Callable[[StylusTrace], Fitted],
    numbers: GrooveNumbers,
) -> OddGrooves | None:
    """Return a trace without the grooves that leave far more than the others; None: all alike.

    A prism that is missing or cut, or dirt, bends the fit of all grooves. The grooves that leave
    most are left out one after the other, until the rest fits.
    """
    # Beside those whole there is a part of one at each end.
    count = fit.model.grooves
    if count < OWN_FILL:
        return None
    left, number = _left(fit), fit.every.number(fit.value)
    if not (_is_explained(fit) and _stands_out(_each(left, number, count))):
        return None

    def without(out: NDArray[np.bool_]) -> tuple[StylusTrace, NDArray[np.float64]]:
        kept = ~out[number]
        rest = replace(used, position=used.position[kept], height=used.height[kept])
        return rest, _left(refit(rest))

    out = _worst(left, number, count, without)
    if out is None:
        # A missing prism bends the fit so much that other grooves leave more than its own two.
        pairs = [np.isin(np.arange(count), (k, k + 1)) for k in range(count - 1)]
        out = min(pairs, key=lambda pair: float(np.mean(without(pair)[1])))
    rest, still = without(out)
    if float(np.mean(still)) >= _LESS * float(np.mean(left)):
        return None
    names = numbers.words(_centres(fit.every, fit.value)[out])
    words = (
        f"{names} left out: {np.mean(left[out[number]]) / um:.2g} µm off on average, the others "
        f"{np.mean(still) / um:.2g}: a prism is missing or cut there, or there is dirt"
    )
    return OddGrooves(rest, words)


def _worst(
    left: NDArray[np.float64],
    number: NDArray[np.int64],
    count: int,
    without: Callable[[NDArray[np.bool_]], tuple[StylusTrace, NDArray[np.float64]]],
) -> NDArray[np.bool_] | None:
    """Return the grooves that leave most, one after the other, until the rest fits; or None."""
    each, most = _each(left, number, count), float(np.mean(left))
    out, found = np.zeros(count, bool), None
    for _ in range(max(int(_ODD * count), 1)):
        if not _stands_out(each[~out]):
            break
        out[int(np.argmax(np.where(out, -1.0, each)))] = True
        still = without(out)[1]
        if float(np.mean(still)) < _LESS * most:
            most, found = float(np.mean(still)), out.copy()
        each = np.where(out, each, _each(still, number[~out[number]], count))
    return found


def _stands_out(each: NDArray[np.float64]) -> bool:
    seen = each[each > 0]
    return bool(each.max() > max(_LEAVES, _TIMES * float(np.quantile(seen, 0.25))))


def _left(fit: Fitted) -> NDArray[np.float64]:
    """Return what a fit leaves of all heights, spikes too, (n,) [mm]."""
    return np.abs(fit.every.residual(fit.value))


def _each(left: NDArray[np.float64], number: NDArray[np.int64], count: int) -> NDArray[np.float64]:
    """Return the mean of each groove, 0 of one that is not there, (count,)."""
    places = np.maximum(np.bincount(number, minlength=count), 1)
    return np.bincount(number, left, count) / places
