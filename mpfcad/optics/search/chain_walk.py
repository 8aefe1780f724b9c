"""The walk of a ray along a chain: the run ahead, the segment of it that is met, or the way out.

The kernels take one ray or eight (`lanes`), but for `chain_hit`; numbers of runs and segments are
float64 in them.
"""

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import any_of, floor, magnitude, root, select, whole
from mpfcad.optics.base.lanes_array import gather_line, gather_row


@kernel
def zone_entry(chain, width, level, x, z, dx, dz):
    """Return where a ray from beyond the zone of the top comes to its `level`: (run, shift).

    Less `shift` [mm] the ray's x is in the coordinates in which the entry lies in [0, width].
    """
    flight = (level - z) / dz
    entry = x + select(flight > 0.0, flight, 0.0) * dx
    shift = floor(entry / width) * width
    entry = entry - shift
    entry = select(entry > 0.0, select(entry < width, entry, width), 0.0)
    cells = 1.0 * len(chain.cell)
    place = entry * (cells / width)
    place = select(place < cells - 1.0, place, cells - 1.0)
    first, last, between, _ = gather_row(chain.cell, whole(place))
    run = select(entry >= between, last, first)
    while any_of(last > first + 1.0):
        _, _, end, _, _, _, _, _ = gather_line(chain.run, whole(run))
        ahead = (entry >= end) & (run < last)
        if not any_of(ahead):
            break
        run = run + select(ahead, 1.0, 0.0)
    return run, shift


@kernel
def _guess(a, b, c, x, z, dx, dz, inside):
    """Return how far along a ray from x [mm] (from the run's left end), z meets the parabola."""
    slope = b + 2.0 * c * x
    p = c * dx * dx
    q = slope * dx - dz
    r = a + (b + c * x) * x - z
    square = q * q - 4.0 * p * r
    size = root(select(square > 0.0, square, 0.0))
    # From inside the first meeting, or the least height; from outside the last meeting.
    meets = inside & (square > 0.0)
    over = select(meets, 2.0 * r, select(inside, -q, size - q))
    return over / select(meets, size - q, 2.0 * p)


@kernel
def run_data(chain, run):
    """Return a run's row and range: (x0, z0, x1, z1, a, b, c, density, first, last, start)."""
    run = whole(run)
    x0, z0, x1, z1, a, b, c, density = gather_line(chain.run, run)
    first, last, start, _ = gather_row(chain.range, run)
    return x0, z0, x1, z1, a, b, c, density, first, last, start


@kernel
def meet_in_run(ends, segment, x, z, dx, dz, k, amid, inside, active, within):
    """Return where a ray meets a run: (met, segment, distance, x, z, slope, nz, against).

    `ends` is the run's `run_data`. The ray [mm] comes from before the run, or (`amid`, outside
    only) from its segment k, or, if `within` allows for that, from over or under the run.
    `against` is the direction's product with (-slope, 1).
    """
    right = dx > 0.0
    speed = magnitude(dx)
    side = select(inside, 1.0, -1.0)
    rise = select(right, dz, -dz) * side
    pace = speed * side
    ahead = select(right, 1.0, -1.0)
    x0, z0, x1, z1, a, b, c, density, first, last, start = ends
    end_x, end_z = select(right, x1, x0), select(right, z1, z0)
    begin = select(amid, k + ahead, select(right, first, last))
    low, high = select(right, begin, first), select(right, last, begin)
    over = (end_z - z) * pace - (end_x - x) * rise
    looking = active & (low <= high) & (inside | (over <= 0.0))
    met = looking ^ looking
    u = x - x0
    place = floor(start + density * (u + _guess(a, b, c, u, z, dx, dz, inside) * dx))
    s = select(place > low, select(place < high, place, high), low)
    s = select(looking, s, first)
    turning = select(right, speed, -speed)
    tries = 0
    while True:
        x0, z0, x1, z1, slope, nz, before, after = gather_line(segment, whole(s))
        near_x, far_x = select(right, x0, x1), select(right, x1, x0)
        near_z, far_z = select(right, z0, z1), select(right, z1, z0)
        near_gap = (near_z - z) * pace - (near_x - x) * rise
        far_gap = (far_z - z) * pace - (far_x - x) * rise
        # Past the ray, or (inside) past the run's least height over it.
        near_past = (near_gap <= 0.0) | (inside & (slope * turning >= dz))
        far_past = (far_gap <= 0.0) | (inside & (select(right, after, before) * turning >= dz))
        near_past = near_past & ((s > begin) | (s < begin))
        if within:
            # What lies behind the ray is not in its way.
            near_past = near_past & ((near_x - x) * ahead > 0.0)
            far_past = far_past & ((far_x - x) * ahead >= 0.0)
        found = looking & far_past & (near_past ^ True)
        met = met | (found & (far_gap <= 0.0))
        looking = looking & (found ^ True)
        against = dz - slope * dx
        distance = ((z0 - z) - slope * (x0 - x)) / against
        if not any_of(looking):
            break
        up = near_past ^ right
        low = select(looking & up, s + 1.0, low)
        high = select(looking & (up ^ True), s - 1.0, high)
        looking = looking & (low <= high)
        if not any_of(looking):
            break
        tries += 1
        if tries < 3:
            place = floor(start + density * (u + distance * dx))
        else:
            place = floor(0.5 * (low + high))
        place = select(place > low, select(place < high, place, high), low)
        s = select(looking, place, s)
    distance = select(met & (distance > 0.0), distance, 0.0)
    hit = x + distance * dx
    hit = select(hit > x0, select(hit < x1, hit, x1), x0)
    x = select(met, hit, x)
    z = select(met, z0 + slope * (hit - x0), z)
    k = select(met, s, k)
    return met, k, distance, x, z, slope, nz, against


