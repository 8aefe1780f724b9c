"""What of each groove's outline is drawn: refusals, and slivers too thin for a file merged away."""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film import PrismFilm
from mpfcad.units import nm, um

#: Resin or bare wall narrower than this is left out of solids and meshes alike.
SLIVER = 0.1 * um
#: A parabola that sags less than this is drawn as a plane in solids.
SOLID_FLAT = 1e-3 * nm


def check_drawable(film: PrismFilm) -> None:
    """Refuse a film of which no solid body can be made.

    Raises
    ------
    InputError
        when a dimension is not positive, a curvature is negative or not finite, or an `ideal`
        groove would cut through the underside.
    """
    sizes = {
        "pitch": film.groove.pitch,
        "depth": film.groove.depth,
        "base": film.base,
        "length": film.length,
    }
    for field, value in sizes.items():
        if not (np.isfinite(value) and value > 0):
            raise InputError(f"film: {field}: {value:g} mm: expected above 0 mm")
    if film.groove_count == 0:
        raise InputError("film: grooves: 0: expected at least 1")
    curvature = film.curvature
    bad = ~(np.isfinite(curvature) & (curvature >= 0))
    limit = np.inf
    if film.profile == "ideal":
        limit = 2 * film.thickness / film.groove.half_width**2
        bad |= curvature >= limit
    if bad.any():
        index = int(np.argmax(bad))
        raise InputError(
            f"film: curvature of groove {index}: {curvature[index]:g} /mm:"
            f" expected at least 0 and below {limit:g} /mm"
        )


def drawn_contact(film: PrismFilm, sliver: float) -> NDArray[np.float64]:
    """Return |x| [mm], (n,) float64, at which each groove's parabola is drawn to meet the wall.

    It is `Groove.contact_position`, but 0 (no parabola) when that is below `sliver` [mm], and the
    half width (no bare wall) when it is less than `sliver` away from the tip.
    """
    half_width = film.groove.half_width
    contact = film.groove.contact_position(film.curvature)
    contact = np.where(contact < sliver, 0.0, contact)
    return np.where(half_width - contact < sliver, half_width, contact)


def drawn_sliver(width: float) -> float:
    """Return what is not drawn [mm] of a film so wide: 0.1 µm, or four steps of float32.

    The same in STEP as in STL, so that both files hold the same bodies.
    """
    return max(SLIVER, 4 * float(np.spacing(np.float32(width))))


def solid_contact(film: PrismFilm) -> NDArray[np.float64]:
    """Return |x| [mm], (n,) float64, to which each groove's resin reaches as a solid; 0: none."""
    return drawn_contact(film, drawn_sliver(film.width))


def has_solid_parabola(film: PrismFilm) -> NDArray[np.bool_]:
    """Return which grooves have a parabola in the solids, (n,) bool: neither flat nor empty."""
    curved = film.curvature / 2 * film.groove.half_width**2 >= SOLID_FLAT
    return curved if film.profile == "ideal" else curved & (solid_contact(film) > 0)
