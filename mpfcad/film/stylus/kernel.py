"""What a stylus traces of filled grooves, and menisci of a fill: compiled, height by height.

`dilated` and `meniscus` say what is computed; every argument is mm or a slope. A tip is its ball's
radius and its cone's flank slope, infinite where there is no cone.
"""

import math

from numba import njit

from mpfcad.store.kernel import kept

#: Steps to where a tip touches, to where a meniscus has a slope, and to a slope of an area.
_TOUCH, _REACH, _SLOPE = 30, 8, 6
#: A touching point is known [mm] when a step is shorter; a slope, when it is.
_NEAR, _NEAR_SLOPE = 1e-8, 1e-12
#: The least slope and share, and the least rate of a step.
_LEAST, _LEAST_RATE = 1e-9, 1e-3


@njit(error_model="numpy")
def _segment_share(slope):
    """Return the area between chord and arc over a²: `film.meniscus.segment_share` of its angle."""
    if slope < 1e-4:
        return 2 * slope / 3
    angle, size = math.atan(slope), 1 + slope * slope
    return (angle - slope / size) * size / (slope * slope)


@njit(error_model="numpy")
def _share(slope, roundness, flatness):
    """Return the area between chord and meniscus over a²."""
    straight = ((1 - roundness - flatness) * 2 / 3 + flatness * 0.4) * slope
    return straight + (roundness * _segment_share(slope) if roundness != 0 else 0.0)


@njit(error_model="numpy")
def _slope_of(share, steep, roundness, flatness):
    """Return the slope at the contact of an area between chord and meniscus over a²."""
    share = max(share, _LEAST)
    straight = (1 - roundness - flatness) * 2 / 3 + flatness * 0.4
    if roundness == 0:
        return min(share / straight, steep)
    # g₁ ≈ 2p/3 (1 - p²/5)
    slope = share / (straight + roundness * 2 / 3)
    slope = min(slope * (1 + 0.2 * roundness * slope * slope), 2 * steep)
    for _ in range(_SLOPE):
        found = _segment_share(slope)
        # dg₁/dβ = 2 - 2 g₁ cot β, dβ/dp = cos² β
        rate = straight + roundness * 2 * (1 - found / slope) / (1 + slope * slope)
        step = (straight * slope + roundness * found - share) / max(rate, _LEAST_RATE)
        slope = min(max(slope - step, _LEAST), 2 * steep)
        if abs(step) < _NEAR_SLOPE:
            break
    return min(slope, steep)


@kept
@njit(error_model="numpy")
def hold(fill, through_tips, above, roundness, flatness, steep, part, slope):
    """Fill `part` (n,), contact over half width, and `slope` (n,) there, of menisci of `fill`.

    through_tips: part of the parabola through the tips. above: by how much their wetting is above
    that one's. steep: of the walls.
    """
    kept_share = 1 - _share(steep, roundness, flatness) / steep
    for i in range(len(fill)):
        level = math.sqrt(fill[i])
        own = min(math.sqrt(3 * fill[i]), 1.0)
        wetting = (through_tips[i] - level) / (own - level) + above
        wetting = min(max(wetting, 0.0), 1.0)
        along = min(math.sqrt(fill[i] / kept_share), 1.0)
        part[i] = level + wetting * (along - level)
        share = steep * (1 - fill[i] / (part[i] * part[i]))
        slope[i] = _slope_of(share, steep, roundness, flatness)


@kept
@njit(error_model="numpy")
def place(x, centre, pitch, local, number):
    """Fill `local` (n,) with x from the nearest groove's centre, `number` (n,) with which it is."""
    for i in range(len(x)):
        turn = (x[i] - centre) / pitch + 0.5
        whole = math.floor(turn)
        local[i] = (turn - whole - 0.5) * pitch
        number[i] = whole


@njit(error_model="numpy")
def _height(x, contact, level, slope, roundness, flatness):
    """Return a meniscus's height at x up to its contact."""
    part = x / contact
    part *= part
    below = (1 - roundness - flatness) / 2 + flatness / 4 * (1 + part)
    if roundness != 0:
        square = 1 + slope * slope
        # b²a² = p²/(1 + p²): the root at the contact is 1/√(1 + p²).
        inner = math.sqrt(1 - slope * slope / square * part)
        size = math.sqrt(square)
        below += roundness / (inner * size + 1)
    return level - below * slope * contact * (1 - part)


@njit(error_model="numpy")
def _steepness(x, contact, slope, roundness, flatness):
    """Return a meniscus's slope and second derivative at x up to its contact."""
    part = x / contact
    part *= part
    rate = slope / contact
    first = 1 - roundness - flatness + flatness * part
    second = 1 - roundness - flatness + 3 * flatness * part
    if roundness != 0:
        square = 1 + slope * slope
        up = 1 / (1 - slope * slope / square * part)
        bend = roundness * math.sqrt(up / square)
        first += bend
        second += bend * up
    return first * rate * x, second * rate


@njit(error_model="numpy")
def _reach(contact, slope, roundness, flatness, flank):
    """Return up to which x a meniscus is no steeper than a cone's flank."""
    if slope <= flank:
        return contact
    x = contact
    for _ in range(_REACH):
        first, second = _steepness(x, contact, slope, roundness, flatness)
        x = min(max(x - (first - flank) / max(second, 1e-12), 0.0), contact)
    return x


