"""One conversion table: mm and rad inside; outside, a name's suffix tells its unit.

Inside the package a quantity has no suffix. At the boundary (TOML, CSV, JSON, command line) every
name carries one of `SUFFIXES`, and `from_suffix` turns the outside value into the inside one.
"""

import math

#: Suffix of an outside name -> factor to the inside unit.
SUFFIXES = {
    "_um": 1e-3,
    "_nm": 1e-6,
    "_mm": 1.0,
    "_deg": math.pi / 180.0,
    "_per_mm": 1.0,
    "_cd_m2": 1.0,
}

um = SUFFIXES["_um"]
nm = SUFFIXES["_nm"]
mm = SUFFIXES["_mm"]
deg = SUFFIXES["_deg"]


def from_suffix(name: str, value: float) -> float:
    """Return `value` of the field `name` in inside units (mm, rad), by the suffix of `name`.

    Raises
    ------
    KeyError
        when `name` ends with no known suffix.
    """
    for suffix in sorted(SUFFIXES, key=len, reverse=True):
        if name.endswith(suffix):
            return value * SUFFIXES[suffix]
    raise KeyError(name)
