"""Two records compared: bit for bit, but for what another processor's libraries round otherwise.

The tracer's sums, and all that is made of them by plain arithmetic, are the same bits on every
processor. What goes through LAPACK (the fit of the luminance) or numpy's trigonometry (angles of
facets) is not: its last bits depend on the vector unit. How far: a sum of n products is known to
n ε of its terms (Higham, "Accuracy and stability of numerical algorithms", 2002, chapter 3), and
the fit of 33 points has a condition number below 3000, so with ε = 1.1e-16

    |a - b| ≤ 33 · 3000 · ε · max(|a|, |b|) ≈ 1.1e-11 · max(|a|, |b|);

measured between AVX-512 and SSE3 code: 1.3e-13. A figure that is itself the rounding of a
difference (an error of volume of 1e-12) is compared within 1e-12, a thousandth of the smallest
limit of a gate.
"""

from dataclasses import dataclass, field
from typing import Any

from mpfcad.record.traced import PLACES

#: Largest relative and absolute difference that rounding explains.
RELATIVE, ABSOLUTE = 1.1e-11, 1e-12
#: What is never rounded otherwise: given, counted, or summed in a fixed order.
EXACT = frozenset(
    {"schema", "name", "verdict", "luminance", "energy", "paths", "provenance", "job", "inputs",
     "degrees_of_freedom"}
)  # fmt: skip
_EXACT_KEYS = frozenset({"limit", "marginal_limit", "outcome", "at_least"})


@dataclass(frozen=True)
class Rounded:
    """A figure whose last bits differ: where it stands, and by how much of its value."""

    place: str
    share: float


@dataclass
class Comparison:
    """What two records differ in: the first true difference, and what rounding explains."""

    difference: str | None = None
    rounded: list[Rounded] = field(default_factory=list)


def compare_records(stored: Any, found: Any) -> Comparison:
    """Return what a stored record and one that was found again differ in."""
    comparison = Comparison()
    comparison.difference = _differ(stored, found, "", False, comparison.rounded)
    return comparison


def _differ(stored: Any, found: Any, where: str, exact: bool, rounded: list[Rounded]) -> str | None:
    if isinstance(stored, dict) and isinstance(found, dict):
        for key in [*stored, *(key for key in found if key not in stored)]:
            place = f"{where}.{key}" if where else key
            if key not in stored or key not in found:
                return f"{place}: only in the {'file' if key in stored else 'new result'}"
            narrow = exact or key in _EXACT_KEYS or (key in EXACT and _is_table(where))
            difference = _differ(stored[key], found[key], place, narrow, rounded)
            if difference:
                return difference
        return None
    if isinstance(stored, list) and isinstance(found, list) and len(stored) == len(found):
        for number, (a, b) in enumerate(zip(stored, found, strict=True)):
            difference = _differ(a, b, f"{where}[{number}]", exact, rounded)
            if difference:
                return difference
        return None
    if type(stored) is type(found) and stored == found:
        return None
    if type(stored) is type(found) is float and not exact:
        off, size = abs(stored - found), max(abs(stored), abs(found))
        if off <= max(RELATIVE * size, ABSOLUTE):
            rounded.append(Rounded(where, off / size))
            return None
    return f"{where}: stored {stored!r}, found {found!r}"


def _is_table(where: str) -> bool:
    """Return whether the exact names count below a place: at the top, and in another stack's."""
    return where in PLACES
