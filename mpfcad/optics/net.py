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

from mpfcad.optics.kernel import kernel
from mpfcad.optics.lanes import reversed_bits
from mpfcad.optics.lanes_array import gather

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
    """Return what the low and the high five bits of an index add, (64 · dimensions,) uint64.

    Digits are in reverse, the first one in bit 0.
    """
    table = np.zeros((DIMENSIONS, 2, 32), np.uint64)
    for d in range(DIMENSIONS):
        numbers = [int(f"{n:010b}"[::-1], 2) for n in direction_numbers(d)]
        for half in range(2):
            for low in range(32):
                for bit in range(5):
                    if low >> bit & 1:
                        table[d, half, low] ^= np.uint64(numbers[5 * half + bit])
    return table.reshape(-1)


_POINTS = _points()
_1, _5, _6, _29, _31, _32 = (np.uint64(n) for n in (1, 5, 6, 29, 31, 32))
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
    row = dimension << _6
    digits = gather(_POINTS, row + (index & _31)) ^ gather(_POINTS, row + _32 + (index >> _5))
    seed = key + dimension * _GOLDEN
    seed = (seed ^ (seed >> _32)) * _MIX0
    seed = (seed ^ (seed >> _29)) * _MIX1
    return reversed_bits(scrambled(digits, seed ^ (seed >> _32)))
