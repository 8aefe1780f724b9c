"""Random numbers, directions and Fresnel's law have the same bits on every processor and system."""

import hashlib
import math

import numpy as np
from numba import njit, uint64

from mpfcad.optics.base.circle import circle
from mpfcad.optics.base.fresnel import fresnel
from mpfcad.optics.base.sampling import (
    RNG_SIZE,
    disk,
    gaussian_pair,
    henyey_greenstein_cosine,
    start_path,
    turn,
    uniform,
)
from mpfcad.store.kernel import kept

#: Found alike on x86-64 with AVX-512 and on an emulated aarch64.
DIGEST = {
    "gaussian": ("2aa233ae357c1a9b", "44c01da6fcae3252"),
    "disk": ("df694ae4fd2b9de9", "1223cc2da1aacf43"),
    "henyey-greenstein": ("5abb4103c2de1be4",),
    "turn": ("d2bc688cd7a3b222", "1a02277e49768ab5", "28e74ad01aa7efb5"),
    "circle": ("0473b3f3a1d4e338", "47460014a2f14154"),
    "fresnel": ("108f889a357a1637",),
}


@kept
@njit(error_model="numpy", _nrt=False)
def _draw(out, rng):
    """Fill out (n, 11) with what the kernels give of n paths' random numbers."""
    for i in range(len(out)):
        start_path(rng, uint64(5), uint64(1), uint64(i))
        out[i, 0], out[i, 1] = gaussian_pair(rng)
        x, y = disk(rng)
        z = math.sqrt(max(0.0, 1.0 - x * x - y * y))
        cosine = henyey_greenstein_cosine(0.8, uniform(rng))
        p, q, r = turn(x, y, z, cosine, uniform(rng))
        out[i, 2], out[i, 3], out[i, 4] = x, y, cosine
        out[i, 5], out[i, 6], out[i, 7] = p, q, r
        out[i, 8], out[i, 9] = circle(uniform(rng))
        out[i, 10] = fresnel(abs(r), 1.0 / 1.49)[0]


def test_kernels_have_the_bits_that_they_have_elsewhere():
    out = np.zeros((20_000, 11))
    _draw(out, np.zeros(RNG_SIZE, np.uint64))
    column = iter(out.T)
    for name, digests in DIGEST.items():
        for digest in digests:
            data = np.ascontiguousarray(next(column)).tobytes()
            assert hashlib.sha256(data).hexdigest()[:16] == digest, name
