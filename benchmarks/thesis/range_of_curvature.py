"""Contrast and luminance against the film's curvature, read off the response surfaces."""

import numpy as np
from numpy.typing import NDArray

from thesis.response import Surface, contrast

#: The published limit of the good range: the conventional stack's contrast.
LIMIT = 0.012
CURVATURE = np.arange(50.0, 81.5, 1.0)
_FINE = np.linspace(50, 81, 125)
_DRAWS = 100


def by_curvature(surface: Surface, code: NDArray[np.float64]) -> dict[str, list]:
    """Return contrast and relative luminance over `CURVATURE` with 95 % intervals, and the range.

    The range is where contrast is at most `LIMIT` within the traced 50 … 81 /mm; None where there
    is no such curvature. Intervals are the middle 95 % of surfaces drawn with their uncertainty.
    """
    drawn = surface.draws(_DRAWS, 3)

    def band(of) -> dict[str, list]:
        values = np.array([[of(s(code, c)) for c in CURVATURE] for s in [surface, *drawn]])
        low, high = np.percentile(values[1:], [2.5, 97.5], axis=0)
        return {"value": values[0].tolist(), "low": low.tolist(), "high": high.tolist()}

    places = np.array([_places(s, code) for s in [surface, *drawn]])
    low, high = np.nanpercentile(places[1:], [2.5, 97.5], axis=0)
    names = ("range_low_per_mm", "range_high_per_mm", "best_per_mm")
    return {
        "curvature_per_mm": CURVATURE.tolist(),
        "contrast": band(lambda reading: contrast(reading[1:])),
        "luminance": band(lambda reading: float(np.exp(reading[0]))),
        **{
            name: [float(v) for v in (places[0, i], low[i], high[i])]
            for i, name in enumerate(names)
        },
    }


def _places(surface: Surface, code: NDArray) -> list[float]:
    """Return (lower edge, upper edge, minimum) of the contrast [1/mm]; the ends where none is."""
    values = np.array([contrast(surface(code, c)[1:]) for c in _FINE])
    good = _FINE[values <= LIMIT]
    edges = (good[0], good[-1]) if len(good) else (np.nan, np.nan)
    return [*edges, _FINE[values.argmin()]]
