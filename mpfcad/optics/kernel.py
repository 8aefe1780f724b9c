"""How the kernels are compiled: one decorator for all of them.

Division follows IEEE (a vanishing direction component gives an infinite distance, not an error),
and the arrays' reference counts are left alone: counting them at every call took over half of the
time. Kernels therefore allocate nothing; what they need as scratch is handed in.
"""

from numba import njit

kernel = njit(error_model="numpy", _nrt=False, forceinline=True)
