"""Owen-scrambled Sobol numbers: the first draws of a path, spread evenly over those of its block.

The points of Sobol (1967), with the direction numbers of Joe and Kuo ("Constructing Sobol sequences
with better two-dimensional projections", 2008), are scrambled by nested permutations of their
binary digits (Owen, "Randomly permuted (t,m,s)-nets and (t,s)-sequences", 1995). The permutations
come from a hash in which each bit of the reversed number changes higher bits only (Laine and
Karras, "Stratified sampling for stochastic transparency", 2011; Burley, "Practical hash-based Owen
scrambling", 2020). Each point is uniform, each net independent of all others: the spread of the
nets' means gives the standard error.

Kernels here take a plain number or eight.
"""

import numpy as np

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import reversed_bits
from mpfcad.optics.base.lanes_array import gather

#: Points of a net, and how many of a path's draws come from it.
NET = 512
DIMENSIONS = 12
_DIGITS = 10
#: Degree, coefficients and first direction numbers of dimensions 2 and on (Joe and Kuo, 2008).
_JOE_KUO = (
    (1, 0, (1,)),
    (2, 1, (1, 3)),
    (3, 1, (1, 3, 1)),
    (3, 2, (1, 1, 1)),
    (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
    (5, 2, (1, 1, 5, 5, 17)),
    (5, 4, (1, 1, 5, 5, 5)),
    (5, 7, (1, 1, 7, 11, 19)),
    (5, 11, (1, 1, 5, 1, 1)),
    (5, 13, (1, 1, 1, 3, 11)),
)


def direction_numbers(dimension: int) -> list[int]:
    """Return the binary fractions of 2⁻¹⁰ that the index's bits add, lowest first."""
    if dimension == 0:
        return [1 << (_DIGITS - 1 - i) for i in range(_DIGITS)]
    degree, coefficients, first = _JOE_KUO[dimension - 1]
    m = list(first)
    for i in range(degree, _DIGITS):
        value = m[i - degree] ^ (m[i - degree] << degree)
        for k in range(1, degree):
            if coefficients >> (degree - 1 - k) & 1:
                value ^= m[i - k] << k
        m.append(value)
    return [value << (_DIGITS - 1 - i) for i, value in enumerate(m)]


def _points() -> np.ndarray:
    """Return the digits of all coordinates of a net's points, (2 · points,) uint64.

    Two words a point, six dimensions of ten digits in each, the lowest dimension in the lowest
    bits; digits are in reverse, the first one lowest.
    """
    table = np.zeros((NET, 2), np.uint64)
    index = np.arange(NET)
    for d in range(DIMENSIONS):
        for bit, number in enumerate(direction_numbers(d)):
            digits = int(f"{number:010b}"[::-1], 2) << (d % _A_WORD * _DIGITS)
            table[index >> bit & 1 == 1, d // _A_WORD] ^= np.uint64(digits)
    return table.reshape(-1)


_A_WORD = 6
_POINTS = _points()
_1, _6, _8, _10, _29, _32, _43, _1023, _LAST = (
    np.uint64(n) for n in (1, 6, 8, 10, 29, 32, 43, 2**_DIGITS - 1, len(_POINTS) - 1)
)
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX0, _MIX1 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
#: Even: a bit then changes higher bits only.
_EVEN0, _EVEN1, _EVEN2 = (
    np.uint64(n) for n in (0x6C50B47C3D20ADEA, 0x2F1C9D6405526C56, 0x1D8E4E2753A22864)
)


@kernel
def scrambled(digits, seed):
    """Return reversed digits after the nested permutation that a seed chooses."""
    x = digits ^ (digits * _EVEN0)
    x = (x + seed) * ((seed >> _32) | _1)
    x = x ^ (x * _EVEN1)
    return x ^ (x * _EVEN2)


@kernel
def net_bits(key, index, dimension):
    """Return the 64 binary digits of one coordinate of a net's point, the first one highest."""
    word = (dimension * _43) >> _8  # A sixth of it.
    # Of eight paths some may be past the net. What they get is not used, but it is looked up: it
    # has to lie in the table.
    place = ((index << _1) + word) & _LAST
    digits = gather(_POINTS, place) >> ((dimension - word * _6) * _10)
    digits = digits & _1023
    seed = key + dimension * _GOLDEN
    seed = (seed ^ (seed >> _32)) * _MIX0
    seed = (seed ^ (seed >> _29)) * _MIX1
    return reversed_bits(scrambled(digits, seed ^ (seed >> _32)))