@njit(error_model="numpy")
def _tip_height(aside, radius, flank):
    """Return the tip's surface above its lowest point, at a distance from its axis."""
    ball = radius * flank / math.sqrt(1 + flank * flank) if flank < math.inf else radius
    curved = min(aside, ball)
    height = radius - math.sqrt(max(radius * radius - curved * curved, 0.0))
    return height + flank * (aside - ball) if aside > ball else height


@njit(error_model="numpy")
def _is_hollow(x, contact, slope, roundness, flatness, radius):
    """Return whether a meniscus is more hollow than a ball at x."""
    first, second = _steepness(x, contact, slope, roundness, flatness)
    return radius * second > (1 + first * first) ** 1.5


@njit(error_model="numpy")
def _touch(x, contact, slope, roundness, flatness, radius, reach, hollow):
    """Return where on a meniscus a ball over x touches, x + R sin(its angle), up to `reach`.

    Newton's method within a bracket. hollow: whether the meniscus is more so than the ball at
    `reach`; then the ball rests there, but may touch farther in as well, and `trace` takes the
    higher of both.
    """
    if not hollow:
        first, second = _steepness(reach, contact, slope, roundness, flatness)
        if reach - radius * first / math.sqrt(1 + first * first) <= x:
            return reach
    low, high = x, reach
    blunt = 1 - 0.9 * radius * _steepness(0.0, contact, slope, roundness, flatness)[1]
    at = x if hollow else min(x / max(blunt, 0.12), reach)
    for _ in range(_TOUCH):
        first, second = _steepness(at, contact, slope, roundness, flatness)
        size = math.sqrt(1 + first * first)
        gap = at - radius * first / size - x
        if gap > 0:
            high = at
        else:
            low = at
        rate = 1 - radius * second / (size * size * size)
        if hollow and rate <= _LEAST_RATE:
            return reach
        moved = at - gap / rate if rate > _LEAST_RATE else (low + high) / 2
        if not low <= moved <= high:
            moved = (low + high) / 2
        if abs(moved - at) < _NEAR:
            return moved
        at = moved
    return at


@njit(error_model="numpy")
def _rounded(surface, out, slope, end, radius, rounding):
    """Return a surface with the arc of ball and rounded prism tip over its end."""
    whole = radius + rounding
    if whole == 0:
        return surface
    steep = max(slope, 0.0)
    size = math.sqrt(1 + steep * steep)
    if out >= whole * steep / size:
        return surface
    return end - rounding * size + math.sqrt(max(whole * whole - out * out, 0.0)) - radius


@njit(error_model="numpy")
def _over_tip(out, slope, depth, radius, flank, rounding):
    """Return the trace of a prism tip alone, at a distance from its axis."""
    whole, size = radius + rounding, math.sqrt(1 + flank * flank)
    centre = depth - rounding * math.sqrt(1 + slope * slope) - radius
    if out < whole * flank / size:
        return centre + math.sqrt(max(whole * whole - out * out, 0.0))
    return centre + whole * size - flank * out


@kept
@njit(error_model="numpy")
def trace(
    x, number, contact, level, slope, roundness, flatness, groove, ideal, tip, touch, known, height
):
    """Fill `height` (n,) [mm] with what a tip traces at x (n,) [mm] from a groove's centre.

    number: (n,) int64, which of the menisci `contact`, `level`, `slope` (m,) lies there. groove:
    half width, depth, slope of the walls. ideal: no walls beside the resin. tip: radius, flank
    slope, rounding of the prism tips. touch: (n,), where the tip touches the resin, taken where
    it is `known`, else filled.
    """
    half, depth, steep = groove
    radius, flank, rounding = tip
    pointed = radius == 0 and flank == math.inf
    over = radius * (math.sqrt(1 + steep * steep) - 1)
    last, reach, edge, hollow = -1, 0.0, 0.0, False
    for i in range(len(x)):
        at, n = abs(x[i]), number[i]
        out = half - at
        if n != last:
            last, reach = n, _reach(contact[n], slope[n], roundness, flatness, flank)
            edge = _height(reach, contact[n], level[n], slope[n], roundness, flatness)
            hollow = radius > 0 and _is_hollow(
                reach, contact[n], slope[n], roundness, flatness, radius
            )
        lies = contact[n], level[n], slope[n], roundness, flatness
        if not known:
            touch[i] = min(at, reach)
            if radius > 0:
                touch[i] = _touch(at, lies[0], lies[2], roundness, flatness, radius, reach, hollow)
        on = min(touch[i], contact[n])
        resin = _height(on, *lies)
        if pointed:
            resin += slope[n] * (at - on)
        else:
            resin -= _tip_height(abs(on - at), radius, flank)
            if hollow and on < reach:
                there = edge - _tip_height(abs(reach - at), radius, flank)
                if there > resin:
                    resin = there
                    if not known:
                        touch[i] = reach
        end = level[n] + slope[n] * (half - contact[n])
        resin = _rounded(resin, abs(out), min(slope[n], flank), end, radius, rounding)
        if ideal:
            if slope[n] > flank:
                resin = max(resin, _over_tip(out, slope[n], depth, radius, flank, rounding))
        elif steep > flank:
            resin = max(resin, _over_tip(out, steep, depth, radius, flank, rounding))
        else:
            wall = steep * at + over
            resin = max(resin, _rounded(wall, abs(out), steep, depth, radius, rounding))
        height[i] = resin
