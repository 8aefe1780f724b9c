"""Points of the unit circle by the share of a turn, for a number or eight: the same bits for both.

The standard library's sine is another one on every system and knows no lanes.
"""

import math

from mpfcad.optics.base.kernel import kernel
from mpfcad.optics.base.lanes import floor, select

_TURN = 2.0 * math.pi
#: Taylor coefficients of sine and cosine; up to an eighth of a turn the rest is below 1e-17.
_S3, _S5, _S7, _S9, _S11, _S13, _S15 = ((-1) ** k / math.factorial(2 * k + 1) for k in range(1, 8))
_C4, _C6, _C8, _C10, _C12, _C14, _C16 = ((-1) ** k / math.factorial(2 * k) for k in range(2, 9))


@kernel
def circle(share):
    """Return (cos, sin) of 2π · share, share in [0, 1]."""
    quarter = floor(4.0 * share + 0.5)
    a = _TURN * (share - 0.25 * quarter)
    q = a * a
    sine = _S9 + q * (_S11 + q * (_S13 + q * _S15))
    sine = a + a * (q * (_S3 + q * (_S5 + q * (_S7 + q * sine))))
    cosine = _C10 + q * (_C12 + q * (_C14 + q * _C16))
    cosine = 1.0 - (0.5 * q - (q * q) * (_C4 + q * (_C6 + q * (_C8 + q * cosine))))
    odd = (quarter == 1.0) | (quarter == 3.0)
    x, y = select(odd, sine, cosine), select(odd, cosine, sine)
    back = (quarter == 1.0) | (quarter == 2.0)
    low = (quarter == 2.0) | (quarter == 3.0)
    return select(back, -x, x), select(low, -y, y)
