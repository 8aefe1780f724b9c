"""Writes Zemax tabular `.bsdf` files; what they hold is said in `zemax`."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.optics.bsdf.basis import AngleBasis
from mpfcad.optics.bsdf.format.lobe import leaving_direction
from mpfcad.optics.bsdf.format.zemax import ANGLES
from mpfcad.optics.bsdf.rebin import bin_shares, bsdf_at
from mpfcad.optics.bsdf.table import REFLECT, SIDES, TRANSMIT, BsdfTable

#: How far below the horizon (direction cosine) values are still written: more than a step.
_MARGIN = 0.2


def zemax_texts(table: BsdfTable, stem: str) -> dict[str, str]:
    """Return the files of a table, one for each way and side that is not dark."""
    texts = {}
    for way, kind in ((TRANSMIT, "btdf"), (REFLECT, "brdf")):
        for side, name in enumerate(SIDES):
            if table.value[way, side].any():
                texts[f"{stem}-{kind}-{name}.bsdf"] = _zemax_text(table, way, side, kind)
    return texts


def _zemax_text(table: BsdfTable, way: int, side: int, kind: str) -> str:
    if table.isotropic:
        rotation, incidence = np.zeros(1), np.arange(0, 86, 5.0)
        azimuth, radial = np.arange(0, 360, 5.0), np.arange(0, 176, 2.5)
    else:
        rotation, incidence = np.arange(0, 360, 15.0), np.array([*range(0, 81, 10), 85.0])
        azimuth, radial = np.arange(0, 360, 10.0), np.arange(0, 176, 5.0)
    a, r = np.meshgrid(np.radians(azimuth), np.radians(radial), indexing="ij")
    lines = [
        f"# side: {SIDES[side]}",
        *([] if table.isotropic else ["# rotation: +y counterclockwise"]),
        "Source  Measured",
        f"Symmetry  {'ASymmetrical' if table.isotropic else 'ASymmetrical4D'}",
        "SpectralContent  Monochrome",
        f"ScatterType  {kind.upper()}",
    ]
    for name, angles in zip(ANGLES, (rotation, incidence, azimuth, radial), strict=True):
        lines += [f"{name}  {len(angles)}", "\t".join(f"{v:g}" for v in angles)]
    lines += ["", "Monochrome", "DataBegin"]
    # As the vendor counts them: the light travels along +y at rotation 0.
    for turn in np.radians(rotation + 90):
        for theta in np.radians(incidence):
            incident = np.sin(theta) * np.array([np.cos(turn), np.sin(turn)])
            direction = leaving_direction(theta, a, r)
            leaving = _turned(direction[:2], turn).reshape(2, -1).T
            # Grid points just below the horizon carry the horizon's value, so that what is read
            # between them and those above is not too dark.
            size = np.linalg.norm(leaving, axis=1, keepdims=True)
            under = direction[2].reshape(-1, 1) <= 0
            leaving = np.where(under, leaving / np.maximum(size, 1e-12), leaving)
            value = bsdf_at(table, way, side, incident, leaving).reshape(a.shape)
            value = np.where(direction[2] > -_MARGIN, value, 0.0)
            lines.append(f"TIS {_energy_at(table, way, side, incident):.9g}")
            lines += ["\t".join(f"{v:.6e}" for v in row) for row in value]
    return "\n".join([*lines, "DataEnd", ""])


def _turned(k: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([k[0] * c - k[1] * s, k[0] * s + k[1] * c])


def _energy_at(table: BsdfTable, way: int, side: int, incident: NDArray[np.float64]) -> float:
    """Return the share that leaves, linear between the incidence bins."""
    basis = table.basis
    if table.isotropic:
        basis = AngleBasis("", basis.edge, np.ones_like(basis.azimuths))
    bins, shares = bin_shares(basis, *incident)
    return float(shares[0] @ table.energy[way, side, bins[0]])
