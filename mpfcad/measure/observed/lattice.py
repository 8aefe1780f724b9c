"""Which way a lattice of spots is turned, where it is turned far."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from mpfcad.measure.observed.image import LuminanceImage
from mpfcad.measure.observed.spectrum import spectrum_of

#: Turns [rad] that `askew` finds by itself.
_NEAR = math.radians(10.0)
#: Waves are looked at in steps of a fourth; along a side to so many waves upright on it.
_FINER, _SIDE = 4, 0.3
#: A wave's power over that of noise, and over that of any wave along the image's sides.
_SHOWN, _OVER = 20.0, 4.0
#: Two waves stand upright on each other within this angle [rad].
_UPRIGHT = math.radians(3.0)


def lattice_turn(image: LuminanceImage) -> float | None:
    """Return by what angle [rad], ±π/4, the rows of a lattice of spots are turned; None if upright.

    The strongest wave of the image's spectrum and the strongest upright on it are the lattice's,
    where both stand out of the noise, and waves along the image's sides are weaker.
    """
    waves = spectrum_of(replace(image, straight=image.luminance, rotation=0.0), _FINER)
    angle, power = waves.angle, waves.power
    sides = np.minimum(np.abs(waves.across), np.abs(waves.along)) <= _SIDE
    first = int(np.argmax(power))
    turn = float(angle.flat[first])
    off = np.abs((angle - turn + np.pi) % np.pi - np.pi / 2)
    second = int(np.argmax(np.where(off < _UPRIGHT, power, 0)))
    least = min(float(power.flat[first]), float(power.flat[second]))
    beside = float(np.max(np.where(sides, power, 0)))
    turn = (turn + np.pi / 4) % (np.pi / 2) - np.pi / 4
    if least < _SHOWN * waves.noise or least < _OVER * beside or abs(turn) < _NEAR:
        return None
    return turn


def lattice_words(path: Path, image: LuminanceImage) -> str:
    """Return by what spots are turned, and what sets them right; "" where they are upright."""
    turn = lattice_turn(image)
    if turn is None:
        return ""
    turned = math.degrees(image.rotation) + 90 * image.quarters
    after = f" after --rotation-deg {turned:g}" if turned else ""
    right = turned + math.degrees(turn)
    return (
        f"{path}: the rows of spots run {math.degrees(turn):+.1f}° askew{after}: expected upright "
        f"ones: --rotation-deg {(right + 90) % 180 - 90:.1f}"
    )
