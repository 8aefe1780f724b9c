"""Resin too thin for a file's facets and faces: what is left out of a film, in words."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.film import Groove
from mpfcad.units import um


def is_thin(groove: Groove, curvature: NDArray[np.float64], sliver: float) -> NDArray[np.bool_]:
    """Return which grooves hold resin that reaches less than `sliver` [mm] from their centre.

    curvature: [1/mm] through the tips, any shape.
    """
    thin: NDArray[np.bool_] = groove.takes_resin(curvature) & (
        groove.contact_position(curvature) < sliver
    )
    return thin


def thinnest_words(groove: Groove, sliver: float) -> str:
    """Return how thin, and of what C, the thinnest parabola through the tips is that is drawn."""
    most = 2 * groove.wall_slope / (groove.half_width + sliver)
    return f"thinner than {groove.vertex_height(most) / um:.2g} µm, C above {most:.4g} /mm"


def left_out_words(
    thin: NDArray[np.bool_], sliver: float, what: str, detail: str = "", files: str = ""
) -> str | None:
    """Return what the files leave out of the grooves or places that are `thin`; None: nothing."""
    number = int(np.count_nonzero(thin))
    if not number:
        return None
    width = f"resin narrower than {2 * sliver / um:.3g} µm"
    width += f" ({detail})" if detail else ""
    return (
        f"{files or 'solids and meshes'} leave out {width}, so that a trace has none: "
        f"{number} of {thin.size} {what} hold no more"
    )
