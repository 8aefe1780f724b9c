"""What coupons say about transfer factor and tone curve: a prior, and the posterior from prints.

The logarithm of each coupon's fill is normal about that of the model, with the deviation of its
measurement and that from print to print. The posterior is the normal distribution about the most
probable parameters (Laplace); when coupons scatter more than they should, it is widened by Birge's
ratio.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.process.tone import ToneBelief, fill_of, log_gradient

#: The published line's dead zone, contrast and gain by least squares (rms 0.017 of the share); the
#: deviations are such that a straight line (no dead zone, contrast and gain 1) is two of them off.
PRIOR_MEAN = (0.004, float(np.log(1.385)), float(np.log(1.45)))
PRIOR_DEVIATION = (0.004, 0.17, 0.19)
#: Share of a mesh's volume that leaves it, of a print that nobody has measured: the published pair
#: on a 90-48 mesh gives 0.65; from 0.42 to 1 in 95 % of cases.
PRIOR_RELEASE, RELEASE_DEVIATION = 0.65, 0.22
#: Deviation of ln(transfer factor) when nothing is known of the screen.
UNKNOWN_FACTOR = 1.0
#: From print to print and from groove to groove, of ln(fill): assumed, until coupons are repeated.
SPREAD = 0.03
#: Coupons whose fill falls with the aperture ratio by more than so many deviations are swapped.
SWAPPED = 4.0
ITERATIONS, SETTLED = 200, 1e-10


@dataclass(frozen=True)
class FillCoupon:
    """One print: its aperture ratio, the fill that came of it, and the deviation of ln(fill)."""

    aperture_ratio: float
    fill_fraction: float
    log_deviation: float
    name: str


@dataclass(frozen=True, eq=False)
class Calibration:
    """The posterior, and how the coupons lie about it.

    Attributes
    ----------
    belief
        transfer factor and tone curve
    residual
        (k,) float64, ln(fill) of each coupon less the model's
    birge
        by which the intervals were widened, 1 or more
    """

    belief: ToneBelief
    residual: NDArray[np.float64]
    birge: float


def prior_belief(transfer_factor: float | None, log_deviation: float | None = None) -> ToneBelief:
    """Return the prior: the published tone curve, and a transfer factor when the screen gives one.

    `transfer_factor` is the fill at aperture ratio 1; None: anything from 0.14 to 7.
    """
    factor = 1.0 if transfer_factor is None else transfer_factor
    if log_deviation is None:
        log_deviation = UNKNOWN_FACTOR if transfer_factor is None else RELEASE_DEVIATION
    mean = np.array([np.log(factor), *PRIOR_MEAN])
    return ToneBelief(mean, np.diag(np.array([log_deviation, *PRIOR_DEVIATION]) ** 2))


def calibrate(
    prior: ToneBelief, coupons: Sequence[FillCoupon], spread: float = SPREAD
) -> Calibration:
    """Return what coupons make of a prior.

    Raises
    ------
    InputError
        for fewer than two aperture ratios, a coupon that is no print, or more aperture that gave
        less resin.
    """
    ratios = {coupon.aperture_ratio for coupon in coupons}
    if len(ratios) < 2:
        given = ", ".join(f"{ratio:g}" for ratio in sorted(ratios))
        raise InputError(f"aperture_ratio: {given}: expected two or more different ones")
    for coupon in coupons:
        if not (0 < coupon.aperture_ratio <= 1 and 0 < coupon.fill_fraction < 1):
            raise InputError(
                f"{coupon.name}: aperture_ratio {coupon.aperture_ratio:g}, fill_fraction "
                f"{coupon.fill_fraction:.4g}: expected both above 0, and a groove that is not full"
            )
    _check_order(coupons, spread)
    ratio = np.array([coupon.aperture_ratio for coupon in coupons])
    wanted = np.log([coupon.fill_fraction for coupon in coupons])
    weight = 1 / (np.array([c.log_deviation for c in coupons]) ** 2 + spread**2)
    inverse = np.asarray(np.linalg.inv(prior.covariance), np.float64)
    mean = _most_probable(prior, inverse, ratio, wanted, weight)
    slope = log_gradient(mean, ratio)
    residual = wanted - np.log(fill_of(mean, ratio))
    precision = inverse + slope.T @ (weight[:, None] * slope)
    covariance = np.asarray(np.linalg.inv(precision), np.float64)
    birge = float(np.sqrt(max(1.0, np.sum(weight * residual**2) / len(ratio))))
    return Calibration(ToneBelief(mean, covariance * birge**2), residual, birge)


def _check_order(coupons: Sequence[FillCoupon], spread: float) -> None:
    """Refuse less resin from more aperture, beyond what measurement and print scatter."""
    by_ratio = sorted(coupons, key=lambda coupon: coupon.aperture_ratio)
    for i, less in enumerate(by_ratio):
        for more in by_ratio[i + 1 :]:
            fall = np.log(less.fill_fraction / more.fill_fraction)
            error = np.hypot(np.hypot(less.log_deviation, more.log_deviation), 2**0.5 * spread)
            if more.aperture_ratio > less.aperture_ratio and fall > SWAPPED * error:
                raise InputError(
                    f"{more.name}: fill {more.fill_fraction:.4g} at aperture_ratio "
                    f"{more.aperture_ratio:g}, but {less.name} has {less.fill_fraction:.4g} at "
                    f"{less.aperture_ratio:g}: expected more resin from more aperture: are the "
                    "ratios swapped?"
                )


def _most_probable(
    prior: ToneBelief,
    inverse: NDArray[np.float64],
    ratio: NDArray[np.float64],
    wanted: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the parameters of greatest probability, by damped Gauss-Newton steps.

    The dead zone stays between 0 and a tenth below the smallest coupon: that one did print.
    """
    top = 0.9 * float(ratio.min())

    def cost(mean: NDArray[np.float64]) -> float:
        aside = mean - prior.mean
        residual = wanted - np.log(fill_of(mean, ratio))
        return float(aside @ inverse @ aside + np.sum(weight * residual**2))

    mean = prior.mean.copy()
    mean[1] = np.clip(mean[1], 0, top)
    for _ in range(ITERATIONS):
        slope = log_gradient(mean, ratio)
        residual = wanted - np.log(fill_of(mean, ratio))
        gradient = slope.T @ (weight * residual) - inverse @ (mean - prior.mean)
        step = np.linalg.solve(inverse + slope.T @ (weight[:, None] * slope), gradient)
        before = cost(mean)
        for share in 0.5 ** np.arange(12):
            trial = mean + share * step
            trial[1] = np.clip(trial[1], 0, top)
            if cost(trial) <= before:
                break
        else:
            break
        moved, mean = np.abs(trial - mean).max(), trial
        if moved < SETTLED:
            break
    return mean