@kernel
def leave_run(ends, level, x, z, dx, dz, k, on, inside):
    """Return what a ray that is `on` segment k of a run, or past the run, does next: (gone, amid).

    `gone`: it leaves the zone of the top at `level` [mm] without another meeting; `amid`: it may
    meet the same run again, else it comes to the next one.
    """
    right = dx > 0.0
    speed = magnitude(dx)
    rise = select(right, dz, -dz)
    x0, z0, x1, z1, _, _, _, _, first, last, _ = ends
    end_x, end_z = select(right, x1, x0), select(right, z1, z0)
    more = on & select(right, k < last, k > first) & (inside ^ True)
    way = (end_x - x) * rise
    # Surface over ray is convex and 0 at the start: from inside, the run's rest is not met again.
    amid = more & ((end_z - z) * speed - way >= 0.0) & (speed > 0.0)
    side = select(inside, 1.0, -1.0)
    out = (dz * side < 0.0) & ((way - (level - z) * speed) * side < 0.0)
    gone = (amid ^ True) & (out | ((speed > 0.0) ^ True))
    return gone, amid


@kernel
def next_run(chain, width, run, x, dx):
    """Return the run ahead: (run, x, shift), x [mm] in the coordinates of its tile."""
    right = dx > 0.0
    count = 1.0 * len(chain.run)
    run = run + select(right, 1.0, -1.0)
    beyond, under = run >= count, run < 0.0
    run = select(beyond, 0.0, select(under, count - 1.0, run))
    turn = select(beyond, width, select(under, -width, 0.0))
    return run, x - turn, turn


@kernel
def chain_hit(chain, width, low, high, x, z, dx, dz, k, inside):
    """Return the next segment that a ray meets: (segment or -1, distance, x, z, shift, normal).

    The ray starts at (x, z) [mm], inside or outside the film, with x in [0, width]; `k` is the
    segment it starts on, or -1 when it starts below the lowest (inside) or above the highest point
    (outside); low, high: lowest and highest z of the top. `shift` [mm] is what to add to x to be in
    the same coordinates as before; segment -1: it leaves the zone of the top without a hit, -2: it
    was lost.
    """
    level = low if inside else high
    amid = False
    shift = 0.0
    at = float(k)
    run = 0.0
    if k < 0:
        run, shift = zone_entry(chain, width, level, x, z, dx, dz)
        x -= shift
    else:
        run = float(chain.run_of[k])
        gone, amid = leave_run(run_data(chain, run), level, x, z, dx, dz, at, True, inside)
        if gone:
            return -1, 0.0, x, z, shift, 0.0, 1.0
        if not amid:
            run, x, turn = next_run(chain, width, run, x, dx)
            shift += turn
    for _ in range(64 * len(chain.run) + 64):
        ends = run_data(chain, run)
        met, at, distance, x, z, slope, nz, _ = meet_in_run(
            ends, chain.segment, x, z, dx, dz, at, amid, inside, True, False
        )
        if met:
            return int(at), distance, x, z, shift, -slope * nz, nz
        gone, _ = leave_run(ends, level, x, z, dx, dz, at, False, inside)
        if gone:
            return -1, 0.0, x, z, shift, 0.0, 1.0
        amid = False
        run, x, turn = next_run(chain, width, run, x, dx)
        shift += turn
    return -2, 0.0, x, z, shift, 0.0, 1.0
