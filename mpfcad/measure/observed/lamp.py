"""The lamps' pitch and place, found in a luminance curve."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError

#: Share of a curve's variance that its period must explain.
_SHOWN = 0.5
#: A shorter period that explains nearly as much is the pitch; longer ones are its multiples.
_AS_GOOD = 0.97
_HARMONICS = 3
_TRIED = 600
#: Periods that a curve must hold for its pitch to be found; 3, less what a rim may cost.
_PERIODS = 2.9
#: A period is shown clearly where it explains this share; periods alike within this share.
_CLEAR, _ALIKE = 0.8, 0.03
#: Periods near a stated one that are tried.
_NEAR, _TRIED_NEAR = 0.12, 49
#: A lamp pitch this much off the expected one is named, the scale of a file; from there refused.
NAMED_PITCH, SAME_PITCH = 0.015, 0.05
#: A share that leaves no room for another period.
_SURE = 0.995


def find_pitch(
    name: str, position: NDArray[np.float64], luminance: NDArray[np.float64],
    option: str = "--pitch-mm",
) -> float:  # fmt: skip
    """Return the period [mm] of a curve (n,) that shows the lamps three times or more.

    The shortest period is taken of which three harmonics explain nearly as much as of any.

    Raises
    ------
    InputError
        when no period explains half of what a slow trend leaves, or the curve is too short to tell.
    """
    found, share = _best(position, luminance)
    if share < _SHOWN:
        raise InputError(
            f"{name}: no lamp pitch seen: the best period, {found:.4g} mm, explains "
            f"{share:.0%} of its variation: expected {option}"
        )
    length = float(np.ptp(position))
    doubled = _explained(position, luminance, 2 * found)[0]
    # Of a curve that holds it hardly twice, half the pitch explains much; the pitch, far more.
    halved = share < _SURE and length < 4 * found and 1 - doubled < (1 - share) / 2
    if halved or length < _PERIODS * found:
        raise InputError(
            f"{name}: {length:.4g} mm, too short to find the lamp pitch, the best period being "
            f"{found:.4g} mm: expected three pitches or more: give {option}"
        )
    return found


def check_pitch(
    name: str, position: NDArray[np.float64], luminance: NDArray[np.float64], stated: float,
    option: str = "--pitch-mm", expected: str = "the period that the file shows",
) -> str:  # fmt: skip
    """Refuse a stated period [mm] that a curve (n,) contradicts by showing another clearly.

    A multiple of the period that is seen is no contradiction. Returned is what is to be said of a
    period that is a little off; "" where it is not. `option` says whose the stated period is.

    Raises
    ------
    InputError
        naming both periods, and what each explains.
    """
    own = _explained(position, luminance, stated)[0]
    if stated > float(np.ptp(position)):
        return ""
    near, near_share = _near(position, luminance, stated)
    off = near / stated - 1
    if own < _CLEAR / 2:
        found, share = _best(position, luminance)
        times = max(1, round(stated / found))
        if share < _CLEAR or own >= share / 2 or abs(stated / (times * found) - 1) < _ALIKE:
            return ""
    else:
        found, share = near, near_share
        clear = share >= _CLEAR and 1 - share < (1 - own) / 2
        if not clear or abs(off) < NAMED_PITCH or np.ptp(position) < _PERIODS * stated:
            return ""
        if abs(off) < SAME_PITCH:
            return (
                f"the file's period, {near:.5g} mm, is {off:+.1%} off {option} {stated:.5g}: it "
                f"explains {share:.1%} of the variation, the stated one {own:.1%}"
            )
    raise InputError(
        f"{name}: {option} {stated:.5g}: that period explains {own:.0%} of the variation, "
        f"{found:.5g} mm explains {share:.0%}: expected {expected}"
    )


def _near(
    position: NDArray[np.float64], luminance: NDArray[np.float64], stated: float
) -> tuple[float, float]:
    """Return the period [mm] near a stated one that explains most, and how much it does."""
    found, width = stated, _NEAR
    for _ in range(2):
        tried = found + stated * np.linspace(-width, width, _TRIED_NEAR)
        shares = [_explained(position, luminance, float(p))[0] for p in tried]
        found, width = float(tried[int(np.argmax(shares))]), 2 * width / _TRIED_NEAR
    return found, max(shares)


def _best(position: NDArray[np.float64], luminance: NDArray[np.float64]) -> tuple[float, float]:
    """Return the shortest period [mm] that explains nearly as much as any, and the best's share."""
    length = float(np.ptp(position))
    step = float(np.median(np.diff(position)))
    tried = np.geomspace(max(8 * step, length / 60), length / 1.9, _TRIED)
    shares = np.array([_explained(position, luminance, p)[0] for p in tried])
    best = int(np.argmax(shares))
    peaks = np.flatnonzero(
        (shares >= _AS_GOOD * shares[best])
        & (shares >= np.roll(shares, 1))
        & (shares >= np.roll(shares, -1))
    )
    first = int(peaks[0]) if len(peaks) else best
    near = np.linspace(tried[max(first - 1, 0)], tried[min(first + 1, _TRIED - 1)], 101)
    found = float(near[np.argmax([_explained(position, luminance, p)[0] for p in near])])
    return found, float(shares[best])


def find_phase(
    position: NDArray[np.float64], luminance: NDArray[np.float64], pitch: float
) -> float:
    """Return where [mm] the first harmonic of a curve is highest: taken as above a lamp."""
    _, wave = _explained(position, luminance, pitch)
    return float(np.arctan2(wave[1], wave[0]) / (2 * np.pi) * pitch + position[0])


def _explained(
    position: NDArray[np.float64], luminance: NDArray[np.float64], pitch: float
) -> tuple[float, NDArray[np.float64]]:
    """Return the share of variance about a quadratic trend, and cosine and sine of the pitch."""
    x = position - position[0]
    trend = np.stack([np.ones_like(x), x, x**2], axis=1)
    angle = 2 * np.pi * x / pitch
    waves = [f(k * angle) for k in range(1, _HARMONICS + 1) for f in (np.cos, np.sin)]
    design = np.column_stack([*waves, trend])
    flat = luminance - trend @ np.linalg.lstsq(trend, luminance, rcond=None)[0]
    weight = np.linalg.lstsq(design, luminance, rcond=None)[0]
    left = luminance - design @ weight
    total = float(np.sum(flat**2))
    share = 1 - float(np.sum(left**2)) / total if total > 0 else 0.0
    return share, np.asarray(weight[:2], np.float64)
