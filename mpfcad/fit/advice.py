"""What to measure next: by how much each measurement would narrow what is left."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.confidence.advice import MEASUREMENTS, left_by
from mpfcad.fit.datum import Figured
from mpfcad.fit.posterior import Lines, Posterior, information_of, noise_of
from mpfcad.fit.unknown import Unknowns


def rank_next(
    posterior: Posterior,
    unknowns: Unknowns,
    lines: Lines,
    candidates: list[tuple[Figured, NDArray[np.float64]]],
    aims: list[Figured],
) -> list[dict[str, Any]]:
    """Return measurements, the one first that leaves least, in outside names.

    `candidates` are figures with the covariance that a meter would have; besides them stand what
    laboratories measure of single values. Each is rated by what it leaves of the standard
    uncertainty: of the `aims` (root mean square of their shares), or without any of all values.
    """
    found = [
        _rated(name, extra, posterior, lines, aims)
        for name, extra in [
            *_of_candidates(posterior, lines, candidates),
            *_of_laboratories(posterior, unknowns),
        ]
    ]
    return sorted(found, key=lambda row: (row["left"], row["measurement"]))


def _rated(
    name: str, extra: NDArray[np.float64], posterior: Posterior, lines: Lines, aims: list[Figured]
) -> dict[str, Any]:
    before = posterior.covariance
    after = np.linalg.inv(np.linalg.inv(before) + extra)
    if not aims:
        return {"measurement": name, "left": float(np.sqrt(np.trace(after) / np.trace(before)))}
    shares = []
    for aim in aims:
        slope = aim.jacobian(lines, posterior.steps)
        shares += (np.sum(slope @ after * slope, 1) / np.sum(slope @ before * slope, 1)).tolist()
    return {"measurement": name, "left": float(np.sqrt(np.mean(shares)))}


def _of_candidates(
    posterior: Posterior, lines: Lines, candidates: list[tuple[Figured, NDArray[np.float64]]]
) -> list[tuple[str, NDArray[np.float64]]]:
    found = []
    for figured, covariance in candidates:
        noise = noise_of(figured, lines, posterior.steps, posterior.covariance)
        extra = information_of(figured, covariance + noise, lines, posterior.steps)
        found.append((figured.name, extra))
    return found


def _of_laboratories(
    posterior: Posterior, unknowns: Unknowns
) -> list[tuple[str, NDArray[np.float64]]]:
    unit = unknowns.unit(posterior.steps)
    values = unknowns.values(posterior.steps)
    found = []
    for one in MEASUREMENTS:
        extra = np.zeros(len(unit))
        for i, factor in enumerate(unknowns.factors):
            left = left_by(one, factor.name, values[factor.name])
            if left is not None:
                extra[i] = (unit[i] / left) ** 2
        if extra.any():
            found.append((one.name, np.diag(extra)))
    return found
