"""The cups of a board's LEDs: what a stack file may say of them."""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mpfcad.backlight.source.lattice import first_pair, overlap
from mpfcad.backlight.source.protocol import StackValues
from mpfcad.errors import InputError

if TYPE_CHECKING:
    from mpfcad.optics.cavity.board import Cup

SQUARE = "square"
_HEIGHT, _RADIUS, _RIM = "led_cup_height_mm", "led_cup_radius_mm", "led_cup_rim_radius_mm"


def check_cups(
    where: str,
    stack: StackValues,
    shape: str,
    led: NDArray[np.float64],
    period: tuple[float, float],
    size: tuple[float, float],
) -> None:
    """Raise unless each LED stands in a cup of its own under the stack.

    led: (l, 3) float64 [mm], places of the cell's LEDs of a size [mm]; the cell repeats after
    `period` [mm].

    Raises
    ------
    InputError
        that begins with `where`, naming the value and what is expected.
    """
    if not shape:
        given = [key for key in (_HEIGHT, _RADIUS) if stack[key] > 0]
        if given:
            raise InputError(
                f"{where}: {given[0]}: {stack[given[0]]:g}: expected source.cup, round or square, "
                "beside it"
            )
        return
    height, top, thickness = stack[_HEIGHT], stack["led_height_mm"], stack["thickness_mm"]
    if height <= 0 or not top <= height < thickness:
        raise InputError(
            f"{where}: {_HEIGHT}: {height:g}: expected above 0, the LEDs' {top:g} mm or more, "
            f"below thickness_mm {thickness:g}"
        )
    radius, rim = stack[_RADIUS], stack[_RIM]
    least = max(size) / 2 if shape == SQUARE else math.hypot(*size) / 2
    if radius < least:
        raise InputError(
            f"{where}: {_RADIUS}: {radius:g}: expected {least:.4g} or more, round an LED of "
            f"{size[0]:g} × {size[1]:g} mm"
        )
    if rim < radius:
        raise InputError(f"{where}: {_RIM}: {rim:g}: expected led_cup_radius_mm {radius:g} or more")
    both = _touching(shape, led, period, rim)
    if both:
        raise InputError(
            f"{where}: {_RIM}: {rim:g}: cups of LEDs {both[0]} and {both[1]} overlap: expected "
            "less, or LEDs further apart"
        )


def _touching(
    shape: str, led: NDArray[np.float64], period: tuple[float, float], rim: float
) -> tuple[int, int] | None:
    """Return the numbers of two LEDs whose cups overlap (1, 1: in two cells), or None."""
    size = 2 * rim * (1 - 1e-9)  # cups may touch
    if shape == SQUARE:
        return overlap(led, period, (size, size))
    if size > min(period):
        return 1, 1
    return first_pair(led, period, lambda away: np.hypot(away[:, 0], away[:, 1]) < size)


def lower_cup(stack: StackValues, shape: str) -> "Cup | None":
    """Return the cup of each LED; None of a board without."""
    from mpfcad.optics.cavity.board import Cup

    if not shape:
        return None
    return Cup(
        stack[_HEIGHT], stack[_RADIUS], stack[_RIM], stack["led_cup_reflectance"],
        stack["led_cup_specular_fraction"], shape == SQUARE,
    )  # fmt: skip
