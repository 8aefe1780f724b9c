"""Whether sheets spread the light so far that the luminance over the lamps has no kinks."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mpfcad.measure.contrast.basis import SPECTRA
from mpfcad.optics.repeat import has_alike_films

if TYPE_CHECKING:
    from mpfcad.optics.element import Element, Sheet

#: Standard deviation [pitch] of the Gaussian blur that leaves no more of any wave than the widest
#: spectrum without kinks has: exp(-(2πfs)²) = exp(-(f/cutoff)²/2).
_LEAST = 1 / (2 * np.sqrt(2) * np.pi * max(s.cutoff for s in SPECTRA if not s.is_rough))


def is_blurred(elements: "Sequence[Element]", pitch: float) -> bool:
    """Return whether a sheet spreads the light of tubes over enough of a lamp pitch [mm].

    A sheet moves the direction cosines by a Gaussian of deviation σ. Light goes on for at least the
    gap between the lamps' tops and the layers, so it is spread by σ · gap or more. A film that
    varies along x has steps and kinks of its own, which a sheet on it does not blur.
    """
    from mpfcad.optics.element import Cavity, Sheet

    lamps = elements[0]
    if not isinstance(lamps, Cavity):
        return False
    if not has_alike_films(elements):
        return False
    gap = lamps.height - lamps.lamp_height - lamps.lamp_radius
    spread = max((_spread(e) for e in elements if isinstance(e, Sheet)), default=0.0)
    return bool(spread * gap >= _LEAST * pitch)


def _spread(sheet: "Sheet") -> float:
    """Return the least deviation of a sheet's move in any direction and lobe."""
    lobes = [sheet.sigma] if sheet.sigma_across is None else [sheet.sigma, sheet.sigma_across]
    return min([*lobes, sheet.wide_sigma] if sheet.wide_share > 0 else lobes)
