"""Which way a cell of LEDs is traced: the word that asks for it, the line that tells of it."""

from typing import Any

from mpfcad.errors import InputError
from mpfcad.measure import Estimator, Lit
from mpfcad.pipeline.progress import Progress


def chosen_estimator(word: str, lit: Lit) -> Estimator:
    """Return the way to trace a cell of LEDs that a word names.

    Raises
    ------
    InputError
        when there is none of that name, or tubes light the stack and one is asked for.
    """
    known = [way.value for way in Estimator]
    if word not in known:
        raise InputError(f"--estimator: {word}: expected {', '.join(known[:-1])} or {known[-1]}")
    if word != Estimator.auto and not lit.is_cell:
        raise InputError(
            f"--estimator: {word}: {lit.stack.name} is lit by tubes, traced from the meter: "
            "expected a stack whose [source] is leds"
        )
    return Estimator(word)


def note_estimator(way: dict[str, Any] | None, progress: Progress) -> None:
    """Tell that a cell of LEDs was traced from the meter, and what its goal takes.

    `way` is what the record says of it; None of tubes.
    """
    if way is None or way["name"] != Estimator.backward:
        return
    more = way["paths_to_goal"]
    words = f": the contrast's goal takes about {more / 1e6:.3g} million paths" if more else ""
    progress.note(f"LEDs traced from the meter: {way['reason']}{words}")
