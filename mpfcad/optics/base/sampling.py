"""Random numbers and the directions drawn with them: Philox, and first those of a net.

Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC11) keyed by the seed
and counted by (draw, stream, path): a path's numbers depend on nothing else, so results are the
same at any thread count. A path of a net (`net`) has its first draws from there.

A generator is an (8,) uint64 array `rng`: low and high word of the seed, low and high word of the
path, the stream, the next block of draws, the second number of the last block, and whether that is
unused. Blocks -12 … -1, modulo 2^64, are the draws from the net; until then the place of the second
number holds the net's key and, in its lowest bits, the point's index in it.
"""

import math

import numpy as np
from numba import uint64

from mpfcad.optics.base.circle import circle
from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import copy_sign, root
from mpfcad.optics.base.net import DIMENSIONS, NET, net_bits

_M0 = np.uint64(0xD2511F53)
_M1 = np.uint64(0xCD9E8D57)
_W0 = np.uint64(0x9E3779B9)
_W1 = np.uint64(0xBB67AE85)
_LOW = np.uint64(0xFFFFFFFF)
_32 = np.uint64(32)
_11 = np.uint64(11)
_TO_UNIT = 2.0**-53
_NET = np.uint64(NET)
_DIMENSIONS = np.uint64(DIMENSIONS)
#: The draw's place in the counter of the numbers that nets are scrambled by.
KEYS = _LOW

KEY0, KEY1, PATH0, PATH1, STREAM, BLOCK, SPARE, HAS_SPARE = range(8)
RNG_SIZE = 8


@kernel
def philox4x32(c0, c1, c2, c3, k0, k1):
    """Return the four 32-bit words (in uint64) of Philox4x32-10 at a counter and a key."""
    for _ in range(10):
        p0 = _M0 * c0
        p1 = _M1 * c2
        c0 = (p1 >> _32) ^ c1 ^ k0
        c1 = p1 & _LOW
        c2 = (p0 >> _32) ^ c3 ^ k1
        c3 = p0 & _LOW
        k0 = (k0 + _W0) & _LOW
        k1 = (k1 + _W1) & _LOW
    return c0, c1, c2, c3


@kernel
def start_path(rng, seed, stream, path):
    """Set `rng` to the first draw of a path: (8,) uint64; seed, stream, path uint64."""
    rng[KEY0] = seed & _LOW
    rng[KEY1] = seed >> _32
    rng[PATH0] = path & _LOW
    rng[PATH1] = path >> _32
    rng[STREAM] = stream
    rng[BLOCK] = uint64(0)
    rng[HAS_SPARE] = uint64(0)


@kernel
def start_net_path(rng, seed, stream, path, points):
    """Set `rng` to the first draw of a path whose block is a net, one for each of `points`.

    Paths go round the points; `NET` rounds are a block.
    """
    start_path(rng, seed, stream, path)
    turn = path // points
    block = turn // _NET
    net = block * points + path % points
    a, b, _, _ = philox4x32(KEYS, stream, net & _LOW, net >> _32, rng[KEY0], rng[KEY1])
    rng[SPARE] = (((a << _32) | b) & ~(_NET - uint64(1))) | (turn % _NET)
    rng[BLOCK] = uint64(0) - _DIMENSIONS


@kernel
def net_number(spare, block):
    """Return the 64 bits of a draw from a net by a generator's two entries (or eight of each)."""
    index = spare & (_NET - uint64(1))
    return net_bits(spare ^ index, index, block + _DIMENSIONS)


@kernel
def uniform(rng):
    """Return the path's next number, uniform in [0, 1) with 53 bits."""
    if rng[BLOCK] > _LOW:
        number = net_number(rng[SPARE], rng[BLOCK])
        rng[BLOCK] += uint64(1)
        return (number >> _11) * _TO_UNIT
    if rng[HAS_SPARE] != 0:
        rng[HAS_SPARE] = uint64(0)
        return (rng[SPARE] >> _11) * _TO_UNIT
    a, b, c, d = philox4x32(rng[BLOCK], rng[STREAM], rng[PATH0], rng[PATH1], rng[KEY0], rng[KEY1])
    rng[BLOCK] += uint64(1)
    rng[SPARE] = (c << _32) | d
    rng[HAS_SPARE] = uint64(1)
    return (((a << _32) | b) >> _11) * _TO_UNIT


@kernel
def gaussian_pair(rng):
    """Return two independent standard normal numbers (Box and Muller, 1958)."""
    radius = math.sqrt(-2.0 * math.log(1.0 - uniform(rng)))
    angle = 2.0 * math.pi * uniform(rng)
    return radius * math.cos(angle), radius * math.sin(angle)


@kernel
def disk_point(u, v):
    """Return the point of the unit disk that two uniform numbers choose (one, or eight each)."""
    radius = root(u)
    x, y = circle(v)
    return radius * x, radius * y


@kernel
def disk(rng):
    """Return a point uniform in the unit disk: the (kx, ky) of a Lambertian direction."""
    u = uniform(rng)
    return disk_point(u, uniform(rng))


@kernel
def henyey_greenstein_cosine(g, u):
    """Return the scattering cosine drawn by u in [0, 1) (Henyey and Greenstein, 1941).

    cos = (1 + g² - ((1-g²)/(1-g+2gu))²)/(2g); isotropic 2u-1 as g goes to 0. Its mean is g.
    """
    if abs(g) < 1e-6:
        return 2.0 * u - 1.0
    ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u)
    return min(1.0, max(-1.0, (1.0 + g * g - ratio * ratio) / (2.0 * g)))


@kernel
def henyey_greenstein_slope(g, cosine):
    """Return ∂ ln p/∂g of the density p = (1-g²)/(2 (1+g²-2g cos)^3/2) of a cosine."""
    return 3.0 * (cosine - g) / (1.0 + g * g - 2.0 * g * cosine) - 2.0 * g / (1.0 - g * g)


@kernel
def flight(thickness, scattering, z, dz, rng):
    """Return (drawn free path between scatterings, length to the face ahead) in a layer, both [mm].

    The free path is exponential of mean 1/scattering; without scattering it is inf and draws
    nothing.
    """
    to_face = math.inf
    if dz != 0.0:
        to_face = ((thickness if dz > 0.0 else 0.0) - z) / dz
    free = math.inf
    if scattering > 0.0:
        free = -math.log(1.0 - uniform(rng)) / scattering
    return free, to_face


@kernel
def turn(dx, dy, dz, cosine, azimuth):
    """Return the unit direction at polar `cosine` and `azimuth` [rad] about (dx, dy, dz)."""
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    return frame(dx, dy, dz, sine * math.cos(azimuth), sine * math.sin(azimuth), cosine)


@kernel
def frame(dx, dy, dz, p, q, cosine):
    """Return the unit direction (p, q, cosine) in the frame about (dx, dy, dz); one or eight.

    Frame without branches on the direction (Duff et al., JCGT 6, 2017).
    """
    sign = copy_sign(1.0, dz)
    a = -1.0 / (sign + dz)
    b = dx * dy * a
    x = p * (1.0 + sign * dx * dx * a) + q * b + cosine * dx
    y = p * sign * b + q * (sign + dy * dy * a) + cosine * dy
    z = -p * sign * dx - q * dy + cosine * dz
    norm = 1.0 / root(x * x + y * y + z * z)
    return x * norm, y * norm, z * norm
