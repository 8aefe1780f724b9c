"""An input that is not known exactly, and several together with how they hang together."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mpfcad.boundary import reason_of
from mpfcad.errors import InputError
from mpfcad.sound import refuse_unsound


@dataclass(frozen=True)
class Factor:
    """An input with its standard uncertainty, both in the unit of its name.

    Attributes
    ----------
    name
        with its unit as suffix
    value, sigma
        as stated; standard uncertainty, above 0
    low, high
        what it can be
    source
        where the uncertainty comes from
    is_curved
        whether its effect needs a second order
    """

    name: str
    value: float
    sigma: float
    low: float = -np.inf
    high: float = np.inf
    source: str = "stated"
    is_curved: bool = False

    def __post_init__(self) -> None:
        refuse_unsound(f"{self.name}: sigma", self.sigma, 0.0, self.high - self.low, above=True)

    def within(self, steps: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return steps in units of sigma, cut off where the input can't be so small or large."""
        return np.clip(
            steps, (self.low - self.value) / self.sigma, (self.high - self.value) / self.sigma
        )


def correlation(
    factors: list[Factor], covariance: tuple[list[str], NDArray[np.float64]] | None
) -> NDArray[np.float64]:
    """Return the factors' correlations (k, k); named ones from a covariance, the others 0."""
    found = np.eye(len(factors))
    if covariance is None:
        return found
    names, matrix = covariance
    sigma = np.sqrt(np.diag(matrix))
    at = [next((i for i, f in enumerate(factors) if f.name == name), None) for name in names]
    for a, i in enumerate(at):
        for b, j in enumerate(at):
            if i is not None and j is not None and i != j:
                found[i, j] = matrix[a, b] / (sigma[a] * sigma[b])
    return found


def read_covariance(path: Path) -> tuple[list[str], NDArray[np.float64]]:
    """Return names and covariance of inputs from a CSV: a row of names, then the matrix.

    Raises
    ------
    InputError
        when it is no square table of numbers, not symmetric or not positive.
    """
    try:
        rows = [line.split(",") for line in path.read_text("utf-8-sig").split("\n") if line.strip()]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: {reason_of(error)}: expected names in row 1, and a matrix"
        ) from error
    names = [name.strip() for name in rows[0]] if rows else []
    if not names or any(len(row) != len(names) for row in rows) or len(rows) != len(names) + 1:
        raise InputError(
            f"{path}: {max(len(rows) - 1, 0)} rows of numbers: expected "
            f"{len(names) or 'some'} rows of {len(names) or 'as many'}, one for each name of the "
            "first row"
        )
    try:
        matrix = np.array([[float(cell) for cell in row] for row in rows[1:]])
    except ValueError as error:
        raise InputError(f"{path}: {error}: expected a row of names, then numbers") from None
    fault = covariance_fault(names, matrix)
    if fault:
        raise InputError(f"{path}: {fault}")
    return names, matrix


def covariance_fault(names: list[str], matrix: NDArray[np.float64]) -> str | None:
    """Return what is wrong with the covariance (n, n) of n named inputs; None: nothing."""
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        return f"{twice[0]}: named twice: expected each input once"
    if not np.isfinite(matrix).all():
        i, j = (int(at[0]) for at in np.nonzero(~np.isfinite(matrix)))
        return f"{names[i]}, {names[j]}: {matrix[i, j]}: expected a finite number"
    if not np.allclose(matrix, matrix.T, rtol=1e-6, atol=0):
        return "covariance is not symmetric: expected [i, j] equal to [j, i]"
    least = float(np.linalg.eigvalsh(matrix)[0])
    if (np.diag(matrix) <= 0).any() or least < -1e-9 * np.trace(matrix):
        return f"covariance has the eigenvalue {least:.3g}: expected a positive one"
    return None
