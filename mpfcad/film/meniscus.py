"""Resin at rest in a groove: its surface is a circular arc that meets both walls at one angle.

With the walls' inclination α, the contact angle θ and β = α - θ the arc leaves the walls at
±x_c with the slope tan β, so its radius is R = x_c / sin β: hollow for θ < α, flat for θ = α,
bulging above. The resin below it has the area

    A = x_c² (s - g(β)),   g(β) = (β - sin β cos β) / sin² β,   s = tan α,

so x_c follows from A in closed form. Where it would reach past the tips the surface is held by
them (x_c = w), and β follows from s - g(β) = A/w² (Concus and Finn, 1969; de Gennes, Brochard-Wyart
and Quéré, "Capillarity and wetting phenomena", 2004).
"""

import numpy as np
from numpy.typing import NDArray

from mpfcad.errors import InputError
from mpfcad.film.geometry import PrismFilm
from mpfcad.film.section import ARC, LINE, Section, join_pieces
from mpfcad.units import nm, um

#: Angles below this are flat [rad]: the arc's sagitta over a groove is far below a nanometre.
FLAT = 1e-7
#: Halvings of the range of an angle.
_HALVINGS = 60


def segment_share(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return g(β), the area between chord and arc over x_c²; odd and growing in β."""
    near = np.abs(angle) < 1e-4
    safe = np.where(near, 1.0, angle)
    exact = (safe - np.sin(safe) * np.cos(safe)) / np.sin(safe) ** 2
    return np.where(near, 2 * angle / 3, exact)


def meniscus(
    film: PrismFilm, contact_angle: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return x_c [mm] and β [rad] of each groove, (n,) float64, that hold the film's resin.

    `contact_angle` is in rad; the film's C stands for its fill.
    """
    groove = film.groove
    fill = film.fill_fraction
    free = np.arctan(groove.wall_slope) - contact_angle
    kept = groove.wall_slope - float(segment_share(np.asarray(free)))
    contact = np.sqrt(fill * groove.area / kept)
    held = contact >= groove.half_width
    low, high = np.zeros(len(fill)), np.full(len(fill), np.pi / 2)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        over = groove.wall_slope - segment_share(middle) < fill * groove.wall_slope
        low, high = np.where(over, low, middle), np.where(over, middle, high)
    contact = np.where(held, groove.half_width, contact)
    return contact, np.where(held, (low + high) / 2, free)


def meniscus_section(film: PrismFilm, contact_angle: float, sliver: float) -> Section:
    """Return the cross-section of a film whose resin has come to rest, sharp tips and valleys.

    Parts narrower than `sliver` [mm] are merged into their neighbours.

    Raises
    ------
    InputError
        when the resin stands above the tips.
    """
    groove, count, w = film.groove, film.groove_count, film.groove.half_width
    contact, angle = meniscus(film, contact_angle)
    contact = np.where(contact < sliver, 0.0, np.where(w - contact < sliver, w, contact))
    flat = np.abs(angle) < FLAT
    safe = np.where(flat, 1.0, np.sin(angle))
    radius = np.where(flat, 0.0, contact / safe)
    edge = film.base + np.minimum(groove.wall_slope * contact, groove.depth)
    top = edge + np.where(angle < 0, contact * np.tan(np.abs(angle) / 2), 0.0)
    if top.max() > film.thickness + nm:
        worst = int(np.argmax(top))
        raise InputError(
            f"film: groove {worst}: resin of this contact angle stands "
            f"{(top[worst] - film.thickness) / um:.3g} µm above the tips: expected less resin or a "
            f"smaller contact angle"
        )
    tip, middle = film.tip_position, film.groove_position
    left, right = middle - contact, middle + contact
    left, right = np.where(contact == w, tip[:-1], left), np.where(contact == w, tip[1:], right)
    x = np.stack([tip[:-1], left, right, tip[1:]], axis=1)
    high = np.full(count, film.thickness)
    z = np.stack([high, edge, edge, high], axis=1)
    kind = np.tile([LINE, ARC, LINE], (count, 1))
    kind[flat, 1] = LINE
    bend = np.zeros((count, 3))
    bend[:, 1] = radius
    centre = np.zeros((count, 3, 2))
    centre[:, 1, 0] = np.where(flat, 0.0, middle)
    centre[:, 1, 1] = np.where(flat, 0.0, edge + radius * np.cos(angle))
    return join_pieces(
        film.length,
        np.stack([x[:, :-1], x[:, 1:]], 2).reshape(-1, 2),
        kind.ravel(),
        centre.reshape(-1, 2),
        bend.ravel(),
        np.stack([z[:, :-1], z[:, 1:]], 2).reshape(-1, 2),
    )
