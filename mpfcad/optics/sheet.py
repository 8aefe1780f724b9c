"""A thin diffuser sheet: a Gaussian move of the direction cosines, accepted reciprocally.

The move (kx, ky) → (kx, ky) + (mx, my) has a density that is even in the move: one Gaussian, round
or of two widths about an axis, or that and a wider round one with a share of the light.
"""

import math

from mpfcad.optics.base.fresnel import fresnel, fresnel_slope
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.sampling import gaussian_pair, uniform
from mpfcad.optics.score.state import ACROSS as ACROSS_LOBE
from mpfcad.optics.score.state import ALONG, FACES, draw
from mpfcad.optics.score.state import SHARE as LOBE_SHARE
from mpfcad.optics.score.state import WIDE as WIDE_LOBE

#: The columns of a sheet in `Scene.parameter`: standard deviations along and across its axis, the
#: axis, and the wide lobe with its share of the moves.
SIGMA, INDEX, TRANSMISSION, ACROSS, COSINE, SINE, WIDE, SHARE = range(8)
DEPOLARISATION = 9


@kernel
def sheet_transmittance(cos_in, cos_out, index):
    """Return the share of light that two smooth faces pass, in at one angle, out at another.

    T = (1-R)(1-R')/(1-R R'), the sum over reflections to and fro; R, R' the Fresnel reflectances at
    the two directions outside. Symmetric in both, hence reciprocal; equal angles give (1-R)/(1+R).
    """
    first, _ = fresnel(cos_in, 1.0 / index)
    second, _ = fresnel(cos_out, 1.0 / index)
    return (1.0 - first) * (1.0 - second) / (1.0 - first * second)


@kernel
def sheet_move(parameter, rng):
    """Return a move (mx, my) of the direction cosines, drawn from `move_density`."""
    along, across = parameter[SIGMA], parameter[ACROSS]
    if parameter[SHARE] > 0.0 and uniform(rng) < parameter[SHARE]:
        along, across = parameter[WIDE], parameter[WIDE]
    u, v = gaussian_pair(rng)
    u, v = along * u, across * v
    if parameter[SINE] == 0.0:
        return u, v
    cosine, sine = parameter[COSINE], parameter[SINE]
    return cosine * u - sine * v, sine * u + cosine * v


@kernel
def _gaussian(u, v, along, across):
    """Return the density of a normal (u, v) with standard deviations along and across."""
    if along == across:
        move = (u * u + v * v) / (2.0 * along * along)
        return math.exp(-move) / (2.0 * math.pi * along * along)
    u, v = u / along, v / across
    return math.exp(-0.5 * (u * u + v * v)) / (2.0 * math.pi * along * across)


@kernel
def move_density(parameter, mx, my):
    """Return the density of moves, one of projected solid angle; no standard deviation may be 0."""
    cosine, sine = parameter[COSINE], parameter[SINE]
    u, v = mx, my
    if sine != 0.0:
        u, v = cosine * mx + sine * my, cosine * my - sine * mx
    density = _gaussian(u, v, parameter[SIGMA], parameter[ACROSS])
    share = parameter[SHARE]
    if share > 0.0:
        wide = _gaussian(u, v, parameter[WIDE], parameter[WIDE])
        density = (1.0 - share) * density + share * wide
    return density


@kernel
def move_scores(score, parameter, mx, my):
    """Score a drawn move: ∂ ln of `move_density` by the widths and the wide lobe's share."""
    if score is not None:
        cosine, sine = parameter[COSINE], parameter[SINE]
        u, v = cosine * mx + sine * my, cosine * my - sine * mx
        along, across, share = parameter[SIGMA], parameter[ACROSS], parameter[SHARE]
        narrow = 1.0
        if share > 0.0 and along > 0.0 and across > 0.0:
            # The share of each lobe in the density there.
            density = move_density(parameter, mx, my)
            wide, width = 0.0, parameter[WIDE]
            if width > 0.0:
                wide = share * _gaussian(u, v, width, width) / density
                draw(score, WIDE_LOBE, wide * ((u * u + v * v) / (width * width) - 2.0) / width)
            narrow = 1.0 - wide
            draw(score, LOBE_SHARE, wide / share - narrow / (1.0 - share))
        if along > 0.0:
            draw(score, ALONG, narrow * (u * u / (along * along) - 1.0) / along)
        if across > 0.0:
            draw(score, ACROSS_LOBE, narrow * (v * v / (across * across) - 1.0) / across)


@kernel
def face_score(score, index, cos_in, cos_out, passed, accepted):
    """Score that a direction was accepted, with the probability `passed`, or not: by the index."""
    if score is not None:
        a, _ = fresnel(cos_in, 1.0 / index)
        b, _ = fresnel(cos_out, 1.0 / index)
        both = 1.0 - a * b
        by_a, by_b = b / both - 1.0 / (1.0 - a), a / both - 1.0 / (1.0 - b)
        slope = fresnel_slope(cos_in, index) * by_a + fresnel_slope(cos_out, index) * by_b
        # ∂ ln T where it passes, ∂ ln (1-T) where it does not.
        draw(score, FACES, slope if accepted else -slope * passed / (1.0 - passed))


@kernel
def sheet_passage(parameter, dx, dy, dz, score, rng):
    """Scatter a ray at a thin sheet: (passed, dx, dy, dz).

    (kx, ky) moves by `sheet_move`: a kernel symmetric in the two directions in projected solid
    angle. A direction outside the unit disk, or not accepted by `sheet_transmittance`, is reflected
    as by a mirror.
    """
    move_x, move_y = sheet_move(parameter, rng)
    move_scores(score, parameter, move_x, move_y)
    kx, ky = dx + move_x, dy + move_y
    rest = 1.0 - kx * kx - ky * ky
    accept = uniform(rng)
    if rest <= 0.0:
        return False, dx, dy, -dz
    kz = math.sqrt(rest)
    passed = sheet_transmittance(abs(dz), kz, parameter[INDEX])
    face_score(score, parameter[INDEX], abs(dz), kz, passed, accept < passed)
    if accept >= passed:
        return False, dx, dy, -dz
    return True, kx, ky, math.copysign(kz, dz)
