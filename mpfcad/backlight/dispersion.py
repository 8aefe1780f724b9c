"""Values that depend on the wavelength, at the stack's wavelength.

An index may be given by its material: `{ cauchy = [A, B, C] }` is n = A + B/λ² + C/λ⁴,
`{ sellmeier = [B1, C1, B2, C2, …] }` is n² = 1 + Σ B λ²/(λ² - C) (W. Sellmeier, 1871), λ in µm.
`{ table_nm = [[450, 1.51], …] }` is linear between its wavelengths; an absorption coefficient, a
reflectance or a transmission may be such a table too.
"""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from mpfcad.errors import InputError

LAWS = ("cauchy", "sellmeier", "table_nm")
#: Ends of the names of values that may follow a law, and the laws that they may follow.
SPECTRAL = {
    "index": LAWS,
    "absorption_per_mm": ("table_nm",),
    "reflectance": ("table_nm",),
    "transmission": ("table_nm",),
    "absorptance": ("table_nm",),
}
#: Where a stack states no wavelength.
DEFAULT_WAVELENGTH_NM = 550.0
_MOST = 10
#: Ends of the names of shares of the light, 0 … 1.
_SHARES = ("reflectance", "transmission", "absorptance")


def dispersed(
    where: str, key: str, entry: Any, wavelength_nm: object, of: str = "light_wavelength_nm"
) -> Any:
    """Return an entry as `read_quantity` takes it: a law of dispersion as its number.

    `of` says where the wavelength comes from.

    Raises
    ------
    InputError
        when the law is no law, its numbers are none, or the wavelength is none.
    """
    if not isinstance(entry, Mapping) or not set(entry) & set(LAWS):
        return entry
    laws = sorted(set(entry) & set(LAWS))
    known = next((SPECTRAL[end] for end in SPECTRAL if key.endswith(end)), ())
    if laws[0] not in known or len(laws) > 1 or "value" in entry:
        expected = f"one of {', '.join(known)}" if known else "a number"
        raise InputError(f"{where}.{key}: {', '.join(sorted(entry))}: expected {expected}")
    if isinstance(wavelength_nm, Mapping):
        wavelength_nm = wavelength_nm.get("value")
    if not isinstance(wavelength_nm, int | float) or isinstance(wavelength_nm, bool):
        raise InputError(
            f"{where}.{key}: {laws[0]}: light_wavelength_nm {wavelength_nm!r}: expected a number"
        )
    at = f"{where}.{key}: {laws[0]}"
    number = _number(at, key, laws[0], entry[laws[0]], float(wavelength_nm), of)
    rest = {name: value for name, value in entry.items() if name not in LAWS}
    said = f"{laws[0]} at {wavelength_nm:g} nm"
    return {**rest, "value": number, "source": f"{rest.get('source', 'given by the user')}; {said}"}


def _check_rows(where: str, key: str, rows: np.ndarray) -> None:
    """Raise unless every value of a table can be one, also where the wavelength is not."""
    least = 1.0 if key.endswith("index") else 0.0
    most = 1.0 if key.endswith(_SHARES) else math.inf
    for number, (wavelength, value) in enumerate(rows, 1):
        if not least <= value <= most:
            expected = f"{least:g} … {most:g}" if most < math.inf else f"{least:g} or more"
            raise InputError(
                f"{where}: row {number}: {value:g} at {wavelength:g} nm: expected {expected}"
            )


def _number(
    where: str, key: str, law: str, numbers: object, wavelength_nm: float, of: str
) -> float:
    """Return the value that a law has at a wavelength; `key` names what it is of."""
    try:
        values = np.array(numbers, float)
    except (TypeError, ValueError):
        values = np.array([])
    rows = 2 if law == "table_nm" else 1
    if not (0 < values.size <= 1000 and values.ndim == rows and np.isfinite(values).all()):
        raise InputError(f"{where}: {numbers!r}: expected numbers")
    square = (wavelength_nm / 1000) ** 2
    if law == "cauchy" and len(values) <= _MOST:
        return float(sum(a / square**k for k, a in enumerate(values)))
    if law == "sellmeier" and len(values) % 2 == 0 and len(values) <= _MOST:
        terms = values.reshape(-1, 2)
        if (terms[:, 1] == square).any():
            raise InputError(
                f"{where}: {numbers!r}: resonance at the wavelength {wavelength_nm:g} nm"
            )
        return math.sqrt(max(0.0, 1 + float((terms[:, 0] * square / (square - terms[:, 1])).sum())))
    if law == "table_nm" and values.shape[1] == 2 and (np.diff(values[:, 0]) > 0).all():
        if not values[0, 0] <= wavelength_nm <= values[-1, 0]:
            raise InputError(
                f"{where}: {values[0, 0]:g} … {values[-1, 0]:g} nm: does not cover "
                f"{of} {wavelength_nm:g}"
            )
        _check_rows(where, key, values)
        return float(np.interp(wavelength_nm, values[:, 0], values[:, 1]))
    expected = {
        "cauchy": "A, B, C", "sellmeier": "pairs B, C", "table_nm": "rising [wavelength, value]",
    }  # fmt: skip
    raise InputError(f"{where}: {numbers!r}: expected {expected[law]}")
