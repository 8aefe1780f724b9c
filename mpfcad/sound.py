"""What an object refuses when it is made: numbers out of their range, words that mean nothing."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from mpfcad.errors import InputError


def refuse_unsound(
    name: str,
    value: Any,
    low: float = -np.inf,
    high: float = np.inf,
    *,
    above: bool = False,
) -> None:
    """Refuse a number, or an array with a number, that is not finite or not in low … high.

    Parameters
    ----------
    name
        of the value, as its object calls it (`groove.pitch`)
    value
        a number or an array of any shape
    low, high
        the range; with `above`, `low` itself is refused

    Raises
    ------
    InputError
        naming the value, the first number that is wrong, and what was expected.

    Examples
    --------
    >>> refuse_unsound("groove.pitch", 0.05, 0.0, above=True)
    >>> refuse_unsound("groove.pitch", float("nan"), 0.0, above=True)
    Traceback (most recent call last):
    mpfcad.errors.InputError: groove.pitch: nan: expected a finite number above 0
    """
    values = np.asarray(value)
    if values.dtype.kind not in "fiu":
        raise InputError(f"{name}: {value!r}: expected a number")
    good = np.isfinite(values) & (values <= high)
    good &= values > low if above else values >= low
    if good.all():
        return
    place = np.unravel_index(int(np.argmin(good)), values.shape)
    at = f"[{', '.join(map(str, map(int, place)))}]" if values.ndim else ""
    floor = f" {'above' if above else 'from'} {low:g}" if low > -np.inf else ""
    top = f" up to {high:.9g}" if high < np.inf else ""
    raise InputError(f"{name}{at}: {values[place]:.9g}: expected a finite number{floor}{top}")


def refuse_unknown(name: str, value: object, known: Iterable[str]) -> None:
    """Refuse a word that is not one of those known.

    Raises
    ------
    InputError
        naming the value and the words that it can be.

    Examples
    --------
    >>> refuse_unknown("film.profile", "filed", ("filled", "ideal"))
    Traceback (most recent call last):
    mpfcad.errors.InputError: film.profile: 'filed': expected one of filled, ideal
    """
    words = tuple(known)
    if value not in words:
        raise InputError(f"{name}: {value!r}: expected one of {', '.join(words)}")
