"""A cell's luminance as a Fourier series in x and y, and the figures read off it with intervals."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.measure.contrast.draws import contrast_of_draws
from mpfcad.measure.contrast.shrink import plausible
from mpfcad.measure.estimate import TAIL, Estimate, wobble

_DRAWS = 2000
#: Places along each axis where a curve is read.
_FINE = 32
#: What is left beyond the series may be as improbable as 3σ of noise.
_SIGMA = 3.0
LEAST = 3
#: Blocks a term from which on a covariance is taken as it is.
_BLOCKS_A_TERM = 2


@dataclass(frozen=True, eq=False)
class CellSeries:
    """L(u, v) = Σ c_ij φ_i(u) φ_j(v), φ = 1, cos 2πu, sin 2πu, cos 4πu …; u, v in periods.

    Attributes
    ----------
    order
        (n, 2) int64, the numbers i, j of each term; the first is the mean
    coefficient, covariance
        (n,), (n, n) float64 [cd/m², cd²/m⁴]
    freedom
        degrees of freedom of the covariance
    left
        (χ² - n)/√(2n) of the terms that are left out
    """

    order: NDArray[np.int64]
    coefficient: NDArray[np.float64]
    covariance: NDArray[np.float64]
    freedom: float
    left: float

    def at(self, u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the terms at places in periods from the cell's middle, (k, n) float64."""
        across, along = (_terms(place, int(self.order.max())) for place in (u, v))
        return across[:, self.order[:, 0]] * along[:, self.order[:, 1]]

    def bin_means(self, bins: int) -> NDArray[np.float64]:
        """Return the means over so many equal bins along each axis, (b, b) float64 [cd/m²]."""
        middle = (np.arange(bins) + 0.5) / bins - 0.5
        terms = _terms(middle, int(self.order.max()))
        # A wave's mean over a bin is its middle's times sin(πh/b)/(πh/b).
        terms = terms * np.sinc((np.arange(terms.shape[1]) + 1) // 2 / bins)
        whole = np.zeros(2 * (terms.shape[1],))
        whole[self.order[:, 0], self.order[:, 1]] = self.coefficient
        return np.asarray(terms @ whole @ terms.T)

    @property
    def harmonics(self) -> int:
        """Highest harmonic along an axis."""
        return int(self.order.max() + 1) // 2

    @property
    def mean(self) -> Estimate:
        """Mean luminance [cd/m²]."""
        return self._sum(np.eye(len(self.coefficient))[0])

    def luminance(self, u: float, v: float) -> Estimate:
        """Return the luminance [cd/m²] at a place in periods."""
        return self._sum(self.at(np.array([u]), np.array([v]))[0])

    def _sum(self, weight: NDArray[np.float64]) -> Estimate:
        error = float(np.sqrt(weight @ self.covariance @ weight))
        return Estimate.student(float(weight @ self.coefficient), error, self.freedom)

    def amplitude(self, across: int, along: int) -> Estimate:
        """Return the amplitude of a harmonic pair over the mean, noise's power taken off."""
        chosen = np.all(self._harmonic() == np.array([across, along]), axis=1)
        return self._power(np.asarray(chosen), 1.0)

    def relative_spread(self) -> Estimate:
        """Return σ/mean over the cell (Parseval: Σ c² times the mean of each term's square)."""
        return self._power(np.asarray(self._harmonic().any(axis=1)), None)

    def _harmonic(self) -> NDArray[np.int64]:
        """Return the harmonics along x and y of each term, (n, 2)."""
        return (self.order + 1) // 2

    def _power(self, chosen: NDArray[Any], scale: float | None) -> Estimate:
        """Return √(Σ s·c² - Σ s·V)/mean, s = `scale`, or the mean of the term's square."""
        square = 0.5 ** (self._harmonic() > 0).sum(axis=1) if scale is None else scale
        weight = np.sqrt(np.broadcast_to(square, chosen.shape)[chosen])
        part = weight * self.coefficient[chosen]
        covariance = self.covariance[np.ix_(chosen, chosen)] * np.outer(weight, weight)
        noise = float(np.trace(covariance))
        power = float(part @ part)
        value = np.sqrt(max(power - noise, 0.0))
        # The power's variance about its expectation: 4 cᵀVc + 2 tr V².
        true = part * np.sqrt(max(power - noise, 0.0) / power) if power > 0 else part
        spread = np.sqrt(4 * true @ covariance @ true + 2 * np.sum(covariance**2))
        low, high = (
            np.sqrt(max(power - noise + sign * 1.96 * spread, 0.0)) for sign in (-1.0, 1.0)
        )
        mean = self.coefficient[0]
        return Estimate.within(float(value / mean), float(low / mean), float(high / mean))

    def contrast(
        self, seed: int, u: NDArray[np.float64] | None = None, v: NDArray[np.float64] | None = None
    ) -> Estimate:
        """Return (Lmax - Lmin)/(Lmax + Lmin), median-unbiased, with its 95 % interval.

        Over the whole cell, or at the places (u, v) alone, of series that the coefficients may
        stand for (`contrast.draws`): each harmonic is shrunk by its noise. Draws are fixed by
        `seed`.
        """
        if u is None or v is None:
            fine = np.arange(_FINE) / _FINE
            u, v = (part.ravel() for part in np.meshgrid(fine, fine, indexing="ij"))
        at = self.at(u, v)
        rng = np.random.Generator(np.random.Philox(seed))
        root = np.linalg.cholesky(self.covariance)
        noise, other = (
            rng.standard_normal((_DRAWS, len(self.coefficient))) @ root.T for _ in range(2)
        )
        wider = wobble(rng, _DRAWS, self.freedom)
        drawn, kept = self.coefficient + other, np.ones(len(self.coefficient))
        for group in self._groups():
            seen = self.coefficient[group]
            block = self.covariance[np.ix_(group, group)]
            power = float(seen @ np.linalg.solve(block, seen))
            drawn[:, group], kept[group] = plausible(seen, power, other[:, group], rng)
        middle = kept * self.coefficient
        off, noise = (wider * part @ at.T for part in (drawn - middle, kept * noise))
        return contrast_of_draws(
            (at @ middle)[None], off[:, None], noise[:, None], (at @ (kept * middle))[None],
            may_be_flat=self._may_be_flat(),
        )  # fmt: skip

    def _may_be_flat(self) -> bool:
        """Return whether all terms but the mean may be noise (2.5 % of Fisher's F)."""
        from scipy.special import fdtrc

        rest, covariance = self.coefficient[1:], self.covariance[1:, 1:]
        share = float(rest @ np.linalg.solve(covariance, rest)) / len(rest)
        return bool(fdtrc(len(rest), self.freedom, share) > TAIL)

    def _groups(self) -> list[NDArray[np.int64]]:
        """Return the numbers of the terms of each harmonic pair but the mean's."""
        pairs = self._harmonic()
        names = sorted({(int(a), int(b)) for a, b in pairs} - {(0, 0)})
        return [np.flatnonzero((pairs == name).all(axis=1)) for name in names]


def fit_series(
    coefficient: NDArray[np.float64],
    covariance: NDArray[np.float64],
    blocks: int,
    terms: int,
    is_mirrored: bool,
) -> CellSeries:
    """Return the shortest series beyond which there is nothing but noise.

    Parameters
    ----------
    coefficient, covariance
        (terms²,), (terms², terms²) float64, of all terms i·terms + j
    blocks
        that the covariance comes from
    is_mirrored
        whether the cell is the same mirrored at x = 0 and y = 0: the sines are left out
    """
    order = np.stack(np.divmod(np.arange(terms * terms), terms), axis=1)
    harmonic = (order + 1) // 2
    even = (order % 2 == 1) | (order == 0)
    used = even.all(axis=1) if is_mirrored else np.ones(len(order), bool)
    most = int(harmonic.max())
    for least in range(LEAST, most + 1):
        kept = used & (harmonic <= least).all(axis=1)
        rest = np.flatnonzero(used & ~kept)
        left = 0.0
        if len(rest):
            chi2 = float(np.sum(coefficient[rest] ** 2 / np.diag(covariance)[rest]))
            left = (chi2 - len(rest)) / np.sqrt(2 * len(rest))
        if left <= _SIGMA:
            break
    chosen = np.flatnonzero(kept)
    noise = covariance[np.ix_(chosen, chosen)]
    if blocks < _BLOCKS_A_TERM * len(chosen):
        # So few blocks leave the covariance of so many terms singular, or nearly.
        noise = (noise + np.diag(np.diag(noise))) / 2
    return CellSeries(order[chosen], coefficient[chosen], noise, float(blocks - 1), float(left))


def _terms(place: NDArray[np.float64], last: int) -> NDArray[np.float64]:
    """Return 1, cos 2πu, sin 2πu, … up to number `last`, (k, last+1) float64."""
    columns = [np.ones_like(place)]
    for h in range(1, last // 2 + 2):
        columns += [np.cos(2 * np.pi * h * place), np.sin(2 * np.pi * h * place)]
    return np.stack(columns, axis=1)[:, : last + 1]
