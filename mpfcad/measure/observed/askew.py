"""Whether stripes, or a lattice of spots, run askew in an image after its stated rotation."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from mpfcad.errors import InputError
from mpfcad.measure.observed.curve import ObservedCurve, read_curve
from mpfcad.measure.observed.image import LuminanceImage
from mpfcad.measure.observed.spectrum import BLUR, spectrum_of
from mpfcad.measure.observed.stripe import curve_of_image, means_across

#: Angles [rad] to each side that are tried, their step, and how often the step is halved.
_MOST, _STEP, _FINER = math.radians(12.0), math.radians(0.25), 5
#: Pixels that are looked at for the angle.
_SAMPLE = 200_000
#: A mean over rows that are askew loses contrast: said from a thousandth, refused from 2 %.
_SAID, _REFUSED = 1e-3, 0.02
#: Standard deviations of noise that a gain of variance must exceed.
_CERTAIN = 5.0
#: Power of a wave that is not across over that of any across, or of noise.
_STEEP = 10.0
#: Stripes of less power beside bands than this share of theirs may be a window's leakage.
_FAINT = 1e-4


def read_stripes(
    path: Path, image: LuminanceImage | None, unit: str | None
) -> tuple[ObservedCurve, str]:
    """Return the curve of an image's stripes or of a file of text, and what is to be said of it.

    Raises
    ------
    InputError
        when the file cannot be read, or the stripes run too far askew.
    """
    if image is None:
        return read_curve(path, unit), ""
    curve = curve_of_image(image)
    return curve, askew_words(path, image, curve)


def askew_words(path: Path, image: LuminanceImage, curve: ObservedCurve) -> str:
    """Return what is to be said of stripes that run askew; "" where they run down the columns.

    Raises
    ------
    InputError
        when so much contrast is lost that the mean over the rows does not show it.
    """
    said = steep_words(path, image), _said(path, image, askew(image, curve), "stripes")
    return "; ".join(words for words in said if words)


def spots_askew_words(path: Path, image: LuminanceImage) -> str:
    """Return what is to be said of a lattice of spots that is turned; "" where it is upright.

    Its columns and its rows are looked at as stripes are.

    Raises
    ------
    InputError
        when so much contrast is lost that the mean cell does not show it.
    """
    upright = replace(image, straight=image.luminance, rotation=0.0)
    lying = replace(upright, straight=upright.straight.T)
    columns, rows = (askew(each, curve_of_image(each)) for each in (upright, lying))
    turned = [columns, None if rows is None else (-rows[0], rows[1])]
    worst = max((each for each in turned if each is not None), key=lambda e: e[1], default=None)
    return _said(path, image, worst, "rows of spots")


def _said(path: Path, image: LuminanceImage, off: tuple[float, float] | None, what: str) -> str:
    if off is None:
        return ""
    angle, loss = off
    hidden = f"which hides {loss:.1%} of the contrast"
    words = f"{_words(image, what, angle)} {hidden}: {_mend(image, angle)}"
    if loss > _REFUSED:
        raise InputError(f"{path}: {words}")
    return words


def _words(image: LuminanceImage, what: str, angle: float) -> str:
    turned = math.degrees(image.rotation) + 90 * image.quarters
    after = f" after --rotation-deg {turned:g}" if turned else ""
    return f"the {what} run {math.degrees(angle):+.2f}° askew{after},"


def _mend(image: LuminanceImage, angle: float) -> str:
    """Return the rotation that sets them right, within half a turn."""
    turn = math.degrees(image.rotation + angle) + 90 * image.quarters
    return f"expected --rotation-deg {(turn + 90) % 180 - 90:.2f}"


def steep_words(path: Path, image: LuminanceImage) -> str:
    """Return what is to be said of waves that run far from across; "" where there are none.

    Raises
    ------
    InputError
        when they are all that the image shows.
    """
    waves = spectrum_of(image)
    angle = (waves.angle - image.rotation + np.pi / 2) % np.pi - np.pi / 2
    # A window blurs by a bin or two: across is what lies within the angles tried, or beside them.
    off = np.abs(np.hypot(waves.across, waves.along) * np.sin(angle)) > BLUR
    steep = (np.abs(angle) > _MOST) & off
    at = int(np.argmax(np.where(steep, waves.power, 0)))
    most, across = float(waves.power.flat[at]), float(np.max(np.where(steep, 0, waves.power)))
    if most < _STEEP * max(across, 2 * float(waves.power.mean())):
        return ""
    turn, length = float(angle.flat[at]), waves.length(at) * image.pixel
    if abs(turn) < np.pi / 2 - _MOST:
        words = f"{_words(image, 'stripes', turn)} which leaves none across"
        raise InputError(f"{path}: {words}: {_mend(image, turn)}")
    bands = f"bands of {length:.3g} mm run along x, upright on lamps along y"
    if across < max(_STEEP * waves.noise, _FAINT * most):
        raise InputError(
            f"{path}: {bands}, and no stripes are seen beside them: {_mend(image, turn)} where the "
            "bands are the lamps"
        )
    return f"{bands}: they are averaged over, and not judged"


def askew(image: LuminanceImage, curve: ObservedCurve) -> tuple[float, float] | None:
    """Return by what angle [rad] the stripes are askew still, and the share of contrast it hides.

    The angle is that at which the means across vary most, beyond what noise may do; None without.
    """
    part = max(1, round(math.sqrt(image.straight.size / _SAMPLE)))
    steepest, width = _MOST + abs(image.rotation), image.straight.shape[1]
    # So few rows that six tenths of the width are seen at every angle.
    most = int(width * min(1.0, (math.cos(steepest) - 0.3) / math.sin(steepest)))
    rows = min(len(image.straight), most) // part * part
    first = (len(image.straight) - rows) // 2
    # Means of a few rows keep what a step of rows would throw away of the noise.
    seen = image.straight[first : first + rows].reshape(-1, part, image.straight.shape[1])
    seen = seen.mean(axis=1)
    noise = float(np.mean(curve.error**2))
    half = (width * math.cos(steepest) - rows * math.sin(steepest)) / 2 * image.pixel
    if half <= 0:
        return None

    def variance(angle: float) -> float:
        turn = image.rotation + angle
        position, mean, _ = means_across(seen, image.pixel, turn, float(part))
        centre = (width * math.cos(turn) - rows * math.sin(turn)) / 2 * image.pixel
        # The same stretch about the middle at every angle.
        near = np.abs(position - centre) <= half
        position, mean = position[near], mean[near]
        return float(np.var(mean - np.polyval(np.polyfit(position, mean, 2), position))) - noise

    here, step = variance(0.0), _STEP
    tried = np.arange(-_MOST, _MOST + step / 2, step)
    best = float(max(tried, key=variance))
    for _ in range(_FINER):
        step /= 2
        best = float(max((best - step, best, best + step), key=variance))
    top = variance(best)
    by_chance = noise * math.sqrt(2 / len(curve.position)) + 2 * math.sqrt(
        noise * max(top, 0.0) / len(curve.position)
    )
    if top - here < _CERTAIN * by_chance:
        return None
    loss = 1 - math.sqrt(max(here, 0.0) / top)
    return (best, loss) if loss > _SAID else None
