"""The tone curve of a print: how much resin an aperture ratio lays down, as a share of a full area.

A screen loses its highlights and gains in the middle tones. With aperture ratio a, dead zone d,
contrast p and gain k

    x = (a - d) / (1 - d), 0 below d        t(a) = k x^p / (k x^p + (1 - x)^p)

so ln(t/(1-t)) = ln k + p ln(x/(1-x)): t(0) = 0, t(1) = 1, monotone, with a closed inverse. d = 0
and p = k = 1 are the straight line t = a. Fill = transfer factor · t(a).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: A published half-tone process line, film % and print %: Sefar, "Half-tone printing process line"
#: (www.sefar.com, 607, article 6566571); ink on paper, by densitometer.
PUBLISHED_LINE = np.array(
    [
        (1, 0), (6, 2), (11, 7), (17, 15), (22, 22), (32, 35), (40, 44), (47, 53),
        (53, 59), (63, 76), (69, 84), (76, 89), (83, 94), (91, 98), (99, 100),
    ],
    float,
) / 100  # fmt: skip
#: Names of the parameters, in the order of a `ToneBelief`: logarithms but for the dead zone.
PARAMETERS = ("ln_transfer_factor", "dead_zone", "ln_contrast", "ln_gain")


@dataclass(frozen=True)
class ToneCurve:
    """A tone curve; see the module.

    Attributes
    ----------
    dead_zone
        aperture ratio below which nothing is printed, 0 … 0.5
    contrast, gain
        p and k, above 0
    """

    dead_zone: float = 0.0
    contrast: float = 1.0
    gain: float = 1.0

    def share(self, aperture_ratio: ArrayLike) -> NDArray[np.float64]:
        """Return t, 0…1, of an aperture ratio 0…1."""
        a = np.asarray(aperture_ratio, float)
        x = np.clip((a - self.dead_zone) / (1 - self.dead_zone), 0.0, 1.0)
        up = self.gain * x**self.contrast
        return up / (up + (1 - x) ** self.contrast)

    def aperture_ratio(self, share: ArrayLike) -> NDArray[np.float64]:
        """Return the aperture ratio of t: the inverse; 0 for t = 0."""
        t = np.asarray(share, float)
        root = (t / self.gain) ** (1 / self.contrast)
        x = root / (root + (1 - t) ** (1 / self.contrast))
        return np.where(t > 0, self.dead_zone + (1 - self.dead_zone) * x, 0.0)


@dataclass(frozen=True, eq=False)
class ToneBelief:
    """What is believed of transfer factor and tone curve: a normal distribution of `PARAMETERS`.

    Attributes
    ----------
    mean
        (4,) float64
    covariance
        (4, 4) float64
    """

    mean: NDArray[np.float64]
    covariance: NDArray[np.float64]

    @property
    def transfer_factor(self) -> float:
        """Fill fraction at aperture ratio 1, could the groove hold it."""
        return float(np.exp(self.mean[0]))

    @property
    def curve(self) -> ToneCurve:
        """The tone curve at the mean."""
        return ToneCurve(float(self.mean[1]), *(float(v) for v in np.exp(self.mean[2:])))

    @property
    def deviation(self) -> NDArray[np.float64]:
        """Standard deviation of each parameter, (4,) float64."""
        return np.sqrt(np.diag(self.covariance))

    def fill(self, aperture_ratio: ArrayLike) -> NDArray[np.float64]:
        """Return the fill fraction at the mean, not cut at a full groove."""
        return fill_of(self.mean, aperture_ratio)

    def log_deviation(self, aperture_ratio: ArrayLike) -> NDArray[np.float64]:
        """Return the standard deviation of ln(fill) at aperture ratios, (k,) float64.

        By the gradient; where nothing is printed at the mean, it is taken a hair above.
        """
        return np.sqrt(np.sum(self.log_root(aperture_ratio) ** 2, axis=1))

    def log_root(self, aperture_ratio: ArrayLike) -> NDArray[np.float64]:
        """Return a root of ln(fill)'s covariance at k ratios, root @ root.T; (k, 4) float64."""
        ratio = np.maximum(np.asarray(aperture_ratio, float), self.mean[1] + 1e-3)
        value, vector = np.linalg.eigh(self.covariance)
        slope = log_gradient(self.mean, ratio)
        return np.asarray(slope @ (vector * np.sqrt(np.maximum(value, 0.0))), np.float64)

    def scaled(self, factor: float, log_deviation: float = 0.0) -> "ToneBelief":
        """Return the belief with the transfer factor multiplied, and widened by a relative σ."""
        mean, covariance = self.mean.copy(), self.covariance.copy()
        mean[0] += np.log(factor)
        covariance[0, 0] += log_deviation**2
        return ToneBelief(mean, covariance)


def fill_of(parameter: NDArray[np.float64], aperture_ratio: ArrayLike) -> NDArray[np.float64]:
    """Return the fill fraction that parameters give, not cut at a full groove."""
    curve = ToneCurve(float(parameter[1]), *(float(v) for v in np.exp(parameter[2:])))
    return np.exp(parameter[0]) * curve.share(aperture_ratio)


def log_gradient(
    parameter: NDArray[np.float64], aperture_ratio: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return d ln(fill) / d parameter, (k, 4), for aperture ratios between dead zone and 1."""
    dead, contrast = float(parameter[1]), float(np.exp(parameter[2]))
    a = np.minimum(np.atleast_1d(aperture_ratio), 1 - 1e-9)
    x = np.clip((a - dead) / (1 - dead), 1e-12, 1 - 1e-9)
    odds = np.log(x / (1 - x))
    t = 1 / (1 + np.exp(-(parameter[3] + contrast * odds)))
    by_dead = -(1 - x) / (1 - dead) * contrast / (x * (1 - x))
    return np.stack([np.ones_like(x), (1 - t) * by_dead, (1 - t) * contrast * odds, 1 - t], axis=1)
