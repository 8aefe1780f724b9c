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


def _thinnest_words(groove: Groove, sliver: float) -> str:
    """Return how thin, and of what C, the thinnest parabola through the tips is that is drawn."""
    most = 2 * groove.wall_slope / (groove.half_width + sliver)
    return f"thinner than {groove.vertex_height(most) / um:.2g} µm, C above {most:.4g} /mm"


def left_out_words(
    thin: NDArray[np.bool_],
    sliver: float,
    what: str,
    groove: Groove | None = None,
    files: str = "solids and meshes",
) -> str | None:
    """Return what files leave out of the grooves or places that are `thin`; None: nothing.

    `groove`: whose parabolas through the tips they are, if they are.
    """
    number = int(np.count_nonzero(thin))
    if not number:
        return None
    width = f"resin narrower than {2 * sliver / um:.3g} µm"
    width += f" ({_thinnest_words(groove, sliver)})" if groove else ""
    return (
        f"{files} leave out {width}, so that a trace has none: "
        f"{number} of {thin.size} {what} hold no more"
    )
