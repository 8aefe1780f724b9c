"""What a screen prints: release, ratios, ripple after levelling, and what a shifted print costs.

Ripple: what levelling leaves of each sampled groove's pattern is an error of its ratio; the fill
is off by the same share, and the curvature by dC/dfill of that. The picture sees |d ln L/dC| of it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import Process
from mpfcad.mask.aperture import Mask
from mpfcad.mask.fabric import Mesh
from mpfcad.mask.pattern.levelling import levelling_residual
from mpfcad.units import mm, um

#: Side of the squares that a map of both directions is looked at in.
SQUARE = 1.0 * mm
#: |d ln L/dC| [mm] that a ripple is judged by. Uniform films of C = 56, 60 and 64 /mm in the 16 mm
#: stack that ships, traced by this program: at most 0.0048 ± 0.0010 of 33 places over a lamp pitch;
#: three times that, because it grows below C = 56 /mm (docs/process.md).
LUMINANCE_RESPONSE = 0.015


@dataclass(frozen=True, eq=False)
class Printing:
    """What a screen prints of a mask.

    Attributes
    ----------
    mesh
        of the screen; None: phototool only
    aperture_limit, web_limit
        smallest that screen maker and mesh hold [mm]
    ratio_min, ratio_max
        of the grooves that are open
    release
        share of the mesh's volume that leaves it; None: not known
    release_deviation
        standard deviation of its logarithm; None: not known
    ripple
        worst groove's root mean square of the curvature's error [1/mm] after levelling
    ripple_groove
        that groove, counted from 0
    levelling_length
        of the resin [mm]
    registration
        by which a print may be shifted across [mm]
    registration_curvature
        largest change of a groove's curvature [1/mm] by that
    curvature_half_width
        largest half width of the curvature's 95 % interval [1/mm] by the process; None: not known
    printed_share
        (n,) float64, share of each groove's length that is printed; None: all of it
    """

    mesh: Mesh | None
    aperture_limit: float
    web_limit: float
    ratio_min: float
    ratio_max: float
    release: float | None
    release_deviation: float | None
    ripple: float
    ripple_groove: int
    levelling_length: float
    registration: float
    registration_curvature: float
    curvature_half_width: float | None
    printed_share: NDArray[np.float64] | None = None

    @property
    def ripple_luminance(self) -> float:
        """Relative luminance error that the ripple makes, by `LUMINANCE_RESPONSE`."""
        return self.ripple * LUMINANCE_RESPONSE

    def document(self) -> dict[str, Any]:
        """Return it in outside names, fit for JSON."""
        return {
            "screen": "phototool only" if self.mesh is None else self.mesh.name,
            "mesh_computed": "" if self.mesh is None else self.mesh.computed,
            "aperture_ratio": [self.ratio_min, self.ratio_max],
            "release": self.release,
            "levelling_length_mm": self.levelling_length,
            "ripple_curvature_per_mm": self.ripple,
            "ripple_groove": self.ripple_groove,
            "ripple_luminance": self.ripple_luminance,
            "luminance_response_mm": LUMINANCE_RESPONSE,
            "registration_um": self.registration / um,
            "registration_curvature_per_mm": self.registration_curvature,
            "curvature_half_width_per_mm": self.curvature_half_width,
        }


def find_printing(
    mask: Mask,
    process: Process,
    registration: float,
    release: tuple[float, float | None] | None,
) -> Printing:
    """Return what the screen of a mask prints.

    `registration` [mm] is how far the print may be shifted across; `release` the share of the
    mesh's volume that leaves, with the deviation of its logarithm.
    """
    # A map of both directions: by squares; a groove's mean says too little.
    wanted, _ = mask.wanted_places(SQUARE)
    curvature, step = mask.wanted_curvature(process, SQUARE)
    is_open = wanted > 1e-9
    residual = levelling_residual(mask)
    ripple = curvature_ripple(process, residual.groove_ratio, residual.groove_rms)
    worst = int(np.argmax(ripple))
    return Printing(
        mesh=mask.rules.mesh,
        aperture_limit=mask.rules.aperture_limit,
        web_limit=mask.rules.web_limit,
        ratio_min=mask.ratio_ends[0],
        ratio_max=mask.ratio_ends[1],
        release=None if release is None else release[0],
        release_deviation=None if release is None else release[1],
        ripple=float(ripple[worst]),
        ripple_groove=int(residual.groove[worst]),
        levelling_length=residual.levelling_length,
        registration=registration,
        registration_curvature=_shifted(curvature, registration / step),
        curvature_half_width=_half_width(process, wanted[is_open]),
        printed_share=mask.printed_share,
    )


def curvature_ripple(
    process: Process, ratio: NDArray[np.float64], rms: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the curvature's error [1/mm] of each groove: dC/dfill · fill · (rms / ratio)."""
    share = np.divide(rms, ratio, out=np.zeros_like(rms), where=ratio > 1e-9)
    fill = process.fill_fraction(ratio)
    low, high = fill * (1 - 1e-4), np.minimum(fill * (1 + 1e-4), 1.0)
    change = process.groove.curvature_of_fill(low) - process.groove.curvature_of_fill(high)
    slope = np.divide(change, high - low, out=np.zeros_like(fill), where=high > low)
    return slope * fill * share


def _shifted(curvature: NDArray[np.float64], steps: float) -> float:
    """Return the largest |C - C so many steps aside| [1/mm] across, of one row or of rows."""
    rows = np.atleast_2d(curvature)
    place = np.arange(rows.shape[1])
    return float(
        max(
            np.abs(np.interp(place + sign * steps, place, row) - row).max()
            for row in rows
            for sign in (-1, 1)
        )
    )


def _half_width(process: Process, ratio: NDArray[np.float64]) -> float | None:
    if not ratio.size:
        return None
    interval = process.curvature_interval(np.array([ratio.min(), ratio.mean(), ratio.max()]))
    return None if interval is None else float((interval[1] - interval[0]).max() / 2)
