"""mpfcad: from a curvature map to a verified multi-performance film.

The floors, from the bottom: `units` and `errors`; `film` (what the film is); `mask`, `cad` and
`optics` (what is made of it, and how it is traced); `backlight`; `measure`; `report`; and at the
top `job`, `pipeline` and `cli`. Imports point down only; tests/test_floors.py holds it.
"""

__version__ = "0.1.0"
