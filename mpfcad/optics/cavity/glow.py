"""What a Lambertian reflector sends back to a path that ends on it: a table over the lamp pitch.

A path that the reflector scatters, not mirrors, forgets where it came from: what it finds after
depends on its place on the reflector alone. So it can end there with the mean of what other paths
found that started there (a radiosity: Goral, Torrance, Greenberg and Battaile, "Modeling the
interaction of light between diffuse surfaces", 1984). What lamps send there directly is no part of
the table; it stands in closed form (`direct`).

The table has errors that all paths share. They follow from the weights that ended at each place.
"""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import floor, select, whole
from mpfcad.optics.base.lanes_array import gather
from mpfcad.optics.cavity.endless import LAMP_PITCH, LAMP_POSITION


@kernel
def glow_at(glow, pitch, position, x):
    """Return the table's value at x, on a straight line between its places; of one or many.

    glow: (n+1,) float64 [cd/m²], from a lamp's axis over a pitch, the first value again as last.
    """
    u = (x - position) / pitch
    u = u - floor(u)
    # Lanes without a ray may be anywhere.
    u = select((u >= 0.0) & (u < 1.0), u, 0.0) * (len(glow) - 1)
    below = floor(u)
    i = whole(below)
    low, high = gather(glow, i), gather(glow, i + 1)
    return low + (u - below) * (high - low)


@kernel
def land(glow, cavity, x, weight, path, landed):
    """Count a weight that ended at x by its point and the table's nearest place.

    landed: (p*n,) float64, of p points, which `path` goes round.
    """
    if weight > 0.0:
        n = len(glow) - 1
        u = (x - cavity[LAMP_POSITION]) / cavity[LAMP_PITCH]
        place = int(floor((u - floor(u)) * n + 0.5)) % n
        landed[(path % (len(landed) // n)) * n + place] += weight
