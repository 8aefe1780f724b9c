"""What scores come to: light and its derivatives a point, less the control, with their errors."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: The entries of a block's sums: light, its derivative, two controls (`Score.control`).
_LIGHT, _SLOPE, _CONTROL = 0, 1, 2
_ENTRIES = 4
#: Degrees of freedom of all points' mean in a point's own variance, as in `Tally`.
_SHARED = 30


class SlopeTally(NamedTuple):
    """Sums over blocks of light, derivatives and controls, and of their products.

    Attributes
    ----------
    total
        (p, v, 4) float64, of p points by v values
    product
        (p, v, 4, 4) float64, sums of the products of the blocks' sums
    paths, blocks
        paths a point; in how many blocks of equal size
    """

    total: NDArray[np.float64]
    product: NDArray[np.float64]
    paths: int
    blocks: int

    @classmethod
    def empty(cls, points: int, values: int) -> "SlopeTally":
        """Return a tally of no paths."""
        total = np.zeros((points, values, _ENTRIES))
        return cls(total, np.zeros((points, values, _ENTRIES, _ENTRIES)), 0, 0)

    @classmethod
    def of_block(
        cls,
        light: NDArray[np.float64],
        slope: NDArray[np.float64],
        control: NDArray[np.float64],
        paths: int,
    ) -> "SlopeTally":
        """Return the tally of one block: sums of light (p,), slope (p, v), control (2, p, v)."""
        total = np.stack([np.broadcast_to(light[:, None], slope.shape), slope, *control], axis=-1)
        return cls(total, total[..., :, None] * total[..., None, :], paths, 1)

    def __add__(self, other: "SlopeTally") -> "SlopeTally":  # type: ignore[override]  # sums
        """Return the tally of both."""
        pairs: Any = zip(self, other, strict=True)
        return SlopeTally._make(a + b for a, b in pairs)

    @property
    def light(self) -> NDArray[np.float64]:
        """Mean radiance a point, (p,) float64 [cd/m²]."""
        return self.total[:, 0, _LIGHT] / self.paths

    @property
    def slope(self) -> NDArray[np.float64]:
        """Derivative of `light` by each value, (v, p) float64."""
        part = np.einsum("pvi,vi->vp", self.total, self._row(_SLOPE))
        return part / self.paths

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of `light` and `slope` at a point, (v, p, 2, 2) float64; two blocks at least.

        From the spread of the blocks, a point's own averaged with that of all (`Tally`).
        """
        row = np.stack([self._row(_LIGHT), self._row(_SLOPE)])
        own = np.einsum("avi,pvij,bvj->vpab", row, self._scatter(), row)
        freedom = self.blocks - 1
        shared = (freedom * own + _SHARED * own.mean(axis=1, keepdims=True)) / (freedom + _SHARED)
        return self.blocks * shared / self.paths**2

    def _scatter(self) -> NDArray[np.float64]:
        """Return the covariance of the blocks' sums, (p, v, 4, 4)."""
        outer = self.total[..., :, None] * self.total[..., None, :]
        return (self.product - outer / self.blocks) / (self.blocks - 1)

    def _row(self, entry: int) -> NDArray[np.float64]:
        """Return what of each entry makes up light or slope, (v, 4).

        A slope less that of each control that leaves the least noise, by all points' scatter: its
        own mean is 0.
        """
        row = np.zeros((self.total.shape[1], _ENTRIES))
        row[:, entry] = 1.0
        if entry == _SLOPE and self.blocks > 1:
            scatter = self._scatter().sum(axis=0)
            inside = np.linalg.pinv(scatter[:, _CONTROL:, _CONTROL:], hermitian=True)
            row[:, _CONTROL:] = -np.einsum("vij,vj->vi", inside, scatter[:, _CONTROL:, _SLOPE])
        return row
